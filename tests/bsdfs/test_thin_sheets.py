"""What passes thin sheets: of glass, and of rough matter."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from support import bsdf_checks as checks
from support.bsdf_checks import direction, f32, repeat, uniforms
from support.chi2 import significance

from pt_engine.bsdfs import oren_nayar, rough_translucent, thin_transmission
from pt_engine.bsdfs.base import Lobe

BLUE = f32(0.1, 0.3, 0.9)
CASES = [
    (thin_transmission, thin_transmission.Params(f32(0.3)), 0.6),
    (thin_transmission, thin_transmission.Params(f32(1.0)), 0.1),
    (rough_translucent, rough_translucent.Params(f32(0.7), BLUE), 0.4),
]


@pytest.mark.parametrize(("model", "params", "cos"), CASES)
def test_samples_follow_the_density(model: ModuleType, params: tuple, cos: float) -> None:
    assert checks.chi2(model, params, direction(cos, 0.7)) > significance(len(CASES))


@pytest.mark.parametrize(("model", "params", "cos"), CASES)
def test_weight_is_value_over_pdf(model: ModuleType, params: tuple, cos: float) -> None:
    """1e-3: the half vector, found again from float32 directions."""
    checks.check_weight_is_value_over_pdf(model, params, direction(cos, 0.7), rtol=1e-3)


@pytest.mark.parametrize(("model", "params", "cos"), CASES)
def test_lanes_are_independent(model: ModuleType, params: tuple, cos: float) -> None:
    checks.check_lanes_are_independent(model, params)


@pytest.mark.parametrize(("model", "params", "cos"), CASES)
def test_reciprocal(model: ModuleType, params: tuple, cos: float) -> None:
    """From the other side the sheet is the same: f(wi, wo) = f(−wo, −wi), to rounding of the half vector."""
    wi, wo = direction(cos, 0.4), direction(-0.7, 2.0)
    there = model.eval_pdf(params, wi, wo)[0] / -wo[2]
    back = model.eval_pdf(params, -wo, -wi)[0] / wi[2]
    np.testing.assert_allclose(there, back, rtol=1e-5)


@pytest.mark.parametrize("alpha", [0.0, 1e-8, 2e-5, 1e-3, 1.0])
def test_hostile_numbers_stay_finite(alpha: float) -> None:
    checks.check_finite(thin_transmission, thin_transmission.Params(f32(alpha)))


@pytest.mark.parametrize("alpha", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("cos", [0.01, 0.5, 1.0])
def test_white_furnace_gains_nothing(alpha: float, cos: float) -> None:
    """G2/G1 ≤ 1; a smooth sheet loses nothing. 1e-6: float32's rounding of the mean."""
    sheet = thin_transmission.Params(f32(alpha))
    albedo = checks.directional_albedo(thin_transmission, sheet, direction(cos), rows=64, choices=1)
    assert albedo.max() <= 1 + 1e-6
    if alpha == 0:
        assert albedo.min() >= 1 - 1e-6


def test_a_smooth_sheet_does_not_bend() -> None:
    wi = repeat(direction(0.4, 1.0), 50)
    s = thin_transmission.sample(thin_transmission.Params(f32(0.0)), wi, *uniforms(50))
    np.testing.assert_allclose(s.wo, -wi, atol=5e-7)  # rounding
    assert s.lobe == Lobe.DELTA | Lobe.TRANSMIT


def test_rough_matter_lets_through_what_it_would_send_back() -> None:
    p = oren_nayar.Params(f32(0.7), BLUE)
    wi, wo = direction(0.4), direction(0.8, 2.0)
    mirrored = wo * np.array([[1], [1], [-1]], np.float32)
    for a, b in zip(oren_nayar.eval_pdf(p, wi, wo), rough_translucent.eval_pdf(p, wi, mirrored), strict=True):
        np.testing.assert_array_equal(a, b)
    assert not rough_translucent.eval_pdf(p, wi, wo)[1].any()


@pytest.mark.parametrize(
    ("eta", "expected"), [(1.0, 0.0), (1.5, 0.3 * np.sqrt(3.4 * 0.5 / 3.375)), (0.7, 0.0)]
)
def test_two_faces_spread_by_kulla_and_contys_fit(eta: float, expected: float) -> None:
    """α √(3.4 (η − 1)(η − ½)²/η³); nothing without a bend."""
    assert thin_transmission.sheet_alpha(f32(0.3), f32(eta))[0] == pytest.approx(expected, rel=1e-5)
