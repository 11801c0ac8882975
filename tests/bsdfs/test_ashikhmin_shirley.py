"""Ashikhmin and Shirley's glossy reflection."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import bsdf_checks as checks
from support.bsdf_checks import LOBES, NARROW, direction, f32, repeat, uniforms
from support.chi2 import significance

from pt_engine.bsdfs import ashikhmin_shirley as model
from pt_engine.bsdfs.base import Lobe

N_CHI2 = len(LOBES) + len(NARROW)


def params(alpha_x: float, alpha_y: float | None) -> model.Params:
    return model.Params(f32(alpha_x), None if alpha_y is None else f32(alpha_y))


@pytest.mark.parametrize(("ax", "ay", "cos", "phi"), LOBES)
def test_samples_follow_the_density(ax: float, ay: float | None, cos: float, phi: float) -> None:
    assert checks.chi2(model, params(ax, ay), direction(cos, phi)) > significance(N_CHI2)


@pytest.mark.parametrize(("alpha", "ay", "cos", "phi"), NARROW)
def test_narrow_lobes_follow_the_density(alpha: float, ay: None, cos: float, phi: float) -> None:
    """Looked at closely: a grid about the mirror direction that spans a few α."""
    p = checks.chi2_about_mirror(model, params(alpha, ay), direction(cos, phi), alpha)
    assert p > significance(N_CHI2)


@pytest.mark.parametrize(("ax", "ay", "cos", "phi"), [*LOBES, NARROW[0]])
def test_weight_is_value_over_pdf(ax: float, ay: float | None, cos: float, phi: float) -> None:
    """1e-3: the half vector, found again from float32 directions, errs by 1e-7/α of its slope."""
    rtol = 1e-3 if min(ax, ay or ax) >= 0.05 else 1e-2
    checks.check_weight_is_value_over_pdf(model, params(ax, ay), direction(cos, phi), rtol)


@pytest.mark.parametrize(("ax", "ay"), [(1.0, None), (0.5, None), (0.2, None), (0.02, None), (0.1, 0.6)])
@pytest.mark.parametrize("cos", [0.02, 0.3, 0.8, 1.0])
def test_reflects_no_more_than_all(ax: float, ay: float | None, cos: float) -> None:
    """The weight is cosθo/max(cosθi, cosθo) ≤ 1."""
    assert checks.directional_albedo(model, params(ax, ay), direction(cos, 0.3), choices=1)[0] <= 1


@pytest.mark.parametrize("cos", [0.3, 0.9])
def test_a_narrow_lobe_reflects_all(cos: float) -> None:
    """Its weight tends to 1; α = 0.003 leaves 1 − O(α/tan of the elevation)."""
    assert checks.directional_albedo(model, params(0.003, None), direction(cos), choices=1)[0] > 0.99


@settings(max_examples=40, deadline=None)
@given(st.floats(0.05, 1), st.floats(0.05, 1), st.floats(0.01, 1), st.floats(0.01, 1), st.floats(0, 7))
def test_reciprocal(ax: float, ay: float, cos_i: float, cos_o: float, phi: float) -> None:
    """f(wi, wo) = f(wo, wi), the value being f·cosθo."""
    p, wi, wo = params(ax, ay), direction(cos_i, 0.4), direction(cos_o, phi)
    there, back = (model.eval_pdf(p, a, b)[0] / b[2] for a, b in ((wi, wo), (wo, wi)))
    np.testing.assert_allclose(there, back, rtol=1e-4, atol=1e-30)


@pytest.mark.parametrize(
    "alpha", [(0.0, None), (1e-4, None), (1.01e-4, None), (1e-4, 1.0), (1.0, 1e-4), (1.0, None), (2.0, 3.0)]
)
def test_hostile_numbers_stay_finite_and_lanes_apart(alpha: tuple[float, float | None]) -> None:
    checks.check_finite(model, params(*alpha))
    checks.check_lanes_are_independent(model, params(*alpha))


def test_mirror_is_a_dirac_lobe() -> None:
    wi = repeat(direction(0.6, 1.0), 8)
    s = model.sample(params(1e-4, None), wi, *uniforms(8))
    np.testing.assert_allclose(s.wo, wi * np.array([[-1], [-1], [1]], np.float32), atol=5e-7)  # rounding
    assert s.lobe == Lobe.DELTA
    assert (s.pdf == 1).all()
    assert (s.weight == 1).all()
    assert not model.eval_pdf(params(1e-4, None), wi, s.wo)[1].any()
