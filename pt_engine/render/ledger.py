"""The ledger: what a render's time went to, by stage, bounce, effect and material.

Each thread runs a `core.clock.Clock`; its books are closed when the render ends. Seconds are those of CPU
cores, summed over threads. With what threads have waited (for work, for each other, for a core that another
program had) they add up to threads × wall time. The stages are told apart in a twelfth of the units, and
stand for the others too, thread by thread, as do the shares that a batch's materials have in its vertices;
rays and the vertices of each batch are counted in all.
"""

from __future__ import annotations

import threading
import time
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from ..core import clock
from ..core.clock import IN_UNIT, UNTIMED, Cell, Clock
from ..scene.features import ON
from ..scene.scene import Scene

STAGES = {
    "generate": "camera rays",
    "intersect": "closest hits (Embree)",
    "surface": "hit points",
    "emission": "emission that rays find",
    "shade": "materials' programs",
    "random": "random numbers",
    "emitter": "light sampling",
    "shadow": "shadow rays (Embree)",
    "eval": "BSDFs toward lights",
    "bsdf": "BSDF sampling",
    "roulette": "roulette and sorting",
    "film": "film",
    "accuracy": "looking at the error",
    "rest": "everything else",
}
OF_PATHS = frozenset(STAGES) - {"generate", "film", "accuracy", "rest"}
OF_UNITS = OF_PATHS | {"generate", IN_UNIT}
TIMED_PART = 1 / 12  # of the units: what clocks of stages cost is paid there alone (docs/numbers.md)


class Ledger:
    """Books of one render.

    Attributes
    ----------
    wall : float
        Seconds from the first unit to the last.
    threads : int
        That rendered.
    """

    def __init__(self) -> None:
        self.wall, self.threads = 0.0, 1
        self._clocks: list[Clock] = []
        self._lock = threading.Lock()

    def open_on_thread(self) -> None:
        """Run a clock on this thread until it ends."""
        clock.start(self._new_clock())

    @contextmanager
    def running(self, threads: int = 1) -> Iterator[None]:
        """Run a clock on this thread inside, which lasts as long as the render by so many threads."""
        self.threads, started = threads, time.perf_counter()
        with clock.runs(self._new_clock()):
            yield
        self.wall += time.perf_counter() - started

    def _new_clock(self) -> Clock:
        made = Clock(part=TIMED_PART)
        with self._lock:
            self._clocks.append(made)
        return made

    def cells(self) -> dict[Cell, float]:
        """Seconds of all threads."""
        total: dict[Cell, float] = defaultdict(float)
        for each in self._clocks:
            for cell, seconds in whole(each.seconds, each.first).items():
                total[cell._replace(stage="rest") if cell.stage == IN_UNIT else cell] += seconds
        return dict(total)

    def books(self, scene: Scene) -> dict[str, Any]:
        """What `docs/stats.md` says of `ledger`, ready for JSON."""
        cells = self.cells()
        busy = sum(cells.values())
        return {
            "threads": self.threads,
            "wall": self.wall,
            "waiting": max(0.0, self.threads * self.wall - busy),
            "stages": self._stages(cells),
            "bounces": self._bounces(cells),
            "effects": _sums((cell.effect, seconds) for cell, seconds in cells.items() if cell.effect),
            "materials": self._materials(scene, cells),
            "off": {name: why.removeprefix("off: ") for name, why in scene.features.items() if why != ON},
        }

    def rays(self) -> dict[tuple[str, int], int]:
        """Rays by stage and bounce, of all threads."""
        total: dict[tuple[str, int], int] = defaultdict(int)
        for each in self._clocks:
            for key, number in each.rays.items():
                total[key] += number
        return dict(total)

    def _stages(self, cells: Mapping[Cell, float]) -> dict[str, dict[str, float]]:
        seconds = _sums((cell.stage, part) for cell, part in cells.items())
        rays: dict[str, int] = defaultdict(int)
        for (stage, _), number in self.rays().items():
            rays[stage] += number
        return {name: {"seconds": part, "rays": rays.get(name, 0)} for name, part in seconds.items()}

    def _bounces(self, cells: Mapping[Cell, float]) -> list[dict[str, float]]:
        """What each generation of edges took, the camera rays' first."""
        seconds: dict[int, float] = defaultdict(float)
        rays: dict[int, int] = defaultdict(int)
        for cell, part in cells.items():
            if cell.stage in OF_PATHS:
                seconds[cell.bounce] += part
        for (_, bounce), number in self.rays().items():
            rays[bounce] += number
        return [{"seconds": seconds[k], "rays": rays.get(k, 0)} for k in range(max(seconds, default=-1) + 1)]

    def _materials(self, scene: Scene, cells: Mapping[Cell, float]) -> dict[str, dict[str, float]]:
        """Seconds and vertices of a batch go to its materials by the vertices that each was seen to have."""
        seen: dict[int, int] = defaultdict(int)
        shaded: dict[int, int] = defaultdict(int)
        for each in self._clocks:
            for material, number in each.vertices.items():
                seen[material] += number
            for batch, number in each.shaded.items():
                shaded[batch] += number
        together: dict[int, int] = defaultdict(int)
        for material, number in seen.items():
            together[int(scene.materials.batch_of[material])] += number
        seconds = _sums((str(cell.batch), part) for cell, part in cells.items() if cell.batch >= 0)
        found: dict[str, dict[str, float]] = defaultdict(lambda: {"seconds": 0.0, "vertices": 0})
        for material, number in seen.items():
            row, batch = found[scene.material_names[material]], int(scene.materials.batch_of[material])
            row["seconds"] += seconds.get(str(batch), 0.0) * number / together[batch]
            row["vertices"] += round(shaded[batch] * number / together[batch])
        return dict(sorted(found.items(), key=lambda item: -item[1]["seconds"]))


def whole(seconds: Mapping[Cell, float], first: Mapping[Cell, float]) -> dict[Cell, float]:
    """The cells of a thread, among which the time of units that nobody looked into is shared out.

    Those are like the units after the `first`, if any of these was looked into.
    """
    later = {cell: part - first.get(cell, 0.0) for cell, part in seconds.items()}
    known = later if seconds_of(later, OF_UNITS) > 0 else seconds
    timed, untimed = seconds_of(known, OF_UNITS), seconds_of(seconds, {UNTIMED})
    more = untimed / timed if timed > 0 else 0.0
    return {
        cell: part + (known[cell] * more if cell.stage in OF_UNITS else 0.0)
        for cell, part in seconds.items()
        if cell.stage != UNTIMED
    }


def seconds_of(seconds: Mapping[Cell, float], stages: Collection[str]) -> float:
    """Sum over the cells of some stages."""
    return sum(part for cell, part in seconds.items() if cell.stage in stages)


def _sums(parts: Iterator[tuple[str, float]] | Any) -> dict[str, float]:
    """Sums by name, the largest first."""
    total: dict[str, float] = defaultdict(float)
    for name, seconds in parts:
        total[name] += seconds
    return dict(sorted(total.items(), key=lambda item: -item[1]))
