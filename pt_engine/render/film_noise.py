"""The noise of each pixel: its standard error, and the level it is to be compared with.

Independent samples tell it themselves, s²/n. Where samples are correlated within the halves A and B, their
difference is the only unbiased witness, but a pixel has just one such difference. So the pixels around
lend theirs: with u the s²/n that independent samples would have,

    v = ρ u        ρ = mean of ¼ (A − B)² / u over 7 × 7 pixels, per channel, each with weight
                       √(the smaller of its u and the pixel's own, over the larger)

u has the shape of the noise, edges and all, and few of its errors; ρ, what stratification gained, is taken to
be alike where the noise is: not the same on a clean edge and on a sparkling surface beside it. Sums over
pixels use the unbiased differences themselves. For independent samples E ρ = 1 exactly, whatever their
distribution: u does not know how they were dealt to A and B, and all ways are equally likely.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .film_error import weights
from .film_moments import Moments, moments_of

if TYPE_CHECKING:
    from .film import Film

Float64 = NDArray[np.float64]
REACH = 3  # pixels to each side: 49 differences make a standard error good to 10 %
BAND = 1 << 16  # pixels that are worked on at a time, to keep temporaries small
TRUST = 6.0  # a pixel's own brightness counts half at √12 ≈ 3.5 standard errors from its neighbours'
ORDINARY = 2.0  # times the noise around: up to that, noise is no sign of a rare bright sample


def bands(film: Film) -> Iterator[tuple[int, int]]:
    """The image's rows y0 … y1 − 1 in pieces."""
    rows = max(1, BAND // film.width)
    for y in range(0, film.height, rows):
        yield y, min(y + rows, film.height)


def moments_by_band(film: Film) -> Iterator[Moments]:
    """Unbiased moments with their level, band by band."""
    for y0, y1 in bands(film):
        margin = REACH if film.correlated else 1
        first, last = max(0, y0 - margin), min(film.height, y1 + margin)
        moments = moments_of(film.sums(slice(first * film.width, last * film.width)))
        by_mean, by_median = levels(moments, film.width)
        moments = moments._replace(level=by_mean, level_by_median=by_median)
        if film.correlated:
            moments = moments._replace(spread=stratified_spread(moments, film.width))
        yield moments.of(slice((y0 - first) * film.width, (y1 - first) * film.width))


def relative_to_level(variance: Float64, level: Float64, by_median: Float64, floor: float) -> Float64:
    """Mean over channels of v / (R² + floor), between what the two levels say: (n,)."""
    weight = weights(level, floor) * weights(by_median, floor)
    relative: Float64 = (variance * np.sqrt(weight)).mean(axis=0)
    return relative


def levels(moments: Moments, width: int) -> tuple[Float64, Float64]:
    """Radiance of whole rows of pixels, bright ones drawn to the 8 around as far as rare samples explain it.

    A brighter one keeps the share 1 − 6 u / (difference)² of its difference from them, both of the sum of
    channels: an edge stays, a single bright sample (whose difference is about √u) goes. u is the noise beyond
    twice the median of the 9's: ordinary noise makes pixels brighter and darker alike, and to draw only the
    brighter ones would make the level too low, and relMSE too large in the first order of the noise. The
    first time they are drawn to the mean of the 8, the second to the median of the 9. Both are (3, n).
    """
    own = moments.mean.reshape(3, -1, width)
    neighbours = np.stack([around(channel, 1) for channel in own]) - own
    neighbours /= np.maximum(around(np.ones(own.shape[1:]), 1) - 1, 1)
    spread = moments.spread.reshape(1, *own.shape[1:])
    noise = 3 * TRUST * np.maximum(spread - ORDINARY * median_of_9(spread), 0.0)[0]
    drawn = (drawn_to(place, own, noise) for place in (neighbours, median_of_9(own)))
    first, second = (place.reshape(3, -1) for place in drawn)
    return first, second


def drawn_to(place: Float64, own: Float64, noise: Float64) -> Float64:
    """`own` (3, …), brighter ones drawn to `place` as far as their difference is like their noise (…)."""
    difference = own - place
    brighter = difference[0] + difference[1] + difference[2]
    square = brighter**2
    share = np.maximum(square - noise, 0.0) / np.maximum(square, np.finfo(float).tiny)
    difference *= np.where(brighter > 0, share, 1.0)
    difference += place
    return difference


def median_of_9(channels: Float64) -> Float64:
    """Each pixel's median with the 8 around, edges repeated: (channels, height, width).

    Rows of three are sorted first; the median of nine is that of the largest of the smallest, the median of
    the middle ones and the smallest of the largest.
    """
    padded = np.pad(channels, [(0, 0), (1, 1), (1, 1)], mode="edge")
    low, middle, high = (
        (x[..., :-2], x[..., 1:-1], x[..., 2:])
        for x in in_order(padded[:, :-2], padded[:, 1:-1], padded[:, 2:])
    )
    largest_low = np.maximum(np.maximum(low[0], low[1]), low[2])
    smallest_high = np.minimum(np.minimum(high[0], high[1]), high[2])
    return in_order(largest_low, in_order(*middle)[1], smallest_high)[1]


def in_order(a: Float64, b: Float64, c: Float64) -> tuple[Float64, Float64, Float64]:
    """Smallest, middle and largest of three, element by element."""
    low, high = np.minimum(a, b), np.maximum(a, b)
    return np.minimum(low, c), np.maximum(low, np.minimum(high, c)), np.maximum(high, c)


def pixel_variance(film: Film, y0: int, y1: int) -> Float64:
    """Variance of each pixel's mean in rows y0 … y1 − 1: (y1 − y0, width, 3), NaN below two samples."""
    width = film.width
    if not film.correlated:
        variance = film.moments(slice(y0 * width, y1 * width)).variance
        return np.moveaxis(variance.reshape(3, y1 - y0, width), 0, -1)
    first, last = max(0, y0 - REACH), min(film.height, y1 + REACH)
    moments = film.moments(slice(first * width, last * width))
    result = stratified_variance(moments, width).reshape(3, last - first, width)
    return np.moveaxis(result[:, y0 - first : y1 - first], 0, -1)


def stratified_variance(moments: Moments, width: int) -> Float64:
    """ρ u of whole rows of pixels whose samples are correlated: (3, n), NaN below two samples."""
    unknown = np.isnan(moments.variance[0])
    independent = np.where(unknown, 0.0, moments.spread)
    gain = np.where(independent > 0, moments.variance, 0.0) / np.where(independent > 0, independent, 1.0)
    mean_gain = mean_of_alike(gain.reshape(3, -1, width), np.sqrt(independent).reshape(-1, width))
    result = mean_gain.reshape(3, -1) * independent
    result[:, unknown] = np.nan
    return result


def stratified_spread(moments: Moments, width: int) -> Float64:
    """u Σv / Σu, sums over 7 × 7 pixels, v and u means over channels: (n,), quicker than the above."""
    unknown = np.isnan(moments.variance[0])
    independent = np.where(unknown, 0.0, moments.spread)
    variance = np.where(unknown, 0.0, moments.variance.mean(axis=0))
    there, here = (around(x.reshape(-1, width)).reshape(-1) for x in (variance, independent))
    spread: Float64 = independent * (there / np.where(here > 0, here, 1.0))
    return spread


def mean_of_alike(values: Float64, noise: Float64) -> Float64:
    """Mean over the square of pixels around each, by how alike their noise is: (3, height, width).

    Parameters
    ----------
    values : (3, height, width) float64
    noise : (height, width) float64
        Standard errors; pixels with 0 tell nothing.
    """
    height, width = noise.shape
    around_values = np.pad(values, [(0, 0), (REACH, REACH), (REACH, REACH)])
    around_noise = np.pad(noise, REACH)
    total, weights_total = np.zeros_like(values), np.zeros_like(noise)
    own = np.maximum(noise, np.finfo(float).tiny)
    for y in range(2 * REACH + 1):
        for x in range(2 * REACH + 1):
            here = slice(y, y + height), slice(x, x + width)
            weight = np.minimum(around_noise[here], own) / np.maximum(around_noise[here], own)
            total += around_values[:, *here] * weight
            weights_total += weight
    return total / np.maximum(weights_total, np.finfo(float).tiny)


def around(values: Float64, reach: int = REACH) -> Float64:
    """Sum over the square of pixels around each, itself too: (height, width), in one order for all."""
    for axis in range(2):
        padded = np.pad(values, [(reach, reach) if k == axis else (0, 0) for k in range(2)])
        length = values.shape[axis]
        values = np.zeros_like(values)
        for step in range(2 * reach + 1):
            values += padded[step : step + length] if axis == 0 else padded[:, step : step + length]
    return values
