"""Principled hair after Huang."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support import bsdf_checks as checks
from support.bsdf_checks import Array, direction, f32, repeat, uniforms
from support.chi2 import chi2_counts, significance

from pt_engine.bsdfs import hair_chiang, hair_huang
from pt_engine.bsdfs.hair_huang import Params

BROWN, CLEAR, BLACK = f32(0.25, 0.5, 1.4), f32(0.0, 0.0, 0.0), f32(1e3, 1e3, 1e3)
ONLY = dict(zip(("R", "TT", "TRT", "rest"), np.eye(4, 3, dtype=np.float32)[:, :, np.newaxis], strict=True))
# roughness, tilt, short over long axis, azimuth, cosine, azimuth of wi
CASES = [
    (0.05, 0.2, 1.0, 0.0, 0.9, 0.3),
    (0.3, -0.035, 0.6, 0.9, 0.4, 1.5),
    (1.0, 0.1, 1.7, 2.5, 0.6, 2.5),
]


def hair(
    rough: float,
    tilt: float = 0.0,
    aspect: float = 1.0,
    phi: float = 0.0,
    *,
    sigma: Array = BROWN,
    eta: float = 1.55,
    n: int = 1,
    **more: Any,
) -> Params:
    """`n` lanes, each with ways of its own; of unknown offset."""
    u = np.random.default_rng(7).random((7, n), np.float32)
    known = {"h": f32(0.0), "blur": f32(2.0)} | more
    parts = f32(rough), f32(tilt), f32(eta), sigma, u[:3], u[3:6], u[6], f32(aspect), f32(phi)
    return Params(*parts, **known)


def mean_weight(params: Params, wi: Array, n: int) -> tuple[float, float]:
    """How much is scattered in all, of the first colour, and the mean's standard error."""
    weight = hair_huang.sample(params, repeat(wi, n), *uniforms(n)).weight[0].astype(np.float64)
    return float(weight.mean()), float(weight.std() / np.sqrt(n))


def on_sphere(z: Array, phi: Array) -> Array:
    """(3, n) unit vectors."""
    sine = np.sqrt(1 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z]).astype(np.float32)


@pytest.mark.parametrize("case", CASES)
def test_samples_follow_the_density_of_given_ways(case: tuple) -> None:
    """In 10 × 20 cells; densities end at edges, so each cell is integrated by 40² midpoints."""
    p, wi, n, fine, cells = hair(*case[:4]), direction(*case[4:]), 50_000, 40, (10, 20)
    z, phi = np.meshgrid(*((np.arange(c * fine) + 0.5) / (c * fine) for c in cells), indexing="ij")
    wo = on_sphere(1 - 2 * z.ravel(), 2 * np.pi * phi.ravel())
    pdf = hair_huang.eval_pdf(p, repeat(wi, wo.shape[1]), wo)[1].astype(np.float64)
    mass = pdf.reshape(cells[0], fine, cells[1], fine).sum(axis=(1, 3)).ravel() * (4 * np.pi / pdf.size)
    s = hair_huang.sample(p, repeat(wi, n), *uniforms(n))
    x, y, z = s.wo[:, s.weight.max(axis=0) > 0].astype(np.float64)
    row = np.minimum(((1 - z) * (cells[0] / 2)).astype(int), cells[0] - 1)
    column = (np.arctan2(y, x) / (2 * np.pi) % 1 * cells[1]).astype(int) % cells[1]
    count = np.bincount(row * cells[1] + column, minlength=mass.size)
    observed, expected = np.append(count, n - count.sum()), n * np.append(mass, 1 - mass.sum())
    assert chi2_counts(observed, expected) > significance(len(CASES))


@pytest.mark.parametrize("case", CASES)
def test_weight_is_value_over_pdf(case: tuple) -> None:
    """1e-3: a narrow lobe's half vector is found again from float32 directions."""
    checks.check_weight_is_value_over_pdf(hair_huang, hair(*case[:4]), direction(*case[4:]), rtol=1e-3)


@pytest.mark.parametrize(
    ("rough", "tolerance"), [(1e-3, 1e-3), (0.1, 0.01), (0.3, 0.03)], ids=["smooth", "0.1", "0.3"]
)
@pytest.mark.parametrize(("aspect", "phi"), [(1.0, 0.0), (0.5, 1.0)], ids=["round", "flat"])
def test_clear_hair_in_a_white_furnace_vanishes(
    rough: float, tolerance: float, aspect: float, phi: float
) -> None:
    """But for what tables of rough glass make up for between facets, which is no more exact in Cycles."""
    n = 40_000
    p = hair(rough, 0.0, aspect, phi, sigma=CLEAR, n=n)
    mean, error = mean_weight(p, direction(0.7, 0.8), n)
    assert mean == pytest.approx(1, abs=tolerance + 4 * error)  # false alarm: 6e-5 each


@pytest.mark.parametrize("h", [0.0, 0.6, -0.9])
def test_smooth_hair_shares_out_light_as_a_cylinder_does(h: float) -> None:
    """R, TT, TRT and the rest: F, (1 − F)²T, (1 − F)²T²F ..., as in Chiang's model: facets are mirrors."""
    n, wi = 4000, direction(0.8, 0.9)
    v = hair_chiang.variance(f32(0.3))
    smooth = hair_chiang.Params(v, v, hair_chiang.scale(f32(0.3)), f32(0.0), f32(1.55), BROWN, f32(h))
    expected = hair_chiang.fibre(smooth, wi).share[:, 0, 0]
    at = {"h": f32(h), "blur": f32(0.0), "n": n}
    parts = {k: mean_weight(hair(1e-3, strength=s, **at), wi, n)[0] for k, s in ONLY.items()}
    rest = parts.pop("rest")  # what no strength weakens
    np.testing.assert_allclose(list(parts.values()) - np.array(rest), expected[:3], rtol=0.02, atol=1e-4)
    assert rest == pytest.approx(expected[3], rel=0.3)  # attenuated by means of two ways


def test_reflection_mirrors_at_the_point_that_is_hit() -> None:
    """At h the cylinder's normal is turned by γ = asin h about the hair, and R by 2γ from wi."""
    p = hair(0.01, sigma=BLACK, h=f32(0.5), blur=f32(0.0))
    angle = np.linspace(-3, 3, 601)
    wo = np.stack([0 * angle, np.sin(angle), np.cos(angle)]).astype(np.float32)
    value, _ = hair_huang.eval_pdf(p, repeat(direction(1.0), 601), wo)
    assert abs(angle[value[0].argmax()]) == pytest.approx(2 * np.arcsin(0.5), abs=0.02)


def test_first_reflection_is_reciprocal() -> None:
    """f cosθo cosθi is the same both ways; to 2 %, what 1/E makes up for by the one end alone."""
    n, ends = 40_000, (direction(0.9, 0.4), direction(0.5, 2.0))
    p = hair(0.3, sigma=BLACK, n=n)
    both = []
    for wi, wo in (ends, ends[::-1]):
        value = hair_huang.eval_pdf(p, repeat(wi, n), repeat(wo, n))[0][0]
        across = np.sqrt(1 - wi[0, 0] ** 2)
        both.append((value.mean() * across, value.std() * across / np.sqrt(n)))
    (a, da), (b, db) = both
    assert a == pytest.approx(b, abs=0.02 * a + 4 * np.hypot(da, db))


def test_ways_are_drawn_evenly() -> None:
    """Values for random ways have the mean that a fine grid of offsets and facets gives (one lattice)."""
    n, wi, wo = 1 << 15, direction(0.7, 1.2), direction(-0.5, -1.4)
    powers = 1.1 ** np.arange(1, 8)[:, np.newaxis]
    lattice = ((np.arange(n) + 0.5) / powers * np.sqrt(2) % 1).astype(np.float32)
    grid = hair(0.3)._replace(enters=lattice[:3], inside=lattice[3:6], last=lattice[6])
    value = [hair_huang.eval_pdf(p, repeat(wi, n), repeat(wo, n))[0][0] for p in (hair(0.3, n=n), grid)]
    means, error = [v.mean() for v in value], value[0].std() / np.sqrt(n)
    assert means[0] == pytest.approx(means[1], abs=5 * error)


def test_ways_that_carry_no_light_are_not_sampled() -> None:
    """The rest alone: each way's share of it, or nothing where a way ends at scales that look away."""
    n, wi = 40_000, direction(0.3)
    p = hair(0.6, 0.1, sigma=CLEAR, n=n, strength=CLEAR)
    seen = hair_huang.section(p, repeat(wi, n))
    shares = np.stack([way.share[3, 0] for way in hair_huang.chains(p, seen)])
    assert (shares == 0).mean() > 0.05
    mean, error = mean_weight(p, wi, n)
    assert mean == pytest.approx(shares.mean(), abs=5 * error)


@pytest.mark.slow
@pytest.mark.parametrize(("rough", "aspect", "eta"), [(1e-4, 1.0, 1.0), (0.05, 0.1, 0.5), (1.0, 3.0, 100.0)])
def test_hostile_numbers_stay_finite(rough: float, aspect: float, eta: float) -> None:
    p = hair(rough, 0.2, aspect, 0.5, sigma=f32(0.0, 1e3, 1e6), eta=eta)
    checks.check_finite(hair_huang, p, weight_bound=1e3)


def test_lanes_are_independent() -> None:
    checks.check_lanes_are_independent(hair_huang, hair(*CASES[1][:4], n=37))
