"""What each stage of a pass costs, in nanoseconds per path vertex (a hit that is shaded).

`intersect` and `shadow` are Embree alone; `surface` is the rest of the hit. `embree` replays the very
rays of the pass through Embree with nothing in between.
"""

from __future__ import annotations

import json
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from pt_engine.core.clock import IN_UNIT, Clock, runs
from pt_engine.core.samplers import SAMPLERS
from pt_engine.render import integrators  # noqa: F401  fills the registry
from pt_engine.render.film import Film
from pt_engine.render.integrator import INTEGRATORS
from pt_engine.render.ledger import STAGES
from pt_engine.render.schedule import LARGEST_PASS, morton_order, unit_lanes, units
from pt_engine.render.settings import RenderSettings
from pt_engine.render.worker import Worker
from pt_engine.scene.accel import Accel
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot_io import load_snapshot

from .ledger_cost import ledger_costs
from .shapes import FRAMES, RR_DEPTH
from .wrapping import wrapped


class Pass:
    """A scene ready for repeated passes over its image, of as many samples per pixel as passes have."""

    def __init__(self, blend: Path, sampler: str, lanes: int = RenderSettings.lanes) -> None:
        frame = FRAMES[blend.stem]
        self.settings = RenderSettings(
            frame.width,
            frame.height,
            max_depth=frame.max_depth,
            rr_depth=RR_DEPTH,
            sampler=sampler,
            pixel_filter="BOX",
            lanes=lanes,
            threads=1,
        )
        self.scene = prepare(load_snapshot(blend.with_suffix(".snapshot")))
        integrator = INTEGRATORS["path"](self.settings)
        self.worker = Worker(self.scene, self.settings, integrator, SAMPLERS[sampler](0))
        self.film = Film(frame.width, frame.height)
        order = morton_order(frame.width, frame.height)
        asked = replace(
            self.settings, samples=3 * LARGEST_PASS, lanes=unit_lanes(self.settings, integrator.waves)
        )
        steady = (unit for unit in units(asked, order))
        self.units = [unit for unit in steady if LARGEST_PASS <= unit.first < 2 * LARGEST_PASS]

    def render(self) -> int:
        """All of the image once, film included; the number of camera rays."""
        for unit in self.units:
            result = self.worker.render(unit)
            self.film.add(unit.pixels, unit.first, unit.spp, result.radiance, result.alpha)
        return sum(len(unit.pixels) * unit.spp for unit in self.units)


def stages(blend: Path, sampler: str = "independent", passes: int = 6, books: bool = True) -> dict[str, Any]:
    """Nanoseconds per vertex by stage, samples per CPU second, and Embree's share by replay.

    With `books` what keeping the ledger costs, too, which takes as long as all else.
    """
    work = Pass(blend, sampler)
    untimed_pass(work)
    best, samples = min((timed_pass(work) for _ in range(passes)), key=lambda timed: total(timed[0]))
    vertices, seconds = sum(best.shaded.values()), Counter[str]()
    for cell, part in best.seconds.items():
        seconds["rest" if cell.stage == IN_UNIT else cell.stage] += part
    plain = min(untimed_pass(work) for _ in range(passes))
    embree, rays = min((embree_pass(work) for _ in range(max(2, passes // 2))), key=lambda pair: pair[0])
    return {
        "sampler": sampler,
        "ns_per_vertex": {stage: 1e9 * seconds[stage] / vertices for stage in STAGES},
        "ns_per_vertex_total": 1e9 * total(best) / vertices,
        "vertices_per_sample": vertices / samples,
        "rays_per_sample": rays,
        "samples_per_cpu_second": 1 / plain,
        **({"ledger_costs": ledger_costs(work.worker, work.units)} if books else {}),
        "embree_only_samples_per_cpu_second": 1 / embree,
        "embree_share": embree / plain,
    }


def total(clock: Clock) -> float:
    """Seconds of all stages."""
    return sum(clock.seconds.values())


def timed_pass(work: Pass) -> tuple[Clock, int]:
    """One pass with every stage timed, and the number of its camera rays."""
    with runs(Clock()) as clock:
        samples = work.render()
    return clock, samples


def untimed_pass(work: Pass) -> float:
    """CPU seconds per camera sample of a pass without any timers."""
    started = time.thread_time()
    samples = work.render()
    return (time.thread_time() - started) / samples


def embree_pass(work: Pass) -> tuple[float, dict[str, float]]:
    """CPU seconds per camera sample of a pass's own rays through Embree, and rays per sample by kind."""
    recorded: list[tuple[bool, Any, Any, Any]] = []

    def recording(shadow: bool, query: Callable[..., Any]) -> Callable[..., Any]:
        def wrapper(accel: Accel, o: Any, d: Any, tfar: Any) -> Any:
            recorded.append((shadow, o.copy(), d.copy(), tfar.copy()))
            return query(accel, o, d, tfar)

        return wrapper

    queries = ((Accel, "intersect", False), (Accel, "visible", True))
    with wrapped([(owner, name, partial(recording, shadow)) for owner, name, shadow in queries]):
        samples = work.render()
    counts = {"closest": 0.0, "shadow": 0.0}
    for shadow, _, _, tfar in recorded:
        counts["shadow" if shadow else "closest"] += float(np.count_nonzero(tfar > 0)) / samples
    accel = work.scene.accel
    started = time.thread_time()
    for shadow, o, d, tfar in recorded:
        (accel.visible if shadow else accel.intersect)(o, d, tfar)
    return (time.thread_time() - started) / samples, counts


if __name__ == "__main__":
    print(json.dumps(stages(Path(sys.argv[1]), books=False)))
