"""Each warp: samples follow the density (χ²), the inverse inverts, the density integrates to 1."""

from functools import partial

import numpy as np
import pytest
from support.chi2 import chi2_counts, chi2_sphere, integrate_sphere, significance

from pt_engine.core import warps

SPHERICAL = {
    "cosine_hemisphere": (
        warps.square_to_cosine_hemisphere,
        warps.cosine_hemisphere_to_square,
        warps.cosine_hemisphere_pdf,
    ),
    "hemisphere": (warps.square_to_hemisphere, warps.hemisphere_to_square, warps.hemisphere_pdf),
    "sphere": (warps.square_to_sphere, warps.sphere_to_square, warps.sphere_pdf),
    "cone": tuple(
        partial(f, one_minus_cos=0.3) for f in (warps.square_to_cone, warps.cone_to_square, warps.cone_pdf)
    ),
}


def polygon(corners, rotation):
    keys = {"corners": corners, "rotation": rotation}
    return tuple(
        partial(f, **keys) for f in (warps.square_to_polygon, warps.polygon_to_square, warps.polygon_pdf)
    )


PLANAR = {
    "disk": (warps.square_to_disk, warps.disk_to_square, warps.disk_pdf),
    "triangle": (warps.square_to_triangle, warps.triangle_to_square, warps.triangle_pdf),
    **{f"polygon {n}": polygon(n, 0.37 * n) for n in (3, 4, 5, 6, 8)},
}
ALL = {**SPHERICAL, **PLANAR}
THRESHOLD = significance(len(ALL), 1e-4)


def uniforms(n=200_000, seed=3):
    return np.random.default_rng(seed).random((2, n), np.float32)


@pytest.mark.parametrize("name", SPHERICAL)
def test_directions_follow_their_density(name):
    forward, _, pdf = SPHERICAL[name]
    assert chi2_sphere(lambda _, u, v: (forward(u, v), None), pdf) > THRESHOLD
    assert abs(integrate_sphere(pdf) - 1) < 1e-3
    w = forward(*uniforms())
    np.testing.assert_allclose(np.linalg.norm(w.astype(np.float64), axis=0), 1, atol=3e-7)
    assert w.dtype == pdf(w).dtype == np.float32


@pytest.mark.parametrize("name", PLANAR)
def test_planar_points_follow_their_density(name):
    """χ² on a 24² grid over [−1, 1]²; the density is integrated on a 24-fold finer grid."""
    forward, _, pdf = PLANAR[name]
    cells, fine, n = 24, 24, 200_000
    points = forward(*uniforms(n))
    assert points.dtype == pdf(points).dtype == np.float32
    assert (pdf(points * np.float32(1 - 1e-6)) > 0).mean() > 0.9999
    observed = np.histogram2d(*points, bins=cells, range=[[-1, 1], [-1, 1]])[0]
    grid = ((np.arange(cells * fine) + 0.5) / (cells * fine) * 2 - 1).astype(np.float32)
    x, y = np.meshgrid(grid, grid, indexing="ij")
    density = pdf(np.stack([x.ravel(), y.ravel()])).astype(np.float64).reshape(cells, fine, cells, fine)
    expected = density.sum((1, 3)) * (2 / (cells * fine)) ** 2
    assert abs(expected.sum() - 1) < 5e-3
    rim = expected < 0.999 * density.max() * (2 / cells) ** 2  # cut cells: their area is quadrature, pool it
    pooled = np.append(observed[~rim], observed[rim].sum())
    assert chi2_counts(pooled, n * np.append(expected[~rim], 1 - expected[~rim].sum())) > THRESHOLD


@pytest.mark.parametrize("name", ALL)
def test_inverse_inverts(name):
    """Away from the seams, where neighbouring points have distant parameters."""
    forward, inverse, _ = ALL[name]
    u, v = 0.02 + 0.96 * uniforms()
    back = inverse(forward(u, v))
    error = np.maximum(np.abs(back[0] - u), np.abs(back[1] - v))
    seam = np.abs(u * 40 - np.round(u * 40)) < 0.01 if "polygon" in name else np.zeros(u.size, bool)
    assert np.quantile(error[~seam], 0.999) < 2e-5
    assert np.median(error) < 1e-6


@pytest.mark.parametrize("name", ALL)
def test_corners_of_the_square_are_finite(name):
    end = np.float32(1 - 2.0**-24)
    u = np.array([0, 0, end, end, 0.5, 0.5, 0, 0.5], np.float32)
    v = np.array([0, end, 0, end, 0.5, 0, 0.5, end], np.float32)
    forward, inverse, pdf = ALL[name]
    points = forward(u, v)
    assert np.isfinite(points).all()
    assert np.isfinite(inverse(points)).all()
    assert np.isfinite(pdf(points)).all()


def test_cosine_hemisphere_never_has_zero_density():
    u, v = np.meshgrid(np.float32([0, 2.0**-24, 0.5, 1 - 2.0**-24]), np.float32([0, 0.3, 1 - 2.0**-24]))
    w = warps.square_to_cosine_hemisphere(u.ravel(), v.ravel())
    assert (warps.cosine_hemisphere_pdf(w) > 0).all()


@pytest.mark.parametrize("theta", [1e-6, 1e-4, 1e-2])
def test_tiny_cones_keep_their_digits(theta):
    """sin²θ of the samples is uniform in [0, sin²θ_max] to first order: mean 1/2, within 5 σ and rounding."""
    k = np.float32(2 * np.sin(theta / 2) ** 2)
    u, v = uniforms()
    w = warps.square_to_cone(u, v, k).astype(np.float64)
    ratio = (w[0] ** 2 + w[1] ** 2) / np.sin(theta) ** 2
    assert abs(ratio.mean() - 0.5) < 5 / np.sqrt(12 * u.size) + theta**2
    assert ratio.max() < 1 + 1e-5
    back = warps.cone_to_square(warps.square_to_cone(u, v, k), k)
    np.testing.assert_allclose(back[0], u, atol=2e-6)
    density = warps.cone_pdf(warps.square_to_cone(u * np.float32(0.999), v, k), k)
    np.testing.assert_allclose(density, 1 / (2 * np.pi * float(k)), rtol=1e-6)
