"""The χ² helper itself: right samplers pass at the stated rate, wrong ones fail."""

import numpy as np
from support.chi2 import chi2_counts, chi2_sphere, integrate_sphere, significance


def cosine(u0, u1, u2):
    r, phi = np.sqrt(u1), 2 * np.pi * u2
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - u1)]), None


def cosine_pdf(wo):
    return np.maximum(wo[2], 0) / np.pi


def narrow(k):
    """Uniform in a cone of 1 − cosθ = k."""

    def sample(u0, u1, u2):
        h = np.float64(k) * u1
        r, phi = np.sqrt(h * (2 - h)), 2 * np.pi * u2
        return np.stack([r * np.cos(phi), r * np.sin(phi), 1 - h]), None

    return sample


def test_right_sampler_gives_uniform_p_values():
    """p-values of a right sampler are uniform: their mean over 40 seeds is 1/2 ± 0.046 (5 σ here)."""
    p = [chi2_sphere(cosine, cosine_pdf, n=20_000, seed=seed) for seed in range(40)]
    assert abs(np.mean(p) - 0.5) < 5 * np.sqrt(1 / 12 / 40)
    assert min(p) > significance(40, 1e-4)


def test_wrong_density_fails():
    assert chi2_sphere(cosine, lambda wo: np.full(wo.shape[1], 0.25 / np.pi)) < 1e-12
    assert chi2_sphere(cosine, lambda wo: (wo[2] > 0) / (2 * np.pi)) < 1e-12


def test_failed_samples_are_a_bin_of_their_own():
    """Half the lanes fail at random: right with half the density, wrong with all of it."""

    def half(u0, u1, u2):
        return cosine(u0, u1, u2)[0], u0 < 0.5

    assert chi2_sphere(half, lambda wo: 0.5 * cosine_pdf(wo)) > 1e-4
    assert chi2_sphere(half, cosine_pdf) < 1e-12


def test_narrow_lobe_is_integrated_and_can_be_zoomed():
    """∫ D(θ) cosθ dω = 1 for GGX, here with a peak (α = 0.01) fifty times narrower than a cell."""
    a2 = 1e-4

    def ggx(wo):
        x, y, z = wo.astype(np.float64)
        return a2 * np.maximum(z, 0) / (np.pi * (x * x + y * y + a2 * z * z) ** 2)

    assert abs(integrate_sphere(ggx) - 1) < 1e-4
    k = 1e-3

    def density(wo):
        return ((wo[0] ** 2 + wo[1] ** 2) < k * (2 - k)) / (2 * np.pi * k)

    assert chi2_sphere(narrow(k), density, cap=2 * k) > 1e-4
    assert chi2_sphere(narrow(1.05 * k), density, cap=2 * k) < 1e-6


def test_counts_pool_and_reject():
    rng = np.random.default_rng(3)
    expected = np.concatenate([np.full(500, 0.1), np.full(50, 30.0)])
    p = [chi2_counts(rng.poisson(expected), expected) for _ in range(200)]
    assert 0.35 < np.mean(p) < 0.65
    assert chi2_counts(np.array([9.0, 100.0, 100.0]), np.array([0.0, 104.0, 105.0])) > 1e-3
    assert chi2_counts(np.array([900.0, 100.0, 100.0]), np.array([0.0, 550.0, 550.0])) < 1e-6
    assert chi2_counts(expected * 1.5, expected) < 1e-6


def test_significance_is_sidak():
    assert abs((1 - significance(20, 0.01)) ** 20 - 0.99) < 1e-12
