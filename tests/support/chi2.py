"""Pearson's χ² for samplers: does a sampler draw in proportion to the density that it claims?

    χ² = Σ_cells (observed − expected)² / expected        expected = n ∫_cell pdf dω

Cells are equal in solid angle (a grid in cosθ and φ). The density is integrated by Gauss-Legendre
rules that subdivide where they disagree, so narrow lobes and edges are integrated, not guessed.
Cells that expect fewer than five samples are pooled, as Cochran's rule asks.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2 as chi2_distribution

Array = NDArray[np.floating]
SampleFn = Callable[[Array, Array, Array], tuple[Array, NDArray[np.bool_] | None]]
PdfFn = Callable[[Array], Array]

NODES = 4  # Gauss-Legendre nodes per axis and patch
MAX_SPLITS = 9  # a patch may shrink to 2⁻⁹ of its cell per axis


def significance(n_tests: int, alpha: float = 0.01) -> float:
    """Threshold for each of `n_tests` p-values: together they cry wolf with probability `alpha` (Šidák)."""
    return float(-np.expm1(np.log1p(-alpha) / n_tests))


def chi2_counts(observed: Array, expected: Array, minimum: float = 5.0) -> float:
    """p-value of Pearson's test; cells are pooled, poorest first, until each pool expects `minimum`."""
    observed = np.asarray(observed, np.float64).ravel()
    expected = np.maximum(np.asarray(expected, np.float64).ravel(), 0.0)
    order = np.argsort(expected, kind="stable")
    observed, expected = observed[order], expected[order]
    # A pool closes when its running sum passes the next multiple of `minimum`; rich cells stay alone.
    poor = int(np.searchsorted(expected, minimum))
    pool = np.empty(expected.size, np.int64)
    filled = np.cumsum(expected[:poor]) / minimum
    pool[:poor] = np.minimum(filled, max(int(filled[-1]) - 1, 0)) if poor else 0  # the rest joins the last
    pool[poor:] = (pool[poor - 1] if poor else -1) + 1 + np.arange(expected.size - poor)
    want = np.bincount(pool, expected)
    have = np.bincount(pool, observed)
    while want.size > 1 and want[0] < minimum:  # cells that expect nothing, or a short pool: join the next
        want = np.concatenate([[want[0] + want[1]], want[2:]])
        have = np.concatenate([[have[0] + have[1]], have[2:]])
    if want.size < 2:
        return 1.0 if abs(have.sum() - want.sum()) <= 5.0 * np.sqrt(want.sum() + 1.0) else 0.0
    return float(chi2_distribution.sf(np.sum((have - want) ** 2 / want), want.size - 1))


def chi2_sphere(
    sample_fn: SampleFn,
    pdf_fn: PdfFn,
    n: int = 200_000,
    resolution: tuple[int, int] = (20, 40),
    *,
    pole: tuple[float, float, float] = (0.0, 0.0, 1.0),
    cap: float = 2.0,
    seed: int = 1,
) -> float:
    """p-value for a sampler of directions against its density per solid angle.

    Parameters
    ----------
    sample_fn : (u0, u1, u2) -> wo (3, n), valid (n,) bool or None
        Uniforms are (n,) float32 in [0, 1). Invalid samples (weight 0) go to a bin of their own, which
        expects what the density leaves of 1.
    pdf_fn : wo (3, m) float32 -> (m,)
    resolution : cells in cosθ (even, so that the horizon is an edge) and in φ.
    pole : axis of the grid; point it at a narrow lobe and give `cap` to look at it closely.
    cap : 1 − cosθ of the outermost cell: 2 for the sphere, 1 for the hemisphere. Samples outside are
        binned with the invalid ones.
    """
    basis = _basis(pole)
    rng = np.random.default_rng(seed)
    u = rng.random((3, n), np.float32)
    wo, valid = sample_fn(u[0], u[1], u[2])
    keep = np.ones(n, np.bool_) if valid is None else np.asarray(valid, np.bool_)
    if not np.isfinite(wo[:, keep]).all():
        raise AssertionError("the sampler returned directions that are not finite and not marked invalid")
    observed = _bin(basis @ np.asarray(wo[:, keep], np.float64), resolution, cap)
    expected = n * integrate_cells(pdf_fn, resolution, basis, cap)
    elsewhere = n - expected.sum()
    if elsewhere < -1e-3 * n:
        raise AssertionError(f"the density integrates to {expected.sum() / n:.6f}, more than 1")
    return chi2_counts(np.append(observed, n - observed.sum()), np.append(expected, max(elsewhere, 0.0)))


def integrate_sphere(pdf_fn: PdfFn, resolution: tuple[int, int] = (20, 40)) -> float:
    """∫ pdf dω over the whole sphere, by the same subdividing rule."""
    return float(integrate_cells(pdf_fn, resolution, np.eye(3), 2.0).sum())


def integrate_cells(
    pdf_fn: PdfFn, resolution: tuple[int, int], basis: Array, cap: float, tolerance: float = 1e-6
) -> Array:
    """∫ pdf dω over each cell, flat; patches split until splitting changes the sum by < `tolerance`."""
    rows, columns = resolution
    edges = np.arccos(1.0 - np.arange(rows + 1) * (cap / rows))  # θ, in which lobes are smoother than in cosθ
    theta, phi = np.meshgrid(edges[:-1], np.arange(columns) * 2 * np.pi / columns, indexing="ij")
    width = np.broadcast_to(np.diff(edges)[:, None], theta.shape)
    patches = np.stack([theta.ravel(), width.ravel(), phi.ravel()])
    height = 2 * np.pi / columns
    cell = np.arange(rows * columns)
    coarse = _gauss(pdf_fn, patches, height, basis)
    result = np.zeros(rows * columns)
    allowed = tolerance / cell.size
    for split in range(MAX_SPLITS):
        theta, width, phi = patches[0], patches[1] / 2, patches[2]
        height /= 2
        quarters = [np.stack([theta + i * width, width, phi + j * height]) for i in (0, 1) for j in (0, 1)]
        fine = [_gauss(pdf_fn, quarter, height, basis) for quarter in quarters]
        total = np.sum(fine, axis=0)
        rough = np.abs(total - coarse) > allowed
        if split == MAX_SPLITS - 1:
            rough[:] = False
        result += np.bincount(cell[~rough], total[~rough], minlength=result.size)
        if not rough.any():
            break
        patches = np.concatenate([quarter[:, rough] for quarter in quarters], axis=1)
        coarse = np.concatenate([part[rough] for part in fine])
        cell = np.tile(cell[rough], 4)
    return result


def _gauss(pdf_fn: PdfFn, patches: Array, height: float, basis: Array) -> Array:
    """Tensor Gauss-Legendre rule on patches (θ₀, Δθ, φ₀), a few thousand patches at a time."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    step = 16_384
    parts = []
    for first in range(0, patches.shape[1], step):
        theta0, width, phi0 = patches[:, first : first + step, None, None]
        theta = theta0 + width * x[:, None] + 0 * x
        phi = phi0 + height * x + 0 * x[:, None]
        sin_theta = np.sin(theta)
        local = np.stack([sin_theta * np.cos(phi), sin_theta * np.sin(phi), np.cos(theta)]).reshape(3, -1)
        wo = np.ascontiguousarray(basis.T @ local, np.float32)
        values = np.asarray(pdf_fn(wo), np.float64).reshape(theta.shape) * sin_theta
        parts.append(np.einsum("pij,i,j->p", values, w, w) * width[:, 0, 0] * height)
    return np.concatenate(parts) if parts else np.zeros(0)


def _bin(local: Array, resolution: tuple[int, int], cap: float) -> Array:
    rows, columns = resolution
    # 1 − cosθ from sinθ where that is small: the difference would cancel.
    sin2 = local[0] ** 2 + local[1] ** 2
    h = np.where(local[2] > 0, sin2 / (1.0 + np.abs(local[2])), 1.0 - local[2])
    i = np.floor(h * (rows / cap)).astype(np.int64)
    if cap >= 2.0:
        i = np.minimum(i, rows - 1)
    j = np.floor(np.arctan2(local[1], local[0]) * (columns / (2 * np.pi))).astype(np.int64) % columns
    inside = i < rows
    return np.bincount(i[inside] * columns + j[inside], minlength=rows * columns).astype(np.float64)


def _basis(pole: tuple[float, float, float]) -> Array:
    """Rows: two tangents and the pole."""
    z = np.asarray(pole, np.float64) / np.linalg.norm(pole)
    if z[2] == 1.0:
        return np.eye(3)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z])
