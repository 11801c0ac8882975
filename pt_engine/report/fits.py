"""Means and slopes with their 95 % intervals, from a few independent runs.

Runs with other seeds are independent, points of one run are not: so a number is made of each run, and its
spread over the runs is what Student's t is applied to.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

# Student's t, 97.5 %, for 1, 2, 3 ... degrees of freedom; beyond, the last is a little too wide
T975 = (
    *(12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228),
    *(2.201, 2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086),
)


ZERO, TINIEST = 1e-300, 1e-150  # what stands for 0 on log axes, and what is drawn there by it


class Estimate(NamedTuple):
    """A number and the interval that holds it with a chance of 95 %; NaN ends where nothing is known."""

    value: float
    low: float
    high: float


def tells(low: float, high: float) -> bool:
    """Whether the interval of a positive number tells anything: at most half and twice its middle.

    Two runs have one degree of freedom and t = 12.7: unless they agree by chance it spans decades.
    """
    return math.isfinite(low) and math.isfinite(high) and low > 0 and high <= 4 * low


def mean_of(values: Sequence[float]) -> Estimate:
    """The mean of independent numbers."""
    numbers = np.asarray(values, np.float64)
    mean = float(numbers.mean())
    if len(numbers) < 2:
        return Estimate(mean, math.nan, math.nan)
    half = T975[min(len(numbers) - 1, len(T975)) - 1] * float(numbers.std(ddof=1)) / math.sqrt(len(numbers))
    return Estimate(mean, mean - half, mean + half)


def geometric_mean_of(values: Sequence[float]) -> Estimate:
    """Of positive numbers that spread by factors; 0 where one is 0."""
    if min(values) <= 0:
        return Estimate(float(np.mean(values)), math.nan, math.nan)
    return Estimate(*(math.exp(min(x, 700.0)) for x in mean_of([math.log(v) for v in values])))


def widened(estimate: Estimate, more: float) -> Estimate:
    """The interval of a positive number that is also wrong by up to `more`, whatever the runs tell."""
    if not estimate.value > 0:
        return estimate
    beside = math.log1p(more / estimate.value)
    low, high = (math.hypot(math.log(end / estimate.value), beside) for end in estimate[1:])
    return Estimate(
        estimate.value, estimate.value * math.exp(-low), estimate.value * math.exp(min(high, 700.0))
    )


def slope(x: Sequence[float], y: Sequence[float]) -> float:
    """Least squares d log y / d log x; NaN with fewer than two points or where one is not positive."""
    points = [(a, b) for a, b in zip(x, y, strict=True) if a > 0 and b > 0]
    if len({a for a, _ in points}) < 2:
        return math.nan
    log_x, log_y = np.log(np.array(points)).T
    return float(np.polyfit(log_x, log_y, 1)[0])


def at(x: float, known_x: Sequence[float], known_y: Sequence[float]) -> float:
    """y at x, between known points on log axes; the last beyond them; 0 where one of the two is 0."""
    positive: NDArray[np.float64] = np.maximum(np.asarray(known_y, np.float64), ZERO)
    found = float(np.exp(np.interp(math.log(x), np.log(known_x), np.log(positive))))
    return found if found > TINIEST else 0.0


def two_sided_p(z: float) -> float:
    """Chance of a normal number farther from 0 than z."""
    return math.erfc(abs(z) / math.sqrt(2))
