"""What each effect costs and what it does to the image: renders with one effect at a time taken out.

All renders take the same samples with the same random numbers, twice with other seeds. From two pairs the
squared difference beyond noise is estimated without bias, E[(a₀ − b₀)(a₁ − b₁)] = (A − B)², and its
spread over pixels says how well. Seconds are of CPU cores. Where an effect is missing nothing is rendered:
0 s and no difference; so it is where a limit of bounces is never met.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..render.film import Film
from ..render.progressive import render
from ..render.settings import RenderSettings
from ..render.stats import versions
from ..scene.prepare import prepare
from ..scene.scene import Scene
from ..scene.snapshot import Snapshot
from .caustics import why_no_caustics, without_caustics
from .effects import EFFECTS
from .runs import colours, plain

SCHEMA = "pt_engine.whatif/1"
SEEDS = 2
Float64 = NDArray[np.float64]
Told = Callable[[str], None]


@dataclass
class Version:
    """A scene rendered with each seed: images, core seconds of one render, the noise's MSE, rays by kind."""

    images: list[Float64]
    seconds: float
    noise: float
    rays: list[dict[str, int]]

    def same_paths(self, other: Version) -> bool:
        """Whether not a ray and not a bit is another."""
        pairs = zip(self.images, other.images, strict=True)
        return self.rays == other.rays and all(np.array_equal(a, b) for a, b in pairs)


def whatif(
    snapshot: Snapshot, settings: RenderSettings, seconds: float = 4.0, tell: Told = lambda line: None
) -> dict[str, Any]:
    """Measure every effect that the scene has; what `--json` writes.

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
    tell("the whole scene")
    whole = rendered(scene, settings)
    rows = []
    for effect in EFFECTS:
        why = effect.missing(snapshot, scene, settings)
        if why:
            rows.append(nothing(effect.name, why))
            continue
        tell(f"without {effect.name}")
        changed, how = effect.without(snapshot, settings)
        other = scene if changed is snapshot else prepare(changed, settings.film_transparent)
        without = rendered(other, how)
        if changed is snapshot and whole.same_paths(without):  # what was timed is other programs' doing
            rows.append(nothing(effect.name, "no path is that long"))
        else:
            rows.append(difference(effect.name, whole, without))
    why = why_no_caustics(scene)
    if why:
        rows.append(nothing("caustics", why))
    else:
        tell("without caustics")
        rows.append(difference("caustics", whole, rendered(without_caustics(scene), settings)))
    return {
        "schema": SCHEMA,
        "settings": asdict(settings),
        "versions": versions(),
        "seconds": whole.seconds,
        "samples": settings.samples,
        "effects": sorted(rows, key=worth, reverse=True),
    }


def samples_within(scene: Scene, settings: RenderSettings, seconds: float) -> int:
    """How many samples per pixel a render takes in so many core seconds, at least 4."""
    render(scene, replace(settings, samples=1))  # what only the first render makes
    started = time.process_time()
    render(scene, replace(settings, samples=2))
    each = max((time.process_time() - started) / 2, 1e-6)
    return max(4, round(seconds / each))


def rendered(scene: Scene, settings: RenderSettings) -> Version:
    """Both seeds."""
    images, noise, rays, started = [], [], [], time.process_time()
    for k in range(SEEDS):
        result = render(scene, replace(settings, seed=settings.seed + k))
        images.append(colours(result.image()))
        noise.append(noise_of(result.film))
        rays.append(dict(result.progress.rays))
    return Version(images, (time.process_time() - started) / SEEDS, float(np.mean(noise)), rays)


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
    seconds = whole.seconds - other.seconds
    return {
        "name": name,
        "present": True,
        "why": "",
        "seconds": seconds,
        "difference": rms,
        "difference_high": high,
        "beyond_noise": seen,
        "energy": energy,
        "noise": whole.noise / other.noise if other.noise > 0 else math.inf,
        "difference_per_second": rms / seconds if seconds > 0 else math.inf,
    }


def nothing(name: str, why: str) -> dict[str, Any]:
    """An effect that the scene does not have."""
    return {
        "name": name,
        "present": False,
        "why": why,
        "seconds": 0.0,
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
