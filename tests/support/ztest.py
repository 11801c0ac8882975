"""Do two renderers agree? Each gives two independent images of the same expectation.

From two images per side, nothing about the noise has to be assumed or known:

    error²    E[(a₀ − b₀)(a₁ − b₁)] = (A − B)²                the squared error beyond noise, unbiased
    variance  E[(a₀ − a₁)²] / 4 = Var[(a₀ + a₁)/2]            of a pixel's mean, one degree of freedom

Cells of many pixels are compared by Welch's t-test with Satterthwaite's degrees of freedom

    ν = 3 (Σv)² / Σv² − 2        (the 3 because E[v²] = 3σ⁴ where v has one degree of freedom)

so a cell whose variance comes from one bright pixel gets ν ≈ 1 and the wide tails that it deserves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Image = NDArray[np.float32]
Array = NDArray[np.float64]
GRID = (12, 8)  # columns, rows
NOISELESS = 1e-5  # relative: float32 sums differ by that much where there is no noise at all


@dataclass(frozen=True)
class Agreement:
    """How far two renderers are apart.

    Attributes
    ----------
    error : float
        RMS difference of the cells beyond noise, over the mean of the image.
    error_high : float
        Upper end of its confidence interval (two standard errors over the cells).
    pixel_error : float
        The same of single pixels: sees what cells average out, but also every firefly.
    noise : float
        RMS noise of a cell, over the mean.
    bias : (C,) float
        Relative difference of the channels' means.
    p : float
        The smallest of the cells' and the whole image's, Šidák-corrected for their number.
    worst : (row, column, channel, a, b)
        The cell that differs most significantly.
    """

    error: float
    error_high: float
    pixel_error: float
    noise: float
    bias: tuple[float, ...]
    p: float
    worst: tuple[int, int, int, float, float]

    def agrees(self, tolerance: float = 0.03, alpha: float = 1e-3) -> bool:
        """No cell differs significantly, or all of it is less than `tolerance` beyond the noise."""
        return self.p > alpha or self.error < tolerance

    def __str__(self) -> str:
        row, column, channel, a, b = self.worst
        bias = " ".join(f"{100 * x:+.2f}" for x in self.bias)
        return (
            f"{100 * self.error:.2f} % beyond noise (≤ {100 * self.error_high:.2f} %; pixels "
            f"{100 * self.pixel_error:.2f} %; noise {100 * self.noise:.2f} %), means {bias} %, "
            f"p = {self.p:.2g}, worst cell row {row} column {column} channel {channel}: {a:.5g}, not {b:.5g}"
        )


def compare(a: tuple[Image, Image], b: tuple[Image, Image], grid: tuple[int, int] = GRID) -> Agreement:
    """Compare the renderers that made the pairs `a` and `b`, images (height, width, channels).

    `b` is the reference where it matters (relative to whose mean).
    """
    a0, a1, b0, b1 = (np.asarray(image, np.float64) for image in (*a, *b))
    ends = [np.linspace(0, n, k + 1).astype(int)[:-1] for n, k in zip(a0.shape, grid[::-1], strict=False)]
    cells_a0, cells_a1, cells_b0, cells_b1 = (cell_means(image, ends) for image in (a0, a1, b0, b1))
    mean = max(float(np.abs(b0 + b1).mean() / 2), 1e-12)
    squared = beyond_noise(cells_a0, cells_a1, cells_b0, cells_b1)
    high = squared.mean() + 2 * squared.std() / np.sqrt(squared.size)
    variance = ((a0 - a1) ** 2 + (b0 - b1) ** 2) / 4
    p, spread = p_values((a0 + a1) / 2, (b0 + b1) / 2, variance, ends, mean)
    whole, _ = p_values((a0 + a1) / 2, (b0 + b1) / 2, variance, [np.zeros(1, int)] * 2, mean)
    smallest, number = float(min(p.min(), whole.min())), p.size + whole.size
    worst = np.unravel_index(int(np.argmin(p)), p.shape)
    cell_a, cell_b = (cells_a0 + cells_a1) / 2, (cells_b0 + cells_b1) / 2
    total = np.maximum(np.abs(b0 + b1).mean(axis=(0, 1)) / 2, 1e-3 * mean)
    return Agreement(
        error=root(squared.mean()) / mean,
        error_high=root(high) / mean,
        pixel_error=root(beyond_noise(a0, a1, b0, b1).mean()) / mean,
        noise=root(spread.mean()) / mean,
        bias=tuple(float(x) for x in (a0 + a1 - b0 - b1).mean(axis=(0, 1)) / 2 / total),
        p=float(-np.expm1(number * np.log1p(-min(smallest, 1 - 1e-12)))),
        worst=(*(int(k) for k in worst), float(cell_a[worst]), float(cell_b[worst])),
    )


def compare_exact(a: tuple[Image, Image], b: Image, grid: tuple[int, int] = GRID) -> Agreement:
    """Against one image whose noise is unknown and neglected (published pictures)."""
    return compare(a, (b, b), grid)


def p_values(
    a: Array, b: Array, variance: Array, ends: list[NDArray[np.int64]], scale: float
) -> tuple[Array, Array]:
    """Welch's two-sided p of each cell, and the variance of the difference of its means."""
    spread, degrees = cell_variance(variance, ends)
    cell_a, cell_b = cell_means(a, ends), cell_means(b, ends)
    floor = (NOISELESS * np.maximum(np.abs(cell_a), np.abs(cell_b)) + 1e-9 * scale) ** 2
    return 2 * stats.t.sf(np.abs(cell_a - cell_b) / np.sqrt(spread + floor), degrees), spread


def beyond_noise(a0: Array, a1: Array, b0: Array, b1: Array) -> Array:
    """Unbiased estimates of (A − B)²; single ones may be negative."""
    return ((a0 - b0) * (a1 - b1) + (a0 - b1) * (a1 - b0)) / 2


def cell_means(image: Array, ends: list[NDArray[np.int64]]) -> Array:
    """(rows, columns, channels) averages over a grid of cells."""
    return cell_sums(image, ends) / cell_sums(np.ones_like(image), ends)


def cell_sums(image: Array, ends: list[NDArray[np.int64]]) -> Array:
    """(rows, columns, channels) sums over a grid of cells."""
    return np.asarray(np.add.reduceat(np.add.reduceat(image, ends[0], axis=0), ends[1], axis=1))


def cell_variance(variance: Array, ends: list[NDArray[np.int64]]) -> tuple[Array, Array]:
    """Variance of cell means from the pixels', and its degrees of freedom."""
    number = cell_sums(np.ones_like(variance), ends)
    total = cell_sums(variance, ends)
    squares = cell_sums(variance**2, ends)
    degrees = 3 * total**2 / np.maximum(squares, 1e-300) - 2
    return total / number**2, np.where(total > 0, np.maximum(degrees, 1), number)


def root(x: float) -> float:
    """√x, 0 for what is below 0 by chance."""
    return float(np.sqrt(max(float(x), 0.0)))
