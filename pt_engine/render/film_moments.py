"""Mean and variance of pixels, from the sums that a film keeps.

Independent samples x:         v = s²/n         s² = (Σx² − n x̄²) / (n − 1)
Correlated within halves:      v = (Ā − B̄)² · n_A n_B / n²

Both are unbiased estimates of the variance of the pixel's mean, the second because the halves know nothing
of each other. It has one degree of freedom: good for sums over many pixels, not for one alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Float64 = NDArray[np.float64]
UInt32 = NDArray[np.uint32]

SQUARE_SCALE = 64.0  # squares of dim pixels need finer steps: exact for |x| in 5e-7 … 5e7


class Sums(NamedTuple):
    """Of n pixels: samples (n,), sums (3, n), sums of squares (3, n) or of all channels (1, n); halves."""

    samples: UInt32
    total: Float64
    squares: Float64
    correlated: bool
    a: Float64 | None = None
    b: Float64 | None = None
    count_b: UInt32 | None = None

    def half(self, number: int) -> tuple[UInt32, Float64]:
        """Samples (n,) and their sums (3, n) of half 0 (A) or 1 (B)."""
        assert self.a is not None and self.b is not None and self.count_b is not None  # noqa: PT018
        return (self.samples - self.count_b, self.a) if number == 0 else (self.count_b, self.b)


class Moments(NamedTuple):
    """Of n pixels.

    Attributes
    ----------
    mean : (3, n) float64
    variance : (3, n) float64
        Unbiased, of the mean; NaN where it cannot be told (below two samples, or an empty half).
    samples : (n,) uint32
    parts : (n,) uint32
        Independent values behind each variance: the samples, or 2 halves.
    independent : (n,) float64
        s²/n, mean over channels: what the variance of independent samples would be.
    spread : (n,) float64
        The same, less noisy than `variance` where that comes from halves; and then, where neighbours were
        asked, times what stratification gained around.
    level, level_by_median : (3, n) float64
        The radiance that errors are relative to: the mean, or where neighbours were asked, less noisy; they
        are asked in two ways (see `film_noise.levels`).
    """

    mean: Float64
    variance: Float64
    samples: UInt32
    parts: UInt32
    independent: Float64
    spread: Float64
    level: Float64
    level_by_median: Float64

    def of(self, pixels: NDArray[np.intp] | slice) -> Moments:
        """Those of some of the pixels."""
        found = (
            rows[..., pixels] if isinstance(pixels, slice) else rows.take(pixels, axis=-1) for rows in self
        )
        return Moments(*found)  # type: ignore[arg-type]


def moments_of(sums: Sums) -> Moments:
    """Means, and variances as the samples allow."""
    mean = sums.total / np.maximum(sums.samples, 1)
    variance = sample_variance(sums, mean)
    spread = variance.sum(axis=0) / 3
    if sums.correlated:
        halves = np.full_like(sums.samples, 2)
        return Moments(mean, half_variance(sums), sums.samples, halves, spread, spread, mean, mean)
    variance[:, sums.samples < 2] = np.nan
    return Moments(mean, variance, sums.samples, sums.samples, spread, spread, mean, mean)


def sample_variance(sums: Sums, mean: Float64) -> Float64:
    """s²/n: (3, n), or (1, n) of all channels together; 0 below two samples."""
    n = np.maximum(sums.samples, 1).astype(np.float64)
    # Σ(x − x̄)² = Σx² − n x̄²; what rounding makes negative is 0.
    products = sums.total * mean
    if len(sums.squares) == 1:
        products = products[:1] + products[1:2] + products[2:]
    spread = np.maximum(sums.squares * (1.0 / SQUARE_SCALE) - products, 0.0)
    result: Float64 = spread / (n * np.maximum(n - 1.0, 1.0))
    return result


def half_variance(sums: Sums) -> Float64:
    """(Ā − B̄)² n_A n_B / n²: (3, n), NaN where a half is empty."""
    (count_a, a), (count_b, b) = sums.half(0), sums.half(1)
    n_a, n_b = count_a.astype(np.float64), count_b.astype(np.float64)
    difference: Float64 = a / np.maximum(n_a, 1) - b / np.maximum(n_b, 1)
    n = np.maximum(sums.samples, 1)
    difference *= difference
    difference *= n_a * n_b / (n * n.astype(np.float64))
    difference[:, (n_a == 0) | (n_b == 0)] = np.nan
    return difference
