"""Fresnel's formulas against complex arithmetic in float64, and their limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.bsdf_checks import f32

from pt_engine.bsdfs import fresnel


def exact(cos: float, index: complex) -> float:
    """|r|² averaged over polarisations, with complex cosines."""
    c = complex(cos)
    g = np.sqrt(index * index - 1 + c * c)
    s, p = (c - g) / (c + g), (index * index * c - g) / (index * index * c + g)
    return float(abs(s) ** 2 + abs(p) ** 2) / 2


@settings(max_examples=300, deadline=None)
@given(st.floats(1e-6, 1), st.floats(0.1, 10))
def test_dielectric_is_fresnels(cos: float, eta: float) -> None:
    """To rounding: near the critical angle F rises as the root of the distance, so 1e-7 there is 1e-3."""
    c, e = f32(cos), f32(eta)
    critical = abs(float(e[0]) ** 2 - 1 + float(c[0]) ** 2)
    tolerance = 1e-6 + 1e-6 / np.sqrt(critical + 1e-7)
    assert fresnel.dielectric(c, e)[0][0] == pytest.approx(exact(float(c[0]), float(e[0])), abs=tolerance)


@pytest.mark.parametrize("excess", [1e-2, 1e-4, 1e-6, -1e-3, -1e-6])
def test_dielectric_keeps_its_digits_as_the_index_tends_to_1(excess: float) -> None:
    """F(0°) = ((η − 1)/(η + 1))², tiny but not zero; the inputs' own rounding leaves some 1e-6 of it."""
    eta = f32(1 + excess)
    expected = ((float(eta[0]) - 1) / (float(eta[0]) + 1)) ** 2
    assert fresnel.dielectric(f32(1.0), eta)[0][0] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("eta", [0.5, 1 - 1e-7, 1.0, 1 + 1e-7, 1.5, 100.0])
def test_dielectric_is_finite_at_grazing(eta: float) -> None:
    f, g = fresnel.dielectric(np.array([0, 1e-30, 1e-7, 1e-3, 1], np.float32), f32(eta))
    assert np.isfinite(f).all()
    assert np.isfinite(g).all()
    assert (f >= 0).all()
    assert (f <= 1).all()


@settings(max_examples=200, deadline=None)
@given(st.floats(1e-4, 1), st.floats(0.05, 10), st.floats(0, 10))
def test_conductor_is_fresnels(cos: float, eta: float, k: float) -> None:
    """To rounding: float32 squares of up to 100 cancel, leaving 1e-5."""
    c, e, q = f32(cos), f32(eta), f32(k)
    expected = exact(float(c[0]), complex(float(e[0]), float(q[0])))
    near = abs(float(e[0]) ** 2 - 1 + float(c[0]) ** 2) + float(q[0])
    assert fresnel.conductor(c, e, q)[0] == pytest.approx(expected, abs=1e-5 + 1e-6 / np.sqrt(near + 1e-7))


def test_f82_tint_scales_schlick_at_its_angle() -> None:
    """F(c = 1/7) = tint · Schlick(1/7); tint 1 is Schlick itself."""
    f0, tint, c = f32(0.2, 0.5, 0.9), f32(0.1, 0.7, 1.0), f32(1 / 7)
    value = fresnel.f82(c, f0, fresnel.f82_slope(f0, tint))
    np.testing.assert_allclose(value, tint * fresnel.schlick(c, f0), rtol=1e-5)


def test_averages_are_the_integrals() -> None:
    """2∫ F c dc by Gauss-Legendre: exact for F82's polynomial; Kulla and Conty's fits are good to 1 %."""
    x, w = np.polynomial.legendre.leggauss(64)
    c = ((x + 1) / 2).astype(np.float32)
    f0, tint = f32(0.2, 0.5, 0.9), f32(0.5, 0.7, 1.0)
    b = fresnel.f82_slope(f0, tint)
    np.testing.assert_allclose(fresnel.f82_average(f0, b)[:, 0], fresnel.f82(c, f0, b) @ (w * c), rtol=1e-5)
    for eta in (0.6, 0.8, 1.2, 1.5, 2.5):
        integral = fresnel.dielectric(c, f32(eta))[0] @ (w * c)
        assert fresnel.dielectric_average(f32(eta))[0] == pytest.approx(integral, abs=0.01)


def test_index_of_normal_reflectance_inverts() -> None:
    eta = np.array([1.0, 1.1, 1.5, 3.0], np.float32)
    np.testing.assert_allclose(fresnel.index_of(fresnel.normal_incidence(eta)), eta, rtol=1e-6)
