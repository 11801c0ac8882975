"""Choosing among many lights: error per sample and time per sample, by place and by power alone.

A hall of 40 × 40 m with pillars, lit by 10, 1,000 or 10,000 lamps without size, small spheres, or emissive
quads; a tenth of them give half of the light. One bounce with MIS. The error is that of one sample, relative
to its pixel: the root of the mean of variance / (mean² + 10⁻⁴ · the image's mean²). Time is CPU time of a
render on one thread, the best of some. Efficiency is 1 / (error² · time), by place over by power. The last
column is what the tables cost before the first sample.
"""

from __future__ import annotations

import time
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from pt_engine.core.memory import kept_buffers
from pt_engine.emitters import many
from pt_engine.render import integrators  # noqa: F401  (fills the registry)
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare

from . import machine
from .hall import hall
from .report import machine_text, table

COUNTS = 10, 1_000, 10_000
KINDS = "points", "spheres", "quads"
SIZE, SAMPLES, PASSES = (96, 64), 128, 3


class Row(NamedTuple):
    """What was measured of one scene and one way to choose."""

    kind: str
    count: int
    way: str  # "place" or "power"
    error: float
    nanoseconds: float  # a sample
    prepared: float  # seconds


def main() -> None:
    """Measure, and write docs/many-lights.md."""
    machine.pin()
    rows = [measured(*case) for case in product(KINDS, COUNTS, ("power", "place"))]
    (machine.ROOT / "docs" / "many-lights.md").write_text(page(rows), encoding="utf-8")


def page(rows: list[Row]) -> str:
    """Everything, a line for each kind and count."""
    by = {row[:3]: row for row in rows}
    lines = []
    for kind, count in product(KINDS, COUNTS):
        power, place = by[kind, count, "power"], by[kind, count, "place"]
        few = by[kind, COUNTS[0], "power"].nanoseconds
        gain = power.error / place.error
        lines.append(
            [
                f"{count:,} {kind}",
                f"{power.error:.2f}",
                f"{place.error:.2f}",
                f"{gain:.1f} ×",
                f"{power.nanoseconds:.0f}",
                f"{place.nanoseconds:.0f}",
                f"{place.nanoseconds / few:.2f} ×",
                f"{gain**2 * power.nanoseconds / place.nanoseconds:.1f} ×",
                f"{place.prepared - power.prepared:.1f}",
            ]
        )
    header = [
        "lights",
        "error, by power",
        "error, by place",
        "less error",
        "ns, by power",
        "ns, by place",
        f"time of {COUNTS[0]} by power",
        "efficiency",
        "s to prepare",
    ]
    text = (__doc__ or "").strip()
    made = "Made by `python -m bench.many_lights`; not edited by hand."
    described = machine_text(machine.description())
    return "\n\n".join(["# Many lights", made, described, text, table(header, lines)]) + "\n"


def measured(kind: str, count: int, way: str) -> Row:
    """Render once for the error, and some times for the time."""
    limit, many.MANY = many.MANY, (many.MANY if way == "place" else 1 << 40)
    started = time.thread_time()
    scene = prepare(hall(kind, count))
    prepared = time.thread_time() - started
    many.MANY = limit
    best = np.inf
    for k in range(PASSES):
        settings = RenderSettings(*SIZE, samples=SAMPLES, integrator="direct_mis", seed=k, threads=1)
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


if __name__ == "__main__":
    main()
