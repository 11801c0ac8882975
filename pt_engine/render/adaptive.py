"""Adaptive sampling: how many samples each pixel should get, as other pixels tell.

The samples that minimise relMSE for their sum are in proportion to √(w σ²), a pixel's noise per sample
relative to its level (a Lagrange multiplier makes the gains w σ²/n² equal).

A mean over a number of samples is unbiased if that number does not depend on the samples themselves, by no
way round. So the pixels are dealt to four quarters, as even and odd rows and columns meet, in a ring:

    (0, 0) ← (0, 1) ← (1, 1) ← (1, 0) ← (0, 0)

At each look a quarter is decided by nothing but the next one's samples: their noise, their level, what all is
measured by. How many samples the next one has follows from the one after it at the look before, and so on.
Three looks reach back over three quarters, and a pixel's own samples take no part. With a target error looks
go on, and the fourth may come round: a bright sample must then change three other decisions before one about
its own pixel.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .film import Film
from .film_error import FLOOR, estimate_error
from .film_moments import Moments
from .film_noise import REACH as MARGIN
from .film_noise import around, bands, levels, relative_to_level, stratified_variance
from .settings import RenderSettings

Float64 = NDArray[np.float64]
Quarter = tuple[int, int]
RING: tuple[Quarter, ...] = ((0, 0), (0, 1), (1, 1), (1, 0))  # first row and column; each is told by the next
LOOKS = len(RING) - 1
REACH = 2  # pixels to each side that decide about one: 6 of the next quarter


def looks(settings: RenderSettings, least: int) -> Iterator[int]:
    """At how many samples pixels are decided about: evenly in the logarithm, or doubled until the target."""
    if settings.target_error:
        while True:
            yield least
            least *= 2
    for k in range(LOOKS):
        yield round(least * (settings.samples / least) ** (k / LOOKS))


def wanted_samples(film: Film, settings: RenderSettings) -> Float64:
    """How many each pixel should get, as the quarter next in the ring tells: (pixels,).

    With a target E for the image, n = s · mean(s) / E² with s² = w v n, which makes mean(s²/n) = E². For
    a percentile of pixels, n = s²/E², so that each has error E. Without a target the noisiest per cent of
    pixels get `samples`, others in proportion to s. As many as there are (∞) where no pixel can tell.
    """
    wanted = np.full((film.height, film.width), np.inf)
    for quarter, (y, x) in enumerate(RING):
        witness = RING[(quarter + 1) % len(RING)]
        if witness[0] < film.height and witness[1] < film.width:
            wanted[y::2, x::2] = samples_for_noise(noise_around(film, witness), settings)[y::2, x::2]
    return wanted.reshape(-1)


def samples_for_noise(noise: Float64, settings: RenderSettings) -> Float64:
    """How many samples pixels of such relative noise per sample should get: of the same shape."""
    if settings.target_error and settings.target_percentile:
        return noise**2 / settings.target_error**2
    if settings.target_error:
        return noise * (noise.mean() / settings.target_error**2)
    most = max(float(np.percentile(noise, 99)), 1e-9 * float(np.max(noise)))
    return noise * (settings.samples / most if most > 0 else 0.0)


def noise_around(film: Film, quarter: Quarter) -> Float64:
    """Relative noise per sample around each pixel, of one quarter's pixels alone: (height, width)."""
    y, x = quarter
    squared, there = np.zeros((2, film.height, film.width))
    squared[y::2, x::2], there[y::2, x::2] = quarter_variance(film, quarter), 1.0
    noise: Float64 = np.sqrt(around(squared, REACH) / np.maximum(around(there, REACH), 1.0))
    return noise


def quarter_variance(film: Film, quarter: Quarter) -> Float64:
    """n v / (R² + 0.01 m²) of a quarter's pixels, taken as an image of their own: (rows, columns)."""
    floor = FLOOR * quarter_mean(film, quarter) ** 2
    result = []
    for moments, width, inside in quarter_bands(film, quarter):
        variance = stratified_variance(moments, width) if film.correlated else moments.variance
        relative = relative_to_level(variance, moments.level, moments.level_by_median, floor)
        result.append(np.nan_to_num(relative * moments.samples)[inside])
    return np.concatenate(result).reshape(-1, len(range(quarter[1], film.width, 2)))


def quarter_relmse(film: Film, quarter: Quarter) -> float:
    """What a quarter's pixels tell of their relMSE, taken as an image of their own; 0 where they can't."""
    blocks = (moments.of(inside) for moments, _, inside in quarter_bands(film, quarter))
    relmse = estimate_error(blocks, quarter_mean(film, quarter))["relmse"]
    return relmse if isinstance(relmse, float) else 0.0


def quarter_mean(film: Film, quarter: Quarter) -> float:
    """Of a quarter's pixels and their channels."""
    return float(film.image()[quarter[0] :: 2, quarter[1] :: 2, :3].mean(dtype=np.float64))


def quarter_bands(film: Film, quarter: Quarter) -> Iterator[tuple[Moments, int, slice]]:
    """Band by band: moments of a quarter with levels of its own, its columns, which pixels are not margin."""
    y = quarter[0]
    for y0, y1 in bands(film):
        first, last = max(0, y0 - 2 * MARGIN), min(film.height, y1 + 2 * MARGIN)
        moments, width = quarter_moments(film, quarter, first, last)
        by_mean, by_median = levels(moments, width)
        start, end, skipped = (-((y - row) // 2) for row in (y0, y1, first))  # rows of the quarter
        inside = slice((start - skipped) * width, (end - skipped) * width)
        yield moments._replace(level=by_mean, level_by_median=by_median), width, inside


def quarter_moments(film: Film, quarter: Quarter, first: int, last: int) -> tuple[Moments, int]:
    """Of a quarter's pixels in rows first … last − 1, and how many there are in a row."""
    numbers = np.arange((last - first) * film.width).reshape(-1, film.width)
    chosen = numbers[(quarter[0] - first) % 2 :: 2, quarter[1] :: 2]
    moments = film.moments(slice(first * film.width, last * film.width))
    return moments.of(chosen.reshape(-1)), chosen.shape[1]
