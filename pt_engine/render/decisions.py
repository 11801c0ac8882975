"""When a render is good enough, and which pixels still need samples.

The target error: pixels are dealt to two random halves, and each is finished when the *other* is good enough.
Pixels are independent, so a half that was lucky has only stopped the other: neither the image nor what its
samples tell of its error knows of the luck. (Not even the image's mean, to which errors are relative, may
tell one half of the other.) Where one half is finished, the other goes on to as many samples
as the finished one says: n (E/target)², with E its error at n samples.

Adaptive sampling: see `adaptive`. A pixel's own samples take no part in the decision about it.

Decisions are made at numbers of samples that follow from the film alone, when all samples before are in it:
they do not depend on threads or tiles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from .adaptive import looks, wanted_samples
from .film import Film
from .film_noise import drawn_half, relative_variance
from .schedule import Decide, Step
from .settings import RenderSettings

LEAST = 4  # samples before anything can be decided
GROWTH = 0.25  # of the samples, between two moments when pixels may end
STEP = 8  # samples, at least, between two such moments


def relative_error(film: Film, percentile: float = 0.0, half: int | None = None) -> float | None:
    """The image's √relMSE, or with a percentile the relative error that so many pixels are below.

    `half` as in `Film.error`. None below two samples.
    """
    if percentile:
        errors = relative_variance(film, half).reshape(-1)
        errors = errors[np.isfinite(errors) & ((half is None) | (drawn_half(0, errors.size) == half))]
        return float(np.sqrt(np.percentile(errors, percentile))) if errors.size else None
    relmse = film.error(half)["relmse"]
    return float(np.sqrt(relmse)) if isinstance(relmse, float) else None


def decisions(film: Film, settings: RenderSettings, order: NDArray[np.int32]) -> Decide | None:
    """What `schedule.units` asks; None where nothing depends on the film."""
    if not settings.target_error and not settings.adaptive:
        return None
    least = max(LEAST, settings.min_samples)
    active, last = order, 0  # `last`: the samples at which the second half is finished
    coming = looks(settings, least)
    look, wanted = float(next(coming)), np.zeros(0)

    @stage("accuracy")
    def decide(done: int) -> Step:
        nonlocal active, last, look, wanted
        if done < least:
            return Step(least - done, active)
        more = settings.samples or STEP
        if settings.target_error and last:
            more = last - done
        elif settings.target_error:
            needed = [samples_for_target(film, settings, done, witness=half) for half in (1, 0)]
            if min(needed) <= done:
                last = max(needed)
                active = active[drawn(active) == needed.index(last)]
            # Half of what 1/√n asks for is safe to add unseen, but Sobol points' error may fall faster.
            more = last - done if last else max(1, min(done, (min(needed) - done) // 2))
        if settings.adaptive and more > 0:
            if done >= look:
                wanted = wanted_samples(film, settings)
                look = next((float(n) for n in coming if n > done), np.inf)
            active = active[wanted[active] > done]
            more = int(min(more, max(STEP, int(done * GROWTH)), look - done))
        return Step(max(0, more), active)

    return decide


def drawn(pixels: NDArray[np.int32]) -> NDArray[np.uint32]:
    """Which random half each of some pixels is of."""
    return drawn_half(0, int(np.max(pixels, initial=-1)) + 1)[pixels]


def samples_for_target(film: Film, settings: RenderSettings, done: int, witness: int) -> int:
    """At how many samples the pixels of the half `witness` say that the target is reached; at least 1."""
    error = relative_error(film, settings.target_percentile, witness)
    if error is None:
        return done + STEP
    return max(1, int(np.ceil(done * (error / settings.target_error) ** 2)))
