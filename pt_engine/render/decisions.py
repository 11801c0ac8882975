"""When a render is good enough, and which pixels still need samples.

The target error: pixels are dealt to two random halves. One decides, the other tells the error of the
finished image. Pixels are independent, so a half that was lucky enough to stop early says nothing about the
other: what is reported has no optimism from having stopped there.

Adaptive sampling: the samples that minimise relMSE for their sum are in proportion to √(w σ²), a pixel's
noise per sample relative to its level (a Lagrange multiplier makes the gains w σ²/n² equal). A pixel's own
samples take no part in the decision about it, only those of the pixels around: so its mean stays unbiased.

Decisions are made at numbers of samples that follow from the film alone, when all samples before are in it:
they do not depend on threads or tiles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from .film import Film
from .film_noise import around, drawn_half, relative_variance
from .schedule import LARGEST_PASS, Decide, Step
from .settings import RenderSettings

Float64 = NDArray[np.float64]
DECIDES, TELLS = 0, 1  # the halves of the pixels
LEAST = 4  # samples before anything can be decided
REACH = 2  # pixels to each side that decide about one
GROWTH = 0.25  # of the samples, between two decisions about pixels


def relative_error(film: Film, percentile: float = 0.0, half: int | None = None) -> float | None:
    """The image's √relMSE, or with a percentile the relative error that so many pixels are below.

    `half` as in `Film.error`. None below two samples.
    """
    if percentile:
        errors = relative_variance(film).reshape(-1)
        errors = errors[np.isfinite(errors) & ((half is None) | (drawn_half(0, errors.size) == half))]
        return float(np.sqrt(np.percentile(errors, percentile))) if errors.size else None
    relmse = film.error(half)["relmse"]
    return float(np.sqrt(relmse)) if isinstance(relmse, float) else None


def decisions(film: Film, settings: RenderSettings, order: NDArray[np.int32]) -> Decide | None:
    """What `schedule.units` asks; None where nothing depends on the film."""
    if not settings.target_error and not settings.adaptive:
        return None
    least = max(LEAST, settings.min_samples)
    active = order

    @stage("accuracy")
    def decide(done: int) -> Step:
        nonlocal active
        if done < least:
            return Step(least - done, active)
        more = settings.samples or LARGEST_PASS
        if settings.target_error:
            more = samples_to_add(film, settings, done)
        if settings.adaptive and more:
            active = active[wanted_samples(film, settings)[active] > done]
            more = min(more, max(LARGEST_PASS, int(done * GROWTH)))
        return Step(more, active)

    return decide


def samples_to_add(film: Film, settings: RenderSettings, done: int) -> int:
    """Samples until the target error is to be looked at again; 0 when it is reached.

    The error falls at least as 1/√n, so half of what that asks for is safe to add unseen.
    """
    error = relative_error(film, settings.target_percentile, DECIDES)
    if error is None:
        return LARGEST_PASS
    if error <= settings.target_error:
        return 0
    return max(1, int(0.5 * done * ((error / settings.target_error) ** 2 - 1)))


def wanted_samples(film: Film, settings: RenderSettings) -> Float64:
    """How many each pixel should get, as the pixels around it tell: (pixels,).

    With a target E for the image, n = s · mean(s) / E² with s² = w v n, which makes mean(s²/n) = E². For
    a percentile of pixels, n = s²/E², so that each has error E. Without a target the noisiest per cent of
    pixels get `samples`, others in proportion to s.
    """
    squared = np.nan_to_num(relative_variance(film) * film.counts())
    others = np.maximum(around(squared, REACH) - squared, 0.0)
    noise = np.sqrt(others / np.maximum(around(np.ones_like(squared), REACH) - 1, 1)).reshape(-1)
    if settings.target_error and settings.target_percentile:
        wanted: Float64 = noise**2 / settings.target_error**2
    elif settings.target_error:
        wanted = noise * (noise.mean() / settings.target_error**2)
    else:
        wanted = noise * (settings.samples / max(float(np.percentile(noise, 99)), np.finfo(float).tiny))
    return wanted
