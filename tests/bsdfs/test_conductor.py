"""Rough and smooth metal, GGX and Beckmann."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import bsdf_checks as checks
from support import mitsuba_bsdfs
from support.bsdf_checks import LOBES, NARROW, direction, f32, repeat, uniforms
from support.chi2 import significance

from pt_engine.bsdfs import conductor, conductor_beckmann
from pt_engine.bsdfs.base import Lobe

MODELS = {"ggx": conductor, "beckmann": conductor_beckmann}
GOLD = {"eta": f32(0.143, 0.375, 1.442), "k": f32(3.983, 2.386, 1.603)}
N_CHI2 = 2 * (len(LOBES) + len(NARROW))


def params(alpha_x: float, alpha_y: float | None, **fresnel: np.ndarray) -> conductor.Params:
    return conductor.Params(f32(alpha_x), None if alpha_y is None else f32(alpha_y), **fresnel)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(("ax", "ay", "cos", "phi"), LOBES)
def test_samples_follow_the_density(
    model: ModuleType, ax: float, ay: float | None, cos: float, phi: float
) -> None:
    assert checks.chi2(model, params(ax, ay), direction(cos, phi)) > significance(N_CHI2)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(("alpha", "ay", "cos", "phi"), NARROW)
def test_narrow_lobes_follow_the_density(
    model: ModuleType, alpha: float, ay: None, cos: float, phi: float
) -> None:
    """Looked at closely: a grid about the mirror direction that spans a few α."""
    p = checks.chi2_about_mirror(model, params(alpha, ay), direction(cos, phi), alpha)
    assert p > significance(N_CHI2)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(("ax", "ay", "cos", "phi"), [*LOBES, NARROW[0]])
def test_weight_is_value_over_pdf(
    model: ModuleType, ax: float, ay: float | None, cos: float, phi: float
) -> None:
    """1e-3: the half vector, found again from float32 directions, errs by 1e-7/α of its slope."""
    rtol = 1e-3 if min(ax, ay or ax) >= 0.05 else 1e-2
    checks.check_weight_is_value_over_pdf(model, params(ax, ay, **GOLD), direction(cos, phi), rtol)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize("alpha", [0.0, 0.05, 0.3, 1.0])
@pytest.mark.parametrize("cos", [0.01, 0.3, 1.0])
def test_white_furnace_gains_nothing(model: ModuleType, alpha: float, cos: float) -> None:
    """G2/G1 ≤ 1, and a mirror loses nothing. 1e-6: float32's rounding of the mean."""
    albedo = checks.directional_albedo(model, params(alpha, None), direction(cos), rows=64, choices=1)
    assert albedo.max() <= 1 + 1e-6
    if alpha == 0:
        assert albedo.min() >= 1 - 1e-6


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(list(MODELS)),
    st.floats(0.01, 1),
    st.floats(0.01, 1),
    st.floats(0.01, 1),
    st.floats(0.01, 1),
    st.floats(0, 7),
)
def test_reciprocal(name: str, ax: float, ay: float, cos_i: float, cos_o: float, phi: float) -> None:
    """f(wi, wo) = f(wo, wi): both sides see the same half vector, so only the masking's rounding differs."""
    wi, wo, p = direction(cos_i, 0.4), direction(cos_o, phi), params(ax, ay, **GOLD)
    there, back = (MODELS[name].eval_pdf(p, a, b)[0] / b[2] for a, b in ((wi, wo), (wo, wi)))
    np.testing.assert_allclose(there, back, rtol=1e-5, atol=1e-30)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(
    "alpha", [(0.0, None), (1e-8, None), (2e-5, None), (1e-3, 1.0), (1.0, 1e-3), (1.0, None)]
)
def test_hostile_numbers_stay_finite(model: ModuleType, alpha: tuple[float, float | None]) -> None:
    for fresnel in ({}, GOLD, {"eta": f32(0.0, 1e-3, 100.0), "k": f32(0.0, 100.0, 0.0)}):
        checks.check_finite(model, params(*alpha, **fresnel))
    checks.check_finite(model, params(*alpha, color=f32(0.0, 0.5, 1.0), edge_tint=f32(0.0, 0.5, 1.0)))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_lanes_are_independent(model: ModuleType) -> None:
    for alpha in ((0.3, None), (0.3, 0.1), (0.0, None)):
        checks.check_lanes_are_independent(model, params(*alpha, **GOLD))
        checks.check_lanes_are_independent(
            model, params(*alpha, color=f32(0.1, 0.5, 1.0), edge_tint=f32(0.3, 0.5, 1.0))
        )


def test_mirror_is_a_dirac_lobe() -> None:
    wi = repeat(direction(0.6, 1.0), 8)
    s = conductor.sample(params(0.0, None), wi, *uniforms(8))
    np.testing.assert_allclose(s.wo, wi * np.array([[-1], [-1], [1]], np.float32), atol=5e-7)  # rounding
    assert s.lobe == Lobe.DELTA
    assert (s.pdf == 1).all()
    assert not conductor.eval_pdf(params(0.0, None), wi, s.wo)[1].any()


def test_rough_and_smooth_lanes_keep_apart() -> None:
    """One array of roughness: the Dirac lanes are the mirror's, the others as if alone."""
    alpha = np.array([0.0, 0.3, 1e-6, 0.1], np.float32)
    wi, u = repeat(direction(0.6, 1.0), 4), uniforms(4)
    s = conductor.sample(conductor.Params(alpha), wi, *u)
    assert list(np.asarray(s.lobe)) == [Lobe.DELTA, Lobe.GLOSSY, Lobe.DELTA, Lobe.GLOSSY]
    for k in range(4):
        alone = conductor.sample(params(float(alpha[k]), None), wi[:, :1], *u[:, k : k + 1])
        np.testing.assert_array_equal(s.wo[:, k], alone.wo[:, 0])
        assert s.pdf[k] == alone.pdf[0]


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("alpha", [(0.1, 0.1), (0.6, 0.6), (0.5, 0.15)])
def test_agrees_with_mitsuba(name: str, alpha: tuple[float, float]) -> None:
    """Values and densities, the masking's form aside. Mitsuba's G1 of Beckmann is a fit good to 0.4 %."""
    plugin = {
        "type": "roughconductor",
        "distribution": name,
        "alpha_u": alpha[0],
        "alpha_v": alpha[1],
        "eta": {"type": "rgb", "value": [0.143, 0.375, 1.442]},
        "k": {"type": "rgb", "value": [3.983, 2.386, 1.603]},
    }
    rng = np.random.default_rng(2)
    wi = np.concatenate([direction(c, p) for c, p in rng.random((40, 2)) * [1, 6.3]], axis=1)
    p = params(*alpha, **GOLD)
    wo = MODELS[name].sample(p, wi, *uniforms(40)).wo
    wo[2] = np.abs(wo[2])
    value, pdf = MODELS[name].eval_pdf(p, wi, wo)
    theirs, their_pdf = mitsuba_bsdfs.evaluate(plugin, wi, wo)
    theirs *= mitsuba_bsdfs.correlated_over_separable(name, wi, wo, alpha)
    rtol = 2e-3 if name == "ggx" else 1e-2
    np.testing.assert_allclose(pdf, their_pdf, rtol=rtol, atol=1e-6)
    np.testing.assert_allclose(value, theirs, rtol=rtol, atol=1e-6)
