"""How wrong an image is, estimated from its own samples.

With v(p, c) the estimated variance of the mean in pixel p and channel c, R the image and m its mean,

    MSE = mean of v            relMSE = mean of v / (R² + 0.01 m²)            over pixels and channels

which are the expected squared errors against the converged image, for an unbiased estimator.

Confidence: each pixel's v is itself noisy, and independent of the others. The noise is seen in differences
of neighbours, d = v(2k) − v(2k+1): E d² is the sum of both their variances plus the squared difference of
their expectations, so Σ d² over pairs estimates the variance of Σ v, a little too large where the true
variance has edges, never too small. The interval is taken in the logarithm, MSE · exp(± 1.96 σ / MSE), since
the estimate is positive and skewed to the right, as a χ². An image of fewer than 64 pixels
has too few pairs; there v is taken to be χ² with n − 1 degrees of freedom.

What it cannot know: rays that no sample has found yet (a caustic that has not sparkled), and, where a
render stopped *because* this estimate was small, the slight optimism of having stopped there. For Sobol
samples v is the error that independent samples would have; the true one is smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .film import Moments

Float64 = NDArray[np.float64]
ErrorEstimate = dict[str, float | tuple[float, float] | None]
Z95 = 1.959964
FEW_PIXELS = 64


class _Tally:
    """Sum of a quantity over pixels, and the variance of that sum by differences of neighbours."""

    def __init__(self) -> None:
        self.total, self.variance, self.pixels, self.degrees = 0.0, 0.0, 0, 0.0

    def add(self, value: Float64, samples: NDArray[np.uint32]) -> None:
        """`value` (n,) of n consecutive pixels with that many samples."""
        pairs = value[: len(value) // 2 * 2].reshape(-1, 2)
        self.total += float(value.sum())
        self.variance += float(((pairs[:, 0] - pairs[:, 1]) ** 2).sum())
        self.pixels += len(value)
        self.degrees += float((samples - 1.0).sum())

    def result(self) -> tuple[float, tuple[float, float]]:
        mean = self.total / self.pixels
        if mean <= 0:
            return 0.0, (0.0, 0.0)
        few = self.pixels < FEW_PIXELS
        relative = np.sqrt(2.0 / self.degrees) if few else np.sqrt(self.variance) / self.total
        spread = float(np.exp(Z95 * relative))
        return mean, (mean / spread, mean * spread)


def estimate_error(blocks: Callable[[], Iterable[Moments]]) -> ErrorEstimate:
    """mse, mse_ci95, relmse, relmse_ci95; None where no pixel has two samples.

    Parameters
    ----------
    blocks : callable
        Returns the image piece by piece, in the order of pixels. Called twice: relMSE needs the mean first.
    """
    total, pixels, absolute, relative = 0.0, 0, _Tally(), _Tally()
    for block in blocks():
        total += float(block.mean.sum())
        pixels += block.mean.size
    floor = 0.01 * (total / pixels) ** 2
    for block in blocks():
        known = np.flatnonzero(block.samples >= 2)
        variance, count = block.variance[:, known], block.samples[known]
        scale = block.mean[:, known] ** 2 + floor
        absolute.add(variance.mean(axis=0), count)
        relative.add((variance / (scale + (scale == 0))).mean(axis=0), count)
    if not absolute.pixels:
        return {"mse": None, "mse_ci95": None, "relmse": None, "relmse_ci95": None}
    (mse, mse_ci95), (relmse, relmse_ci95) = absolute.result(), relative.result()
    return {"mse": mse, "mse_ci95": mse_ci95, "relmse": relmse, "relmse_ci95": relmse_ci95}
