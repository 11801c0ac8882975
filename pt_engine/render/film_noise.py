"""The noise of each pixel: its standard error, and the level it is to be compared with.

Independent samples tell it themselves, s²/n. Where samples are correlated within the halves A and B, their
difference is the only unbiased witness, but a pixel has just one such difference. So the pixels around
lend theirs: with u the s²/n that independent samples would have,

    v = ρ u        ρ = mean of ¼ (A − B)² / u over 7 × 7 pixels, per channel

u has the shape of the noise, edges and all, and few of its errors; ρ, what stratification gained, is taken to
change slowly over the image. Where it does not (a clean edge beside rare bright samples) the standard error
of a pixel is off, while sums over pixels use the unbiased differences themselves. For independent samples
E ρ = 1 exactly, whatever their distribution: all ways to deal the samples to A and B are equally likely.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core.hashing import lowbias32
from .film_error import FLOOR, weights
from .film_moments import Moments, moments_of

if TYPE_CHECKING:
    from .film import Film

Float64 = NDArray[np.float64]
REACH = 3  # pixels to each side: 49 differences make a standard error good to 10 %
BAND = 1 << 16  # pixels that are worked on at a time, to keep temporaries small
TRUST = 6.0  # a pixel's own brightness counts half at √12 ≈ 3.5 standard errors from its neighbours'


def bands(film: Film) -> Iterator[tuple[int, int]]:
    """The image's rows y0 … y1 − 1 in pieces."""
    rows = max(1, BAND // film.width)
    for y in range(0, film.height, rows):
        yield y, min(y + rows, film.height)


def moments_by_band(film: Film, half: int | None = None) -> Iterator[Moments]:
    """Unbiased moments with their level, of all pixels or of one random half of them, band by band."""
    for y0, y1 in bands(film):
        first, last = max(0, y0 - 1), min(film.height, y1 + 1)
        sums = film.sums(slice(first * film.width, last * film.width))
        moments = moments_of(sums)
        moments = moments._replace(level=level(moments, film.width))
        inside = np.arange((y0 - first) * film.width, (y1 - first) * film.width)
        if half is not None:
            inside = inside[drawn_half(y0 * film.width, inside.size) == half]
        yield moments.of(inside)


def relative_variance(film: Film) -> Float64:
    """Mean over channels of v / (R² + 0.01 m²) of each pixel: (height, width), NaN below two samples."""
    floor = FLOOR * film.mean() ** 2
    result = np.empty((film.height, film.width))
    for (y0, y1), moments in zip(bands(film), moments_by_band(film), strict=True):
        variance = np.moveaxis(pixel_variance(film, y0, y1), -1, 0).reshape(3, -1)
        relative = (variance * weights(moments.level, floor)).mean(axis=0)
        result[y0:y1] = relative.reshape(y1 - y0, film.width)
    return result


def drawn_half(first: int, count: int) -> NDArray[np.uint32]:
    """Which random half, 0 or 1, each pixel from `first` on is of: (count,), the same in every render."""
    return lowbias32(np.arange(first, first + count, dtype=np.uint32)) & np.uint32(1)


def level(moments: Moments, width: int) -> Float64:
    """Radiance of whole rows of pixels, bright ones drawn to the 8 around as far as it may be noise: (3, n).

    A brighter one keeps the share 1 − 6 u / (difference)² of its difference from them, both of the sum of
    channels: an edge stays, a single bright sample (whose difference is about √u) goes.
    """
    own = moments.mean.reshape(3, -1, width)
    neighbours = np.stack([around(channel, 1) for channel in own]) - own
    neighbours /= np.maximum(around(np.ones(own.shape[1:]), 1) - 1, 1)
    difference = own - neighbours
    brighter = difference[0] + difference[1] + difference[2]
    noise = 3 * TRUST * moments.spread.reshape(brighter.shape)
    square = brighter**2
    share = np.maximum(square - noise, 0.0) / np.maximum(square, np.finfo(float).tiny)
    difference *= np.where(brighter > 0, share, 1.0)
    return (neighbours + difference).reshape(3, -1)


def pixel_variance(film: Film, y0: int, y1: int) -> Float64:
    """Variance of each pixel's mean in rows y0 … y1 − 1: (y1 − y0, width, 3), NaN below two samples."""
    width = film.width
    if not film.correlated:
        variance = film.moments(slice(y0 * width, y1 * width)).variance
        return np.moveaxis(variance.reshape(3, y1 - y0, width), 0, -1)
    first, last = max(0, y0 - REACH), min(film.height, y1 + REACH)
    moments = film.moments(slice(first * width, last * width))
    independent, halves = moments.spread, moments.variance
    unknown = np.isnan(halves[0])
    told = ~unknown & (independent > 0)
    ratio = np.where(told, halves, 0.0) / np.where(told, independent, 1.0)
    shape = (last - first, width)
    pixels = np.maximum(around(told.astype(np.float64).reshape(shape)), 1.0)
    result = np.stack([around(channel.reshape(shape)) / pixels for channel in ratio])
    result *= independent.reshape(shape)
    result[:, unknown.reshape(shape)] = np.nan
    return np.moveaxis(result[:, y0 - first : y1 - first], 0, -1)


def around(values: Float64, reach: int = REACH) -> Float64:
    """Sum over the square of pixels around each, itself too: (height, width), in one order for all."""
    for axis in range(2):
        padded = np.pad(values, [(reach, reach) if k == axis else (0, 0) for k in range(2)])
        length = values.shape[axis]
        values = np.zeros_like(values)
        for step in range(2 * reach + 1):
            values += padded[step : step + length] if axis == 0 else padded[:, step : step + length]
    return values
