"""Principled hair after Chiang."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import integrate, special
from support import bsdf_checks as checks
from support.bsdf_checks import direction, f32, repeat, uniforms
from support.chi2 import significance

from pt_engine.bsdfs import hair_chiang
from pt_engine.bsdfs.hair_chiang import Params

BROWN = f32(0.25, 0.5, 1.4)
CLEAR = f32(0.0, 0.0, 0.0)
# roughness along and around, coat's share of the former, tilt, h, cosine, azimuth
CASES = [
    (0.3, 0.3, 1.0, -0.035, 0.0, 0.9, 0.3),
    (0.6, 0.2, 0.5, -0.1, 0.7, 0.6, 1.2),
    (0.15, 0.8, 1.0, 0.3, -0.95, 0.4, 2.5),
    (1.0, 1.0, 1.0, 0.0, 0.5, 0.2, 1.6),
]


def hair(
    rough: float,
    around: float,
    coat: float,
    tilt: float,
    h: float,
    sigma: np.ndarray = BROWN,
    eta: float = 1.55,
) -> Params:
    v, v0 = hair_chiang.variance(f32(rough)), hair_chiang.variance(f32(rough * coat))
    return Params(v, v0, hair_chiang.scale(f32(around)), f32(tilt), f32(eta), sigma, f32(h))


@pytest.mark.parametrize("case", CASES)
def test_samples_follow_the_density(case: tuple) -> None:
    assert checks.chi2(hair_chiang, hair(*case[:5]), direction(*case[5:])) > significance(len(CASES))


@pytest.mark.parametrize("case", CASES)
def test_weight_is_value_over_pdf(case: tuple) -> None:
    """1e-4: the sampler itself evaluates."""
    checks.check_weight_is_value_over_pdf(hair_chiang, hair(*case[:5]), direction(*case[5:]), rtol=1e-4)


@pytest.mark.parametrize("case", CASES)
def test_clear_hair_in_a_white_furnace_vanishes(case: tuple) -> None:
    """Σ Ap = 1, and M and N are distributions: each sample of clear hair weighs 1."""
    s = hair_chiang.sample(hair(*case[:5], CLEAR), repeat(direction(*case[5:]), 2000), *uniforms(2000))
    np.testing.assert_allclose(s.weight, 1, rtol=1e-4)


def test_hair_takes_what_its_colour_absorbs() -> None:
    """Without a Fresnel reflection (η = 1) light passes once, along 2 cosγ/cosθ radii: Beer's law."""
    h, cos = 0.6, 0.8
    wi = direction(cos, np.pi / 2)  # in the normal plane: θ = 0
    p = hair(0.2, 0.2, 1.0, 0.0, h, eta=1.0)
    s = hair_chiang.sample(p, repeat(wi, 4000), *uniforms(4000))
    expected = np.exp(-BROWN[:, 0] * 2 * np.sqrt(1 - h * h))
    np.testing.assert_allclose(s.weight.mean(axis=1), expected, rtol=1e-4)


@pytest.mark.parametrize("v", [1e-4, 0.05, 0.099, 0.5, 2.0])
def test_longitudinal_part_is_a_distribution(v: float) -> None:
    """∫ M cosθ dθ = 1 for any θi, and M is d'Eon's formula by scipy's Bessel function."""
    theta = np.linspace(-np.pi / 2, np.pi / 2, 200_001).astype(np.float32)
    for angle in (0.0, 0.7, -1.2):
        m = hair_chiang.longitudinal(
            f32(np.sin(angle)), f32(np.cos(angle)), np.sin(theta), np.cos(theta), f32(v)
        ).astype(np.float64)
        assert integrate.trapezoid(m * np.cos(theta), theta) == pytest.approx(1, abs=2e-4)
        if v >= 0.05:
            x = np.cos(angle) * np.cos(theta.astype(np.float64)) / v
            y = -np.sin(angle) * np.sin(theta.astype(np.float64)) / v
            expected = np.exp(y) * special.i0(x) / (2 * v * np.sinh(1 / v))
            np.testing.assert_allclose(m, expected, rtol=2e-4, atol=1e-6)


@pytest.mark.parametrize("s", [0.01, 0.3, 2.0])
def test_azimuthal_part_is_a_distribution(s: float) -> None:
    phi = np.linspace(0, 2 * np.pi, 200_001).astype(np.float32)
    n = hair_chiang.azimuthal(phi - np.float32(5.0), f32(s)).astype(np.float64)
    assert integrate.trapezoid(n, phi) == pytest.approx(1, abs=1e-4)


def test_reflection_mirrors_across_the_hair() -> None:
    """At h the cylinder's normal is turned by γ = asin h about the hair, and R by 2γ from wi, toward −h."""
    p = hair(1e-3, 1e-3, 1.0, 0.0, 0.5, f32(100.0, 100.0, 100.0))
    wi = direction(1.0)
    wo = np.stack(
        [0 * np.linspace(-3, 3, 601), np.sin(np.linspace(-3, 3, 601)), np.cos(np.linspace(-3, 3, 601))]
    )
    value, _ = hair_chiang.eval_pdf(p, repeat(wi, 601), wo.astype(np.float32))
    peak = np.linspace(-3, 3, 601)[value[0].argmax()]
    assert abs(peak) == pytest.approx(2 * np.arcsin(0.5), abs=0.02)


@pytest.mark.parametrize(("rough", "h", "eta"), [(1e-3, -1.0, 1.0), (0.05, 0.0, 0.5), (1.0, 1.0, 100.0)])
def test_hostile_numbers_stay_finite(rough: float, h: float, eta: float) -> None:
    """The weight is a colour's mean over its grey, at most 1/0.0722, that of blue."""
    for sigma in (CLEAR, f32(0.0, 1e3, 1e6)):
        checks.check_finite(hair_chiang, hair(rough, rough, 1.0, 0.2, h, sigma, eta), weight_bound=14.0)


def test_lanes_are_independent() -> None:
    checks.check_lanes_are_independent(hair_chiang, hair(*CASES[1][:5]))
