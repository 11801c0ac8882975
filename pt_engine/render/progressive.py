"""Progressive rendering: units on threads, their samples into the film, until enough or told to stop.

The calling thread feeds the pool, keeps the film and reports; numpy and Embree release the GIL in the
workers. A stop is answered as soon as the units in flight are done, each a fraction of a second.
"""

from __future__ import annotations

import json
import os
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.memory import kept_buffers
from ..core.samplers import SAMPLERS
from ..scene.prepare import finish
from ..scene.scene import Scene
from .catcher_film import CatcherFilm
from .film import Film
from .integrator import INTEGRATORS, Integrator
from .provenance import only_positive, origins
from .schedule import Unit, morton_order, units
from .settings import RenderSettings
from .worker import UnitResult, Worker

Float32 = NDArray[np.float32]
REPORTED_NONFINITE = 20


@dataclass
class Progress:
    """How far a render is. `image()` is computed on demand; it is the film's current mean."""

    film: Film
    settings: RenderSettings
    started: float
    samples: int = 0
    camera_samples: int = 0
    rays: Counter[str] = field(default_factory=Counter)
    nonfinite: list[dict[str, Any]] = field(default_factory=list)
    nonfinite_count: int = 0
    stopped: bool = False
    caught: CatcherFilm | None = None  # where there are shadow catchers

    @property
    def total_samples(self) -> int:
        """Samples per pixel asked for; 0 if unlimited."""
        return self.settings.samples

    @property
    def elapsed(self) -> float:
        """Seconds since the first unit was started."""
        return time.perf_counter() - self.started

    @property
    def fraction(self) -> float:
        """Part that is done, by samples or by time, whichever is further; 0 where there is no limit."""
        parts = [0.0]
        if self.settings.samples:
            x0, y0, x1, y1 = self.settings.window
            parts.append(self.camera_samples / (self.settings.samples * (x1 - x0) * (y1 - y0)))
        if self.settings.seconds:
            parts.append(self.elapsed / self.settings.seconds)
        return min(1.0, max(parts))

    @property
    def remaining(self) -> float:
        """Seconds to go at the pace so far; infinite before there is one."""
        done = self.fraction
        return self.elapsed * (1 - done) / done if done > 0 else float("inf")

    @property
    def rays_per_second(self) -> float:
        """Of all kinds."""
        return sum(self.rays.values()) / max(self.elapsed, 1e-9)

    def image(self) -> Float32:
        """(height, width, 4) float32 of the window, bottom row first, alpha premultiplied."""
        return self.film.image() if self.caught is None else self.caught.image()


@dataclass
class RenderResult:
    """What a render leaves, complete or cancelled."""

    film: Film
    progress: Progress
    seconds: float
    cancelled: bool

    def image(self) -> Float32:
        """(height, width, 4) float32 of the window, bottom row first, alpha premultiplied."""
        return self.progress.image()


def render(
    scene: Scene,
    settings: RenderSettings,
    on_progress: Callable[[Progress], None] = lambda progress: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> RenderResult:
    """Render until the samples, the time or the caller's patience are used up.

    Parameters
    ----------
    scene : Scene
    settings : RenderSettings
    on_progress : callable
        Called in this thread after every unit of work.
    should_stop : callable
        Asked in this thread after every unit; what was rendered until then is kept.

    Raises
    ------
    KeyError
        The integrator or the sampler named in `settings` is not registered.
    """
    x0, y0, x1, y1 = settings.window
    integrator = INTEGRATORS[settings.integrator](settings)
    positive = only_positive(scene, integrator)
    worker = ready_worker(scene, settings, integrator)
    groups = worker.groups(morton_order(x1 - x0, y1 - y0))
    order = np.concatenate(groups)
    film = Film(x1 - x0, y1 - y0, key=film_key(settings), order=order, reject_negative=positive)
    progress = Progress(film, settings, time.perf_counter())
    progress.caught = CatcherFilm(film, order) if scene.has_catchers else None
    threads = settings.threads or os.cpu_count() or 1
    with kept_buffers():
        work = units(settings, *groups, aligned=worker.run)
        for result in in_parallel(worker, work, threads, lambda: progress.stopped or out_of_time(progress)):
            deposit(progress, result)
            on_progress(progress)
            progress.stopped = progress.stopped or should_stop()
        seconds = progress.elapsed
        progress.nonfinite = origins(scene, settings, progress.nonfinite, positive)
    return RenderResult(film, progress, seconds, progress.stopped)


def ready_worker(scene: Scene, settings: RenderSettings, integrator: Integrator) -> Worker:
    """A worker whose tables are made; their time counts as the scene's build."""
    started = time.perf_counter()
    worker = Worker(scene, settings, integrator, SAMPLERS[settings.sampler](settings.seed))
    finish(worker.scene)
    scene.build_seconds += time.perf_counter() - started
    return worker


def film_key(settings: RenderSettings) -> str:
    """What two films must have in common to be parts of one render."""
    parts = asdict(settings)
    for name in ("samples", "first_sample", "seconds", "threads", "lanes"):
        del parts[name]
    return json.dumps(parts, sort_keys=True)


def out_of_time(progress: Progress) -> bool:
    """Whether the time limit is reached."""
    limit = progress.settings.seconds
    return limit > 0 and progress.elapsed >= limit


def in_parallel(
    worker: Worker, work: Iterator[Unit], threads: int, stop: Callable[[], bool]
) -> Iterator[UnitResult]:
    """Results in the order of the work, one unit per thread in flight; none is started after `stop`."""
    if threads == 1:
        for only in work:
            yield worker.render(only)
            if stop():
                return
        return
    with ThreadPoolExecutor(threads, thread_name_prefix="pt_engine") as pool:
        pending: deque[Future[UnitResult]] = deque()
        more, started = True, False
        while more or pending:
            while more and len(pending) <= threads:
                unit = None if started and stop() else next(work, None)
                more = started = unit is not None
                if unit is not None:
                    pending.append(pool.submit(worker.render, unit))
            if pending:
                yield pending.popleft().result()


def deposit(progress: Progress, result: UnitResult) -> None:
    """Add a unit's samples to the film; those that can't be are dropped there and remembered here."""
    unit = result.unit
    bad = progress.film.add(unit.pixels, unit.first, unit.spp, result.radiance, result.alpha)
    if progress.caught is not None and result.caught is not None:
        progress.caught.add(unit.pixels, unit.first, unit.spp, result.caught)
    for slot in bad[: max(0, REPORTED_NONFINITE - len(progress.nonfinite))]:
        sample, index = divmod(int(slot), len(unit.pixels))
        x0, y0, x1, _ = progress.settings.window
        y, x = divmod(int(unit.pixels[index]), x1 - x0)
        progress.nonfinite.append({"x": x + x0, "y": y + y0, "sample": unit.first + sample})
    progress.nonfinite_count += len(bad)
    progress.camera_samples += len(unit.pixels) * unit.spp
    progress.rays.update(result.rays)
    progress.samples = progress.camera_samples // max(1, progress.film.pixels)
