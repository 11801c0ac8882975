"""When a render is good enough, and which pixels still need samples.

The target error: pixels are dealt to four quarters (`adaptive.RING`), and each is finished when the *others*
are good enough. A quarter that was lucky has only stopped others: neither the image nor what its samples
tell of its error knows of the luck. For that, nothing else may tell one of the other. Each quarter is taken
as an image of its own, with its own mean and its own neighbours, and when a quarter is asked about again
follows from what the others said before. What a quarter tells is n E², the samples that a relative error of 1
would take, with E its error at its n samples; the one that is finished has told its last word. Only so may
a quarter's own samples come round to it: by way of the n at which others were finished, on which what
they tell does not depend on average.

Adaptive sampling: see `adaptive`. A pixel's own samples take no part in the decision about it.

Decisions are made at numbers of samples that follow from the film alone, when all samples before are in it:
they do not depend on threads or tiles.
"""

from __future__ import annotations

from collections.abc import Container

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from .adaptive import RING, Quarter, looks, quarter_relmse, quarter_variance, wanted_samples
from .film import Film
from .schedule import Decide, Step
from .settings import RenderSettings

LEAST = 4  # samples before anything can be decided
GROWTH = 0.25  # of the samples, between two moments when pixels may end
STEP = 8  # samples, at least, between two such moments


def decisions(film: Film, settings: RenderSettings, order: NDArray[np.int32]) -> Decide | None:
    """What `schedule.units` asks; None where nothing depends on the film."""
    if not settings.target_error and not settings.adaptive:
        return None
    least = max(LEAST, settings.min_samples)
    active, coming = order, looks(settings, least)
    look, wanted = float(next(coming)), np.zeros(0)
    asked = dict.fromkeys(quarters(film), least)  # those that go on, and when each is asked about
    told: dict[Quarter, float] = {}  # by each

    @stage("accuracy")
    def decide(done: int) -> Step:
        nonlocal active, look, wanted
        if done < least:
            return Step(least - done, active)
        more = settings.samples or STEP
        if settings.target_error:
            due = [quarter for quarter, when in asked.items() if when <= done]
            if due:
                told.update({quarter: told_by(film, settings, quarter) for quarter in asked})
            for quarter in due:
                asked[quarter] = next_question(told, quarter, settings.target_error, done, asked)
            for quarter in [quarter for quarter in due if asked[quarter] == done]:
                del asked[quarter]
                active = active[~lies_in(quarter, active, film.width)]
            more = min(asked.values(), default=done) - done
        if settings.adaptive and more > 0:
            if done >= look:
                wanted = wanted_samples(film, settings)
                look = next((float(n) for n in coming if n > done), np.inf)
            active = active[wanted[active] > done]
            more = int(min(more, max(STEP, int(done * GROWTH)), look - done))
        return Step(max(0, more), active)

    return decide


def quarters(film: Film) -> list[Quarter]:
    """Those that there are: a single row has but two."""
    return [(y, x) for y, x in RING if y < film.height and x < film.width]


def lies_in(quarter: Quarter, pixels: NDArray[np.int32], width: int) -> NDArray[np.bool_]:
    """Which of some pixels are of a quarter."""
    y, x = np.divmod(pixels, width)
    inside: NDArray[np.bool_] = (y % 2 == quarter[0]) & (x % 2 == quarter[1])
    return inside


def next_question(
    told: dict[Quarter, float], quarter: Quarter, target: float, done: int, going_on: Container[Quarter]
) -> int:
    """At how many samples a quarter is to be asked about again; `done` where the others are good enough."""
    others = [other for other in told if other != quarter] or [quarter]  # of a single pixel, its own
    needed = int(np.ceil(np.mean([told[other] for other in others]) / target**2))
    if needed <= done:
        return done
    if not any(other in going_on for other in others):
        return needed
    # Half of what 1/√n asks for is safe to add unseen, but Sobol points' error may fall faster.
    return done + max(1, min(done, (needed - done) // 2))


def told_by(film: Film, settings: RenderSettings, quarter: Quarter) -> float:
    """n E² of a quarter."""
    known = int(np.max(film.counts()[quarter[0] :: 2, quarter[1] :: 2]))
    return known * quarter_error(film, settings, quarter) ** 2


def quarter_error(film: Film, settings: RenderSettings, quarter: Quarter) -> float:
    """A quarter's √relMSE, or with a percentile the relative error that so many of its pixels are below."""
    if not settings.target_percentile:
        return float(np.sqrt(quarter_relmse(film, quarter)))
    counts = film.counts()[quarter[0] :: 2, quarter[1] :: 2]
    squared = quarter_variance(film, quarter) / np.maximum(counts, 1)
    return float(np.sqrt(np.percentile(squared, settings.target_percentile)))
