"""What each effect costs and what it does to the image: renders with one effect at a time taken out.

All renders take the same samples with the same random numbers, twice with other seeds. From two pairs the
squared difference beyond noise is estimated without bias, E[(a₀ − b₀)(a₁ − b₁)] = (A − B)², and its
spread over pixels says how well. Seconds are of CPU cores. Where an effect is missing nothing is rendered:
0 s and no difference; so it is where a limit of bounces is never met.

A machine's pace drifts, so between the two renders without an effect the whole scene is timed once more:
s = t − (t₀ + t₁)/2. With each pair's relative difference d = (t₀ − t₁)/√2 over its mean, the root mean square
of all d is the relative deviation of one render's time, and that of s follows; Student's t has as many
degrees of freedom as there are pairs. What cannot be told from 0 s is put in order by the most that it may
take.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..render.film import Film
from ..render.progressive import RenderResult, render
from ..render.settings import RenderSettings
from ..render.stats import versions
from ..scene.prepare import prepare
from ..scene.scene import Scene
from ..scene.snapshot import Snapshot
from .caustics import why_no_caustics, without_caustics
from .effects import EFFECTS
from .fits import T975
from .runs import Asked, colours, never, plain

SCHEMA = "pt_engine.whatif/1"
SEEDS = 2
Float64 = NDArray[np.float64]
Told = Callable[[str], None]


@dataclass
class Version:
    """A scene rendered with each seed.

    Attributes
    ----------
    images : list of (height, width, 3) float64
    seconds : list of float
        Core seconds of each render.
    noise : float
        Their mean MSE, as their own samples tell it.
    rays : list of dict
        By kind.
    beside : float
        Core seconds that the whole scene has taken between the two.
    """

    images: list[Float64]
    seconds: list[float]
    noise: float
    rays: list[dict[str, int]]
    beside: float = 0.0

    def same_paths(self, other: Version) -> bool:
        """Whether not a ray and not a bit is another."""
        pairs = zip(self.images, other.images, strict=True)
        return self.rays == other.rays and all(np.array_equal(a, b) for a, b in pairs)


def whatif(
    snapshot: Snapshot,
    settings: RenderSettings,
    seconds: float = 4.0,
    tell: Told = lambda line: None,
    should_stop: Asked = never,
) -> dict[str, Any]:
    """Measure every effect that the scene has; what `--json` writes. Those that are done count.

    Parameters
    ----------
    seconds : float
        Core seconds that each render takes about, by the pace of the whole scene.
    tell : callable
        Gets a line before each render.
    """
    scene = prepare(snapshot, settings.film_transparent)
    settings = plain(settings)
    settings = replace(settings, samples=samples_within(scene, settings, seconds))
    rows: list[dict[str, Any]] = []
    tell("the whole scene")
    whole = rendered(scene, settings, should_stop)
    if whole is not None:
        rows += effects_of(snapshot, scene, settings, whole, tell, should_stop)
    return {
        "schema": SCHEMA,
        "settings": asdict(settings),
        "versions": versions(),
        "complete": len(rows) == len(EFFECTS) + 1,
        "seconds": float(np.mean(whole.seconds)) if whole is not None else 0.0,
        "samples": settings.samples,
        "effects": sorted(with_intervals(rows), key=worth, reverse=True),
    }


def effects_of(
    snapshot: Snapshot,
    scene: Scene,
    settings: RenderSettings,
    whole: Version,
    tell: Told,
    should_stop: Asked,
) -> Iterator[dict[str, Any]]:
    """A row of each effect, until somebody stops it."""
    beside = scene, settings
    for effect in EFFECTS:
        why = effect.missing(snapshot, scene, settings)
        if why:
            yield nothing(effect.name, why)
            continue
        tell(f"without {effect.name}")
        changed, how = effect.without(snapshot, settings)
        other = scene if changed is snapshot else prepare(changed, settings.film_transparent)
        without = rendered(other, how, should_stop, beside)
        if without is None:
            return
        if changed is snapshot and whole.same_paths(without):  # what was timed is other programs' doing
            yield nothing(effect.name, "no path is that long")
        else:
            yield difference(effect.name, whole, without)
    why = why_no_caustics(scene)
    if why:
        yield nothing("caustics", why)
        return
    tell("without caustics")
    without = rendered(without_caustics(scene), settings, should_stop, beside)
    if without is not None:
        yield difference("caustics", whole, without)


def samples_within(scene: Scene, settings: RenderSettings, seconds: float) -> int:
    """How many samples per pixel a render takes in so many core seconds, at least 4."""
    render(scene, replace(settings, samples=1))  # what only the first render makes
    started = time.process_time()
    render(scene, replace(settings, samples=2))
    each = max((time.process_time() - started) / 2, 1e-6)
    return max(4, round(seconds / each))


def rendered(
    scene: Scene,
    settings: RenderSettings,
    should_stop: Asked = never,
    beside: tuple[Scene, RenderSettings] | None = None,
) -> Version | None:
    """Both seeds, and something else's time between them; None where somebody stopped it."""
    made = Version([], [], 0.0, [])
    render(scene, replace(settings, samples=1), should_stop=should_stop)  # what only the first render makes
    for k in range(SEEDS):
        if k and beside is not None:
            made.beside, _ = timed(*beside, should_stop)
        seconds, result = timed(scene, replace(settings, seed=settings.seed + k), should_stop)
        if should_stop():
            return None
        made.seconds.append(seconds)
        made.images.append(colours(result.image()))
        made.noise += noise_of(result.film) / SEEDS
        made.rays.append(dict(result.progress.rays))
    return made


def timed(scene: Scene, settings: RenderSettings, should_stop: Asked) -> tuple[float, RenderResult]:
    """Core seconds of a render, and the render."""
    started = time.process_time()
    result = render(scene, settings, should_stop=should_stop)
    return time.process_time() - started, result


def noise_of(film: Film) -> float:
    """MSE of a film as its own samples tell it."""
    mse = film.error()["mse"]
    return mse if isinstance(mse, float) else 0.0


def difference(name: str, whole: Version, other: Version) -> dict[str, Any]:
    """What an effect does: to the image in parts of its mean, and to the time."""
    d0, d1 = (a - b for a, b in zip(whole.images, other.images, strict=True))
    mean = float(np.mean(whole.images)) or 1.0
    energy = float((d0 + d1).mean()) / 2 / mean
    squared = (d0 * d1).mean(axis=2)
    uncertain = 2 * float(squared.std()) / math.sqrt(squared.size)
    seen = float(squared.mean()) > uncertain
    rms, high = (math.sqrt(max(0.0, float(squared.mean()) + more)) / abs(mean) for more in (0.0, uncertain))
    return {
        "name": name,
        "present": True,
        "why": "",
        "seconds": other.beside - float(np.mean(other.seconds)),
        "seconds_with": other.beside,
        "seconds_without": other.seconds,
        "difference": rms,
        "difference_high": high,
        "beyond_noise": seen,
        "energy": energy,
        "noise": whole.noise / other.noise if other.noise > 0 else math.inf,
    }


def with_intervals(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows with the seconds' 95 % interval, and the difference for each second."""
    pairs = [row["seconds_without"] for row in rows if row["present"]]
    deviations = [(a - b) / math.sqrt(2) / max((a + b) / 2, 1e-9) for a, b in pairs]
    each = math.sqrt(float(np.mean(np.square(deviations)))) if pairs else 0.0
    wide = T975[min(len(pairs), len(T975)) - 1] * each
    made = []
    for row in rows:
        if row["present"]:
            half = wide * math.hypot(
                row["seconds_with"], float(np.mean(row["seconds_without"])) / math.sqrt(2)
            )
            low, high = row["seconds"] - half, row["seconds"] + half
            told = low > 0 or high < 0
            most = row["seconds"] if told else high
            row = row | {
                "seconds_ci95": (low, high),
                "seconds_known": told,
                "difference_per_second": row["difference"] / most if most > 0 else math.inf,
            }
        made.append(row)
    return made


def nothing(name: str, why: str) -> dict[str, Any]:
    """An effect that the scene does not have."""
    return {
        "name": name,
        "present": False,
        "why": why,
        "seconds": 0.0,
        "seconds_ci95": (0.0, 0.0),
        "seconds_known": True,
        "difference": 0.0,
        "difference_high": 0.0,
        "beyond_noise": True,
        "energy": 0.0,
        "noise": 1.0,
        "difference_per_second": 0.0,
    }


def worth(row: dict[str, Any]) -> tuple[bool, bool, float, float]:
    """The order: most difference for its seconds first, then what noise hides, last what is not there."""
    return row["present"], row["beyond_noise"], row["difference_per_second"], row["difference"]
