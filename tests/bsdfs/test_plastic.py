"""Rough and smooth plastic."""

from __future__ import annotations

import numpy as np
import pytest
from support import bsdf_checks as checks
from support import mitsuba_bsdfs
from support.bsdf_checks import direction, f32, repeat, uniforms
from support.chi2 import significance

from pt_engine.bsdfs import energy, plastic
from pt_engine.bsdfs.base import Lobe

BLUE = f32(0.1, 0.3, 0.9)
CASES = [(0.0, 0.6), (0.05, 0.9), (0.3, 0.2), (1.0, 0.7)]


def params(alpha: float, **more: np.ndarray) -> plastic.Params:
    return plastic.Params(f32(alpha), f32(1.49), BLUE, **more)


@pytest.mark.parametrize(("alpha", "cos"), CASES)
def test_samples_follow_the_density(alpha: float, cos: float) -> None:
    assert checks.chi2(plastic, params(alpha), direction(cos)) > significance(len(CASES))


@pytest.mark.parametrize(("alpha", "cos"), CASES)
def test_weight_is_value_over_pdf(alpha: float, cos: float) -> None:
    checks.check_weight_is_value_over_pdf(plastic, params(alpha), direction(cos), rtol=1e-5)


@pytest.mark.parametrize("nonlinear", [0.0, 1.0])
@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.6])
@pytest.mark.parametrize("cos", [0.1, 0.5, 1.0])
def test_white_furnace_gains_nothing(alpha: float, cos: float, nonlinear: float) -> None:
    """White plastic, smooth, keeps all; rough loses what hits two facets. 1 %: the tables' interpolation."""
    white = plastic.Params(f32(alpha), f32(1.5), f32(1.0, 1.0, 1.0), None, f32(nonlinear))
    albedo = checks.directional_albedo(plastic, white, direction(cos), rows=64)
    assert albedo.max() <= 1.01
    if alpha == 0:
        assert albedo.min() >= 0.99


@pytest.mark.parametrize("eta", [1.0001, 1.001, 1.01, 1.05, 1.5, 3.0])
@pytest.mark.parametrize("cos", [1e-3, 0.01, 0.03, 0.1, 0.5])
def test_white_smooth_plastic_keeps_all_at_any_index_and_angle(eta: float, cos: float) -> None:
    """F + T = 1 down to grazing, where T falls within less than a table's cell. 0.6 %: R is interpolated."""
    white = plastic.Params(f32(0.0), f32(eta), f32(1.0, 1.0, 1.0), None, f32(1.0))
    albedo = checks.directional_albedo(plastic, white, direction(cos), rows=64)
    np.testing.assert_allclose(albedo, 1.0, atol=6e-3)


@pytest.mark.parametrize("eta", [1.0001, 1.001, 1.01, 1.5])
@pytest.mark.parametrize("cos", [1e-3, 0.01, 0.1, 0.5])
def test_almost_smooth_plastic_gains_little_at_grazing(eta: float, cos: float) -> None:
    """Within the first cell of roughness T is a mixture: at cosθ ≤ 0.01 up to 0.18 too much, not 0.8."""
    white = plastic.Params(f32(0.003), f32(eta), f32(1.0, 1.0, 1.0), None, f32(1.0))
    albedo = checks.directional_albedo(plastic, white, direction(cos), rows=64)
    assert albedo.max() <= (1.2 if cos < 0.05 else 1.01)


def test_smooth_coat_reflects_as_a_mirror() -> None:
    wi = repeat(direction(0.5), 1000)
    s = plastic.sample(params(0.0), wi, *uniforms(1000))
    mirror = np.asarray(s.lobe) == Lobe.DELTA
    assert 0 < mirror.mean() < 1
    assert (np.asarray(s.lobe)[~mirror] == Lobe.DIFFUSE).all()
    np.testing.assert_allclose(s.wo[0, mirror], -wi[0, mirror], atol=1e-6)
    # weight · probability is F(θ) = 0.0902 at η = 1.49, cosθ = 0.5
    np.testing.assert_allclose((s.weight[0] * s.pdf)[mirror], 0.0879, atol=2e-3)


def test_reciprocal() -> None:
    """To rounding of the half vector."""
    wi, wo = direction(0.3), direction(0.8, 2.0)
    for p in (params(0.3), params(0.3, nonlinear=f32(1.0))):
        there, back = (plastic.eval_pdf(p, a, b)[0] / b[2] for a, b in ((wi, wo), (wo, wi)))
        np.testing.assert_allclose(there, back, rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("alpha", [0.0, 1e-8, 2e-5, 1e-3, 1.0])
@pytest.mark.parametrize("eta", [1.0001, 1.5, 100.0])
def test_hostile_numbers_stay_finite(alpha: float, eta: float) -> None:
    """The reflection's weight is F/p ≤ 20, the least choice being 1/20; the base adds less than 2."""
    for color in (f32(0.0, 0.0, 0.0), f32(1.0, 1.0, 1.0), BLUE):
        checks.check_finite(plastic, plastic.Params(f32(alpha), f32(eta), color), weight_bound=22.0)


def test_lanes_are_independent() -> None:
    for alpha in (0.0, 0.3):
        checks.check_lanes_are_independent(plastic, params(alpha, nonlinear=f32(1.0)))


@pytest.mark.parametrize("nonlinear", [False, True])
@pytest.mark.parametrize("alpha", [0.05, 0.3])
def test_agrees_with_mitsuba(alpha: float, nonlinear: bool) -> None:
    """2.5 %: our T and R are interpolated on 16 nodes and masked by height, Mitsuba's on 64, independently.

    The reflection's masking is corrected for the form where the reflection dominates only; so compare
    directions well off the mirror's, where the base dominates.
    """
    plugin = {
        "type": "roughplastic", "distribution": "ggx", "alpha": alpha, "int_ior": 1.49, "ext_ior": 1.0,
        "nonlinear": nonlinear, "diffuse_reflectance": {"type": "rgb", "value": BLUE[:, 0].tolist()},
    }  # fmt: skip
    cosines = np.array([0.3, 0.5, 0.7, 0.9, 1.0])
    wi = np.concatenate([direction(c) for c in cosines], axis=1)
    wo = np.concatenate([direction(c, 0.5) for c in (0.9, 0.4, 0.8, 0.6, 0.5)], axis=1)
    value, _ = plastic.eval_pdf(params(alpha, nonlinear=f32(float(nonlinear))), wi, wo)
    theirs, _ = mitsuba_bsdfs.evaluate(plugin, wi, wo)
    np.testing.assert_allclose(value, theirs, rtol=0.025)


def test_internal_reflectance_of_glass_is_egans() -> None:
    """R = 0.596 for η = 1.5 (Egan and Hilgeman 1973: 0.5963), to the tables' interpolation."""
    assert energy.inner_reflectance(f32(0.0), f32(1.5))[0] == pytest.approx(0.596, abs=0.001)
