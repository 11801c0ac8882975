"""When the error will be down to what: a line through what it was so far, in logarithms.

    relMSE(n) = c n⁻ᵃ        a = 1 for independent samples, somewhat more for Sobol points

The exponent starts as what is known of the sampler and learns from the error now and at a quarter of the
samples. Sobol points are looked at where their number is a power of two: between these the error falls now
fast, now not at all. The time goes on at the pace of the last half. Both, and the error's own interval, make
the interval.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.clock import stage
from ..core.samplers import SAMPLERS
from .film_error import Z95

if TYPE_CHECKING:
    from .progressive import Progress

FIRST_LOOK = 4  # samples
GROWTH = 1.25  # of samples between looks, where they are independent
SHARE, FIRST_SHARE = 0.02, 0.1  # of the render's time that looking at the film may take, and its first look
ALLOWANCE = 0.02  # seconds beyond
PIXEL_COST = 1e-6  # seconds of the first look for each pixel, before that is known
EARLY = 0.1  # of a render: what was foretold there is kept
EXPONENT = {False: (1.0, 0.02), True: (1.1, 0.08)}  # mean and spread; correlated samples or not
UNEVEN = {False: 0.0, True: 0.2}  # spread of log relMSE about the line
PACE_SPREAD = 0.04  # of the time for a sample
ROUND = tuple(m * 10.0**e for e in range(1, -7, -1) for m in (5, 2, 1))


class Look(NamedTuple):
    """Samples per pixel, seconds and relMSE at one moment, and the standard deviation of its logarithm."""

    samples: float
    seconds: float
    relmse: float
    spread: float


class Prediction(NamedTuple):
    """Of the seconds, from the start, and the samples at which the relative error will be `target`.

    `seconds_ci95` holds with a chance of 95 %. `from_samples` says how early it was made; `error_at_end`,
    where samples or time are limited, the relative error then.
    """

    target: float
    seconds: float
    seconds_ci95: tuple[float, float]
    samples: float
    from_samples: float
    error_at_end: float | None


class Forecast:
    """Looks at the film now and then, and foretells.

    Attributes
    ----------
    history : list of Look
    latest, early : Prediction or None
        The last one, and that made at a tenth of the render.
    """

    def __init__(self) -> None:
        self.history: list[Look] = []
        self.latest: Prediction | None = None
        self.early: Prediction | None = None
        self._next, self._cost, self._last_cost = float(FIRST_LOOK), 0.0, 0.0

    @stage("accuracy")
    def look(self, progress: Progress) -> None:
        """Take the error's measure if it is time for it."""
        samples = progress.camera_samples / progress.film.pixels
        if samples < self._next or not self._affordable(progress):
            return
        started = time.thread_time()
        correlated = SAMPLERS[progress.settings.sampler].correlated
        self._next = 2.0 ** np.floor(np.log2(samples) + 1) if correlated else samples * GROWTH
        error = progress.film.error()
        relmse, interval = error["relmse"], error["relmse_ci95"]
        if isinstance(relmse, float) and isinstance(interval, tuple) and relmse > 0:
            spread = float(np.hypot(np.log(interval[1] / relmse) / Z95, UNEVEN[correlated]))
            self.history.append(Look(samples, progress.elapsed, relmse, spread))
            self.latest = self._foretell(progress)
            if self.early is None and self._part(progress) >= EARLY:
                self.early = self.latest
        self._last_cost = time.thread_time() - started
        self._cost += self._last_cost

    def _affordable(self, progress: Progress) -> bool:
        """Whether one more look keeps to its share of the time."""
        share = SHARE if self._last_cost else FIRST_SHARE
        expected = self._last_cost or PIXEL_COST * progress.film.pixels
        return self._cost + expected <= share * progress.elapsed + ALLOWANCE

    def _part(self, progress: Progress) -> float:
        """How much of the render is done, by its limits or by its target."""
        assert self.latest is not None
        by_target = progress.elapsed / self.latest.seconds if progress.settings.target_error else 0.0
        return max(progress.fraction, by_target)

    def _foretell(self, progress: Progress) -> Prediction:
        settings, now = progress.settings, self.history[-1]
        now_error = float(np.sqrt(now.relmse))
        target = settings.target_error or next((r for r in ROUND if r < 0.95 * now_error), 0.0)
        exponent, spread = fitted_exponent(self.history, *EXPONENT[SAMPLERS[settings.sampler].correlated])
        half = min(self.history, key=lambda look: abs(look.samples - now.samples / 2))
        elapsed, done = (now.seconds - half.seconds, now.samples - half.samples)
        pace = elapsed / done if done > 0 else now.seconds / now.samples

        def seconds(samples: float) -> float:
            return now.seconds + (samples - now.samples) * pace

        decades = 2 * float(np.log(now_error / target)) if target else 0.0
        samples = now.samples * float(np.exp(decades / exponent))
        log_spread = np.hypot(now.spread / exponent, decades / exponent**2 * spread)
        low, high = (
            seconds(max(now.samples, samples * float(np.exp(sign * Z95 * log_spread)))) for sign in (-1, 1)
        )
        expected = seconds(samples)
        low, high = (
            max(now.seconds, expected - np.hypot(expected - low, Z95 * PACE_SPREAD * expected)),
            expected + np.hypot(high - expected, Z95 * PACE_SPREAD * expected),
        )
        ends = [float(settings.samples)] if settings.samples else []
        if settings.seconds:
            ends.append(now.samples + (settings.seconds - now.seconds) / pace)
        at_end = now_error * (max(min(ends), now.samples) / now.samples) ** (-exponent / 2) if ends else None
        return Prediction(target, expected, (float(low), float(high)), samples, now.samples, at_end)


def fitted_exponent(history: list[Look], prior: float, prior_spread: float) -> tuple[float, float]:
    """a and its standard deviation, from the last look and that at a quarter of its samples."""
    now = history[-1]
    then = min(history, key=lambda look: abs(look.samples - now.samples / 4))
    span = float(np.log(now.samples / then.samples))
    if span < 0.5:
        return prior, prior_spread
    seen = float(np.log(then.relmse / now.relmse)) / span
    variance = (then.spread**2 + now.spread**2) / span**2
    weight = prior_spread**2 / (prior_spread**2 + variance)
    return prior + weight * (seen - prior), prior_spread * float(np.sqrt(1 - weight))
