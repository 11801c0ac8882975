"""What a film will tell of its error when it has nine times the samples, as 3 × 3 pixels tell it now.

relMSE weighs a pixel's variance by its level, v / (R² + 0.01 m²). Where light comes in rare bright samples,
most pixels and their neighbours have not met one yet: their level is too low, and relMSE too large, until
they have. On rough glass n E² falls from 5 to 1.5 between 16 samples and 160. A block of 3 × 3 pixels has met
nine times as many of them. Taken as one pixel, with its mean, the variance of that mean and blocks for
neighbours, it tells what its pixels will tell by then. What it does not see are edges and textures inside of
blocks. So it is believed as far as the square of the factor `fireflies`, which says how much rare samples
are to blame for; what it says beyond that is doubt.

Blocks can be laid in nine ways. Three of them, along a diagonal, are taken together: an edge that lies well
for one of them does not for another.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .film import Film
from .film_error import ErrorEstimate, ErrorSums, Float64
from .film_moments import Moments
from .film_noise import levels, moments_by_band

ACROSS = 3  # pixels of a block, each way
FURTHER = ACROSS**2  # times the samples
LOG_FURTHER = float(np.log(FURTHER))
BELIEVED = 4.0  # times the doubt: the square of `fireflies`


class Outlook(NamedTuple):
    """What a film tells now, and later.

    Attributes
    ----------
    error : dict
        As `Film.error` gives it, of pixels that all had the mean number of samples.
    falls : float
        By how much less the logarithm of n E² will be at `FURTHER` times the samples; 0 or more.
    doubt : (float, float)
        In the logarithm of relMSE, now and then: a half width as of 95 %. Half that of `fireflies`, and then
        also what blocks say and are not believed.
    """

    error: ErrorEstimate
    falls: float
    doubt: tuple[float, float]


def outlook(film: Film, even: bool) -> Outlook | None:
    """What a film tells; None where no pixel's variance is known or none is above 0.

    Parameters
    ----------
    even : bool
        Whether all pixels are to have alike many samples: within a pass some are ahead.
    """
    samples = float(film.counts().mean()) if even else 0.0
    mean = film.mean()
    pixels, blocks = ErrorSums(mean), ErrorSums(mean)
    for band in moments_by_band(film):
        moments = as_if_even(band, samples)
        pixels.add(moments)
        for skipped in range(ACROSS):
            if min(moments.samples.size // film.width, film.width) >= skipped + ACROSS:
                blocks.add(of_blocks(moments, film.width, skipped))
    error, later = pixels.result(), blocks.result()
    told, fireflies = error["relmse"], error["fireflies"]
    if not isinstance(told, float) or not isinstance(fireflies, float) or told <= 0:
        return None
    now = 0.5 * float(np.log(fireflies))
    relmse, doubt = later["relmse"], later["fireflies"]
    if not isinstance(relmse, float) or not isinstance(doubt, float) or relmse <= 0:
        return Outlook(error, 0.0, (now, now))
    found = float(np.log(told / relmse)) - LOG_FURTHER
    falls = min(max(found, 0.0), BELIEVED * now)
    then = float(np.hypot(min(now, 0.5 * np.log(doubt)), found - falls))
    return Outlook(error, falls, (now, then))


def as_if_even(moments: Moments, samples: float) -> Moments:
    """With variances of so many samples in each pixel, by 1/n; as they are if that is 0."""
    if not samples:
        return moments
    ahead = moments.samples / samples
    return moments._replace(
        variance=moments.variance * ahead,
        independent=moments.independent * ahead,
        spread=moments.spread * ahead,
    )


def of_blocks(moments: Moments, width: int, skipped: int) -> Moments:
    """Of blocks in place of pixels, for whole rows of them; the first lies so far from the corner."""
    height = moments.samples.size // width
    rows, columns = ((n - skipped) // ACROSS for n in (height, width))

    def total(values: NDArray[Any]) -> Float64:
        image = values.reshape(-1, height, width)
        image = image[:, skipped : skipped + ACROSS * rows, skipped : skipped + ACROSS * columns]
        high = image[:, ::ACROSS] + image[:, 1::ACROSS] + image[:, 2::ACROSS]
        sums: Float64 = high[..., ::ACROSS] + high[..., 1::ACROSS] + high[..., 2::ACROSS]
        return sums.reshape(len(image), -1)

    mean, variance = total(moments.mean) / FURTHER, total(moments.variance) / FURTHER**2
    [independent], [samples] = total(moments.independent) / FURTHER**2, total(moments.samples)
    # variances of k values each, FURTHER of them: together as good as one of so many
    [parts] = total(moments.parts - 1.0) + 1.0
    blocks = Moments(mean, variance, samples, parts, independent, independent, mean, mean)
    by_mean, by_median = levels(blocks, columns)
    return blocks._replace(level=by_mean, level_by_median=by_median)
