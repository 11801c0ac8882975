"""How wrong an image is, estimated from its own samples.

With v(p, c) an unbiased estimate of the variance of the mean in pixel p and channel c (`film_moments`), R the
image and m its mean,

    MSE = mean of v            relMSE = mean of v / (R² + 0.01 m²)            over pixels and channels

which for an unbiased estimator of light are the expected squared errors against the converged image, and
RMSE = √MSE. A pixel that a rare bright sample has hit is bright *because* it is wrong; so R is trusted less
where it is brighter than its neighbours by what may be noise (`film_noise.levels`). Whether the neighbours'
own bright samples are light or noise cannot be told either: R is made with them (drawn to the neighbours'
mean) and without (to the median), and relMSE is the geometric mean of what both give. They agree within a few
per cent where no sample is rare; the factor between them is told as `fireflies`.

The interval holds the error of *this very* image. Its squared error e² in a pixel and the estimate v
differ by

    Var(e² − v) = 2 σ⁴ k / (k − 1)        σ² = E v, k the independent values behind v

whatever the distribution of the samples: what a long tail adds to e² and to v alike cancels in their
difference. Pixels are independent of each other (each sample belongs to one, drawn from the pixel filter;
Sobol points are shifted for each), so the variances of a sum add up. σ² is told by the s²/n of all n samples,
where those are correlated times what the pixels around say that stratification gained
(`film_noise.stratified_spread`), which has less noise than v; σ⁴ is its square times (n − 1)/(n + 1),
unbiased where s² is a χ², and too large for long tails. Channels are taken as fully correlated, the worst
case, and nearly true for light of one colour. The interval is taken in the logarithm, since the estimate is
positive and skewed to the right: MSE · exp(± 1.96 s / MSE). For relMSE, half of the logarithm of the factor
`fireflies` is one more such width, added as squares are. The interval is wider than one for the *expected*
error of such an image.

What it cannot know: light that no sample has found yet (a caustic that has not sparkled).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from .film_moments import Moments

Float64 = NDArray[np.float64]
ErrorEstimate = dict[str, float | tuple[float, float] | None]
Z95 = 1.959964
FLOOR = 0.01  # of the squared mean, in relMSE
WORTH_TELLING = 1.5  # of `fireflies`
NAMES = ("mse", "relmse", "rmse")
OTHERS = ("fireflies", "stratified")


class _Tally:
    """Sum of v over pixels, and the variance of its difference from Σ e²."""

    def __init__(self) -> None:
        self.total, self.pixels = 0.0, 0
        self.noise, self.variance = 0.0, 0.0

    def add(self, value: Float64, noise: Float64, known: Moments) -> None:
        """`value` v (n,) of n pixels, and `noise` in proportion to its σ²."""
        n, k = known.samples.astype(np.float64), known.parts.astype(np.float64)
        self.total += float(value.sum())
        self.noise += float(noise.sum())
        self.variance += float((noise * noise * ((n - 1) / (n + 1) * 2 * k / (k - 1))).sum())
        self.pixels += len(value)

    def result(self) -> tuple[float, float]:
        """The mean of v, and the half width of its interval in the logarithm."""
        if self.total <= 0:
            return 0.0, 0.0
        return self.total / self.pixels, Z95 * float(np.sqrt(self.variance)) / (self.noise or self.total)


class ErrorSums:
    """What `estimate_error` adds up, for an image of such a mean over pixels and channels."""

    def __init__(self, mean: float) -> None:
        self.absolute, self.relative, self.by_median = _Tally(), _Tally(), _Tally()
        self.floor, self.independent = FLOOR * mean**2, 0.0

    def add(self, block: Moments) -> None:
        """A piece of the image."""
        finite = np.isfinite(block.variance[0])
        known = block if finite.all() else block.of(np.flatnonzero(finite))
        self.absolute.add(known.variance.mean(axis=0), known.spread, known)
        for tally, level in ((self.relative, known.level), (self.by_median, known.level_by_median)):
            weight = weights(level, self.floor)
            tally.add((known.variance * weight).mean(axis=0), known.spread * weight.mean(axis=0), known)
            self.independent += float((known.independent * weight.mean(axis=0)).sum())

    def result(self) -> ErrorEstimate:
        """Of all pieces so far."""
        if not self.absolute.pixels:
            return dict.fromkeys([key for name in NAMES for key in (name, f"{name}_ci95")] + list(OTHERS))
        mse, mse_ci95 = _with_interval(*self.absolute.result())
        (first, first_width), (second, second_width) = self.relative.result(), self.by_median.result()
        doubt = float(np.log(max(first, second) / min(first, second))) if first > 0 else 0.0
        width = float(np.hypot((first_width + second_width) / 2, doubt / 2))
        relmse, relmse_ci95 = _with_interval(float(np.sqrt(first * second)), width)
        stratified = self.relative.total + self.by_median.total
        return {
            "mse": mse,
            "mse_ci95": mse_ci95,
            "relmse": relmse,
            "relmse_ci95": relmse_ci95,
            "rmse": float(np.sqrt(mse)),
            "rmse_ci95": (float(np.sqrt(mse_ci95[0])), float(np.sqrt(mse_ci95[1]))),
            "fireflies": float(np.exp(doubt)),
            "stratified": stratified / self.independent if self.independent > 0 else 1.0,
        }


def estimate_error(blocks: Iterable[Moments], mean: float) -> ErrorEstimate:
    """`mse`, `relmse`, `rmse` and each's `_ci95`, `fireflies`, and `stratified`: what stratification left.

    None where no pixel's variance is known. The last is relMSE over what independent samples of the same
    spread would have, 1 for those.

    Parameters
    ----------
    blocks : iterable
        The image piece by piece.
    mean : float
        Of the whole image, over pixels and channels.
    """
    sums = ErrorSums(mean)
    for block in blocks:
        sums.add(block)
    return sums.result()


def _with_interval(value: float, width: float) -> tuple[float, tuple[float, float]]:
    """A value, and its interval of a half width in the logarithm."""
    return value, (value * float(np.exp(-width)), value * float(np.exp(width)))


def weights(level: Float64, floor: float) -> Float64:
    """1 / (R² + floor), what squared errors are multiplied with; 1 where all is black."""
    scale = level**2 + floor
    result: Float64 = 1.0 / (scale + (scale == 0))
    return result
