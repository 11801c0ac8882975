"""When the error will be down to what: a line through what it is now, in logarithms.

    relMSE(n) = c n⁻ᵃ        a = 1 + ⅔ (1 − s)²

s is what stratification left of the error so far (`film_error`): 1 for independent samples, whose error falls
as 1/n exactly. Sobol points go on gaining where they have gained; how much so is read off six rooms, which
lie within 0.05 of that a. They lie best at powers of two: between them the error is above that line by
⅕ (1 − s)² in the logarithm.

What is told falls faster while rare samples are told from light:

    relMSE(n) = c n⁻ᵃ exp(e/n)

since by the square of a level's relative noise, which is as 1/n, is relMSE too large in the first order. How
far that will be down at nine times the samples, windows of pixels tell now (`film_windows`).

The time goes on at the pace of the last half. Both, and the error's own interval, make the interval.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..core.clock import stage
from ..core.samplers import SAMPLERS
from .film_error import Z95
from .film_windows import FURTHER, LOG_FURTHER, outlook

if TYPE_CHECKING:
    from .progressive import Progress

FIRST_LOOK = 4  # samples
GROWTH = 1.125  # of samples between looks
SHARE, FIRST_SHARE = 0.02, 0.1  # of the render's time that looking at the film may take, and its first look
ALLOWANCE = 0.02  # seconds beyond
PIXEL_COST = 1e-6  # seconds of the first look for each pixel, before that is known
EARLY = 0.1  # of a render: what was foretold there is told in the end
GOES_ON = 2 / 3  # of the square of what stratification has gained
BETWEEN = 1 / 5  # of that square is the logarithm of the error higher between powers of two
STEPS = 16  # of Newton, more than it takes from 0 on: its lines lie above the curve, so it never overshoots
EXPONENT_SPREAD = {False: 0.01, True: 0.05}  # correlated samples or not
UNEVEN = {False: 0.0, True: 0.03}  # spread of log relMSE about the line, beyond its own
PACE_SPREAD = 0.04  # of the time for a sample
ROUND = tuple(m * 10.0**e for e in range(1, -7, -1) for m in (5, 2, 1))


class Look(NamedTuple):
    """Samples per pixel, seconds and relMSE at one moment, and what it says of later ones.

    Attributes
    ----------
    spread : float
        Standard deviation of relMSE's logarithm, beside `doubt`.
    stratified : float
        s, what stratification left.
    falls, doubt
        See `film_windows.Outlook`.
    best : float
        Part of the pixels that have a power of two samples.
    """

    samples: float
    seconds: float
    relmse: float
    spread: float
    stratified: float = 1.0
    falls: float = 0.0
    doubt: tuple[float, float] = (0.0, 0.0)
    best: float = 0.0

    @property
    def gained(self) -> float:
        """Square of what stratification has gained."""
        return (1.0 - self.stratified) ** 2

    @property
    def exponent(self) -> float:
        """The a of n⁻ᵃ."""
        return exponent_of(self.stratified)

    def falls_by(self, growth: float) -> float:
        """How far relMSE's logarithm is down when that of the samples has grown."""
        return self.exponent * growth - self.excess * float(np.expm1(-growth))

    @property
    def excess(self) -> float:
        """How far relMSE's logarithm is above the line: the e/n of now."""
        return self.falls / (1.0 - 1.0 / FURTHER)

    def growth_until(self, fall: float) -> float:
        """How much the logarithm of the samples grows until relMSE's is so far down: by Newton."""
        fall += BETWEEN * self.gained * self.best
        growth = 0.0
        for _ in range(STEPS):
            slope = self.exponent + self.excess * float(np.exp(-growth))
            growth += (fall - self.falls_by(growth)) / slope
        return growth

    def spread_after(self, growth: float, exponent_spread: float) -> float:
        """Standard deviation of the growth that was foretold."""
        doubt = float(np.interp(growth, (0.0, LOG_FURTHER), self.doubt)) / Z95
        return float(np.linalg.norm((self.spread, doubt, growth * exponent_spread))) / self.exponent


def exponent_of(stratified: float) -> float:
    """The a of n⁻ᵃ, by what stratification has left of the error."""
    return 1.0 + GOES_ON * (1.0 - stratified) ** 2


class Prediction(NamedTuple):
    """Of the seconds, from the start, and the samples at which the relative error will be `target`.

    Each `_ci95` holds with a chance of 95 %. `from_samples` says how early it was made; `error_at_end`,
    where samples or time are limited, the relative error then.
    """

    target: float
    seconds: float
    seconds_ci95: tuple[float, float]
    samples: float
    samples_ci95: tuple[float, float]
    from_samples: float
    error_at_end: float | None


class Forecast:
    """Looks at the film now and then, and foretells.

    Attributes
    ----------
    history : list of Look
    predictions : list of Prediction
        What was foretold at each of them.
    """

    def __init__(self) -> None:
        self.history: list[Look] = []
        self.predictions: list[Prediction] = []
        self._next, self._cost, self._last_cost = float(FIRST_LOOK), 0.0, 0.0

    @property
    def latest(self) -> Prediction | None:
        """What was foretold last."""
        return self.predictions[-1] if self.predictions else None

    def early(self, samples: float) -> Prediction | None:
        """What was foretold first from a tenth of so many samples on."""
        return next((p for p in self.predictions if p.from_samples >= EARLY * samples), self.latest)

    @stage("accuracy")
    def look(self, progress: Progress) -> None:
        """Take the error's measure if it is time for it."""
        samples = progress.camera_samples / progress.film.pixels
        if samples < self._next or not self._affordable(progress):
            return
        started = time.thread_time()
        correlated = SAMPLERS[progress.settings.sampler].correlated
        self._next = samples * GROWTH
        # adaptive sampling leaves pixels with different numbers for good
        if found := outlook(progress.film, even=not progress.settings.adaptive):
            error, doubt = found.error, found.doubt[0]
            relmse, interval, stratified = (error[key] for key in ("relmse", "relmse_ci95", "stratified"))
            assert isinstance(relmse, float) and isinstance(interval, tuple)  # noqa: PT018
            assert isinstance(stratified, float)
            own = max(float(np.log(interval[1] / relmse)) ** 2 - doubt**2, 0.0) ** 0.5 / Z95
            spread = float(np.hypot(own, UNEVEN[correlated]))
            left = min(stratified, 1.0) if correlated else 1.0
            counts = progress.film.counts()
            best = float(np.mean(counts & (counts - 1) == 0))
            self.history.append(
                Look(samples, progress.elapsed, relmse, spread, left, found.falls, found.doubt, best)
            )
            self.predictions.append(self._foretell(progress))
        self._last_cost = time.thread_time() - started
        self._cost += self._last_cost

    def _affordable(self, progress: Progress) -> bool:
        """Whether one more look keeps to its share of the time."""
        share = SHARE if self._last_cost else FIRST_SHARE
        expected = self._last_cost or PIXEL_COST * progress.film.pixels
        return self._cost + expected <= share * progress.elapsed + ALLOWANCE

    def _foretell(self, progress: Progress) -> Prediction:
        settings, now = progress.settings, self.history[-1]
        now_error = float(np.sqrt(now.relmse))
        target = settings.target_error or next((r for r in ROUND if r < 0.95 * now_error), 0.0)
        uncertain = EXPONENT_SPREAD[SAMPLERS[settings.sampler].correlated]
        half = min(self.history, key=lambda look: abs(look.samples - now.samples / 2))
        elapsed, done = (now.seconds - half.seconds, now.samples - half.samples)
        pace = elapsed / done if done > 0 else now.seconds / now.samples

        def seconds(samples: float) -> float:
            return now.seconds + (samples - now.samples) * pace

        growth = now.growth_until(2 * float(np.log(now_error / target))) if target else 0.0
        samples = now.samples * float(np.exp(growth))
        width = Z95 * now.spread_after(growth, uncertain)
        low, high = (max(now.samples, samples * float(np.exp(by))) for by in (-width, width))
        expected, paced = seconds(samples), Z95 * PACE_SPREAD * seconds(samples)
        earliest = max(now.seconds, expected - float(np.hypot(expected - seconds(low), paced)))
        latest = expected + float(np.hypot(seconds(high) - expected, paced))
        ends = [float(settings.samples)] if settings.samples else []
        if settings.seconds:
            ends.append(now.samples + (settings.seconds - now.seconds) / pace)
        further = float(np.log(max(min(ends), now.samples) / now.samples)) if ends else 0.0
        at_end = now_error * float(np.exp(-now.falls_by(further) / 2)) if ends else None
        return Prediction(target, expected, (earliest, latest), samples, (low, high), now.samples, at_end)
