"""What a film will tell of its error when it has nine times the samples, as 3 × 3 pixels tell it now.

relMSE weighs a pixel's variance by its level, v / (R² + 0.01 m²). Where light comes in rare bright samples,
most pixels and their neighbours have not met one yet: their level is too low, and relMSE too large, until
they have. On rough glass n E² falls from 5 to 1.5 between 16 samples and 160. The 3 × 3 pixels around each
have met nine times as many of them. With their mean for its level, and for neighbours the windows that touch
its own, a ninth of its variance tells what it will tell by then: its own rare sample is a ninth of that mean,
as it will be.

Pixels of a window are not alike, though. With v ~ Rᵏ about a level that varies within by a share σ,

    mean of v / R² = (1 + ½ (k − 2) (k − 3) σ²) L^(k − 2)

A pixel's own v over the square of its window's level tells too little at an edge, whose dark side takes no
more than its own v over a level that is not dark: on glass 0.7 of what it should. The window's mean v tells
(2 k − 3) σ² too much: it lends a bright pixel's noise to the dark ones beside it; on glass 1.25 times as much
as it should. So half of the variance is the pixel's own, and half its window's. What that says is believed
as far as the square of the factor `fireflies`, which says how much rare samples are to blame for; what it
says beyond that is doubt.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .film import Film
from .film_error import ErrorEstimate, ErrorSums, Float64
from .film_moments import Moments
from .film_noise import around, levels, moments_by_band

ACROSS = 3  # pixels of a window, each way
FURTHER = ACROSS**2  # times the samples
LOG_FURTHER = float(np.log(FURTHER))
REACH = ACROSS // 2
OWN = 0.5  # of the variance is the pixel's, the rest its window's
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
        also what windows say and is not believed.
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
    pixels, windows = ErrorSums(mean), ErrorSums(mean)
    for band in moments_by_band(film):
        moments = as_if_even(band, samples)
        pixels.add(moments)
        for part in of_windows(moments, film.width):
            windows.add(part)
    error, later = pixels.result(), windows.result()
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


def of_windows(moments: Moments, width: int) -> Iterator[Moments]:
    """Each pixel of whole rows of them once, with the mean of its window for level, in nine parts.

    A part is every third pixel each way, whose windows touch and do not overlap: they are each other's
    neighbours. At the rows' ends windows have fewer pixels.
    """
    height = moments.samples.size // width
    inside = around(np.ones((height, width)), REACH)

    def image(values: Float64) -> Float64:
        return values.reshape(-1, height, width)

    def window(values: Float64) -> Float64:
        return np.stack([around(channel, REACH) for channel in image(values)]) / inside

    mean, noise = window(moments.mean), window(moments.independent) / inside
    variance = OWN * image(moments.variance) + (1 - OWN) * window(moments.variance)
    for y in range(min(ACROSS, height)):
        for x in range(min(ACROSS, width)):
            part = np.s_[:, y::ACROSS, x::ACROSS]
            level, v = (values[part].reshape(3, -1) for values in (mean, variance))
            spread = noise[part].reshape(-1)
            samples, parts = (
                counts.reshape(height, width)[part[1:]].reshape(-1)
                for counts in (moments.samples, moments.parts)
            )
            found = Moments(level, v / FURTHER, samples, parts, spread, spread, level, level)
            by_mean, by_median = levels(found, mean[part].shape[-1])
            yield found._replace(level=by_mean, level_by_median=by_median)
