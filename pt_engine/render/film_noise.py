"""The standard error of each pixel.

Independent samples tell it themselves, s²/n. Where samples are correlated within the halves A and B, the
halves' difference is the only unbiased witness, but a pixel has just one such difference. So the pixels around
lend theirs: with u the s²/n that independent samples would have,

    v = ρ u        ρ = mean of ¼ (A − B)² / u over 7 × 7 pixels, per channel

u has the shape of the noise, edges and all, and few of its errors; ρ, what stratification gained, changes
slowly over the image. For independent samples E ρ = 1 exactly, whatever their distribution, since all ways to
deal the samples to A and B are equally likely.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .film_moments import half_variance, moments_of, sample_variance

if TYPE_CHECKING:
    from .film import Film

Float64 = NDArray[np.float64]
REACH = 3  # pixels to each side: 49 differences make a standard error good to 10 %


def pixel_variance(film: Film, y0: int, y1: int) -> Float64:
    """Variance of each pixel's mean in rows y0 … y1 − 1: (y1 − y0, width, 3), NaN below two samples."""
    width = film.width
    if not film.correlated:
        variance = film.moments(slice(y0 * width, y1 * width)).variance
        return np.moveaxis(variance.reshape(3, y1 - y0, width), 0, -1)
    first, last = max(0, y0 - REACH), min(film.height, y1 + REACH)
    sums = film.sums(slice(first * width, last * width))
    mean = moments_of(sums).mean
    independent = sample_variance(sums, mean)[0]
    halves = half_variance(sums)
    unknown = np.isnan(halves[0])
    told = ~unknown & (independent > 0)
    ratio = np.where(told, halves, 0.0) / np.where(told, independent, 1.0)
    shape = (last - first, width)
    pixels = around(told.astype(np.float64).reshape(shape))
    result = np.empty((3, *shape))
    for channel in range(3):
        gain = around(ratio[channel].reshape(shape)) / np.maximum(pixels, 1.0)
        result[channel] = gain * independent.reshape(shape)
    result[:, unknown.reshape(shape)] = np.nan
    return np.moveaxis(result[:, y0 - first : y0 - first + y1 - y0], 0, -1)


def around(values: Float64) -> Float64:
    """Sum over the square of pixels around each: (height, width), in the same order for every pixel."""
    for axis in range(2):
        padded = np.pad(values, [(REACH, REACH) if k == axis else (0, 0) for k in range(2)])
        length = values.shape[axis]
        values = np.zeros_like(values)
        for step in range(2 * REACH + 1):
            values += padded[step : step + length] if axis == 0 else padded[:, step : step + length]
    return values
