"""When a render is good enough, and which pixels still need samples.

The target error: pixels are dealt to four quarters in a ring (`adaptive.RING`), and each is finished when the
*next* one is good enough. A quarter that was lucky has only stopped another: neither the image nor what its
samples tell of its error knows of the luck. For that, nothing else may tell one of the other. Each quarter
is taken as an image of its own, with its own mean and its own neighbours, and when a quarter is asked about
again follows from what was said about it before. Where the one that tells is finished itself, it has the
last word: n (E/target)², with E its error at its n samples. Only so may a quarter's own samples come round to
it, if all finish in turn, by way of that n, on which what is told does not depend on average.

Adaptive sampling: see `adaptive`. A pixel's own samples take no part in the decision about it.

Decisions are made at numbers of samples that follow from the film alone, when all samples before are in it:
they do not depend on threads or tiles.
"""

from __future__ import annotations

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
    witnesses = ring(film)
    asked = dict.fromkeys(witnesses, least)  # the quarters that go on, and when each is asked about

    @stage("accuracy")
    def decide(done: int) -> Step:
        nonlocal active, look, wanted
        if done < least:
            return Step(least - done, active)
        more = settings.samples or STEP
        if settings.target_error:
            for quarter in [q for q, when in asked.items() if when <= done]:
                asked[quarter] = next_question(film, settings, done, witnesses[quarter])
                if asked[quarter] == done:
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


def ring(film: Film) -> dict[Quarter, Quarter]:
    """Each quarter's witness, the next that there is: a single row has but two."""
    there = [(y, x) for y, x in RING if y < film.height and x < film.width]
    return dict(zip(there, there[1:] + there[:1], strict=True))


def lies_in(quarter: Quarter, pixels: NDArray[np.int32], width: int) -> NDArray[np.bool_]:
    """Which of some pixels are of a quarter."""
    y, x = np.divmod(pixels, width)
    inside: NDArray[np.bool_] = (y % 2 == quarter[0]) & (x % 2 == quarter[1])
    return inside


def next_question(film: Film, settings: RenderSettings, done: int, witness: Quarter) -> int:
    """At how many samples a quarter is to be asked about again; `done` where the witness is good enough."""
    known = int(np.max(film.counts()[witness[0] :: 2, witness[1] :: 2]))
    needed = int(np.ceil(known * (quarter_error(film, settings, witness) / settings.target_error) ** 2))
    if needed <= done:
        return done
    if known < done:
        return needed
    # Half of what 1/√n asks for is safe to add unseen, but Sobol points' error may fall faster.
    return done + max(1, min(done, (needed - done) // 2))


def quarter_error(film: Film, settings: RenderSettings, quarter: Quarter) -> float:
    """A quarter's √relMSE, or with a percentile the relative error that so many of its pixels are below."""
    if not settings.target_percentile:
        return float(np.sqrt(quarter_relmse(film, quarter)))
    counts = film.counts()[quarter[0] :: 2, quarter[1] :: 2]
    squared = quarter_variance(film, quarter) / np.maximum(counts, 1)
    return float(np.sqrt(np.percentile(squared, settings.target_percentile)))
