"""Choosing among many lights: error per sample and time per sample, by place and by power alone.

A hall of 40 × 40 m with pillars, lit by 10, 1,000 or 10,000 lamps without size, small spheres, or emissive
quads; a tenth of them give half of the light. One bounce with MIS. The error is that of one sample, relative
to its pixel: the root of the mean of variance / (mean² + 10⁻⁴ · the image's mean²). Time is CPU time of a
render on one thread, the best of some.
"""

from __future__ import annotations

import time
from typing import Any, NamedTuple

import numpy as np

from pt_engine.core.memory import kept_buffers
from pt_engine.emitters import many
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare

from .hall import hall

COUNTS = 10, 1_000, 10_000
KINDS = "points", "spheres", "quads"
SIZE, SAMPLES, PASSES = (96, 64), 64, 3


class Row(NamedTuple):
    """What was measured of one scene and one way to choose."""

    kind: str
    count: int
    way: str
    error: float
    nanoseconds: float
    prepared: float


def many_lights() -> dict[str, Any]:
    """Rows by kind, count and way."""
    rows = []
    for kind in KINDS:
        for count in COUNTS:
            for way in ("place", "power"):
                rows.append(measured(kind, count, way)._asdict())
                print(rows[-1], flush=True)
    return {"rows": rows}


def measured(kind: str, count: int, way: str, **more: Any) -> Row:
    """Render once for the error, and some times for the time."""
    limit, many.MANY = many.MANY, (many.MANY if way == "place" else 1 << 40)
    started = time.thread_time()
    scene = prepare(hall(kind, count))
    prepared = time.thread_time() - started
    many.MANY = limit
    best = np.inf
    for k in range(PASSES):
        settings = RenderSettings(*SIZE, samples=SAMPLES, integrator="direct_mis", seed=k, threads=1, **more)
        with kept_buffers():
            started = time.process_time()
            result = render(scene, settings)
            best = min(best, time.process_time() - started)
    samples = SIZE[0] * SIZE[1] * SAMPLES
    return Row(kind, count, way, error(result), best / samples * 1e9, prepared)


def error(result: Any) -> float:
    """Relative standard deviation of one sample."""
    mean = result.film.image()[..., :3].astype(np.float64).mean(axis=2).ravel()
    variance = result.film.variance_of_mean().reshape(-1, 3).mean(axis=1) * SAMPLES
    return float(np.sqrt(np.mean(variance / (mean**2 + 1e-4 * np.mean(mean) ** 2))))
