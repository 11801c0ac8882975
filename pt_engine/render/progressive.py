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
from contextlib import nullcontext
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.memory import kept_buffers
from ..core.samplers import SAMPLERS
from ..scene.prepare import finish
from ..scene.scene import Scene
from .catcher_film import CatcherFilm
from .decisions import decisions
from .film import Film
from .film_error import ErrorEstimate
from .forecast import Forecast
from .group_films import GroupFilms
from .integrator import INTEGRATORS, Integrator
from .ledger import Ledger
from .provenance import only_positive, origins
from .schedule import WAIT, Unit, morton_order, unit_lanes, units
from .settings import RenderSettings
from .worker import UnitResult, Worker

Float32 = NDArray[np.float32]
REPORTED_NONFINITE = 20
LEAST_LANES = 1 << 12  # of a unit where time is short: fewer take as long
FORGET, FIRST = 0.8, 2  # what counts of the pace from unit to unit; units in which tables are made: none
TIME_PART, LAST_PART = 0.25, 0.01  # of the time that is left, and of the limit, for a unit
# settings that say how many samples there are and who makes them, not what they are
HOW_MANY = ("samples", "first_sample", "seconds", "threads", "lanes") + (
    "target_error",
    "target_percentile",
    "min_samples",
    "adaptive",
)


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
    late: bool = False  # out of time
    caught: CatcherFilm | None = None  # where there are shadow catchers
    groups: GroupFilms | None = None  # where there are light groups
    in_flight: float = 1.0  # units that are rendered or wait, for each thread
    units: int = 0  # that are done
    unit_seconds: float = 0.0  # of the last one
    lately: tuple[float, float] = (0.0, 0.0)  # lanes and a thread's seconds, of the last units above all
    forecast: Forecast = field(default_factory=Forecast)

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
        if self.settings.target_error and self.forecast.latest:
            parts.append(self.elapsed / max(self.forecast.latest.seconds, self.elapsed))
        return min(1.0, max(parts))

    @property
    def pace(self) -> float:
        """Camera samples per second of one thread, lately."""
        lanes, seconds = self.lately
        return lanes / max(seconds, 1e-9)

    @property
    def latency(self) -> float:
        """Seconds until the end of a unit that is started now: others are before it."""
        return self.in_flight * self.unit_seconds

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
    """What a render leaves, complete or cancelled.

    `stopped_by` is "samples", "time", "target", "noise" (adaptive sampling wants no more) or "cancelled".
    """

    film: Film
    progress: Progress
    seconds: float
    stopped_by: str

    @property
    def cancelled(self) -> bool:
        """Whether somebody stopped it."""
        return self.stopped_by == "cancelled"

    def error(self) -> ErrorEstimate:
        """How wrong the image is."""
        return self.film.error()

    def image(self) -> Float32:
        """(height, width, 4) float32 of the window, bottom row first, alpha premultiplied."""
        return self.progress.image()

    def light_group(self, name: str) -> Float32:
        """(height, width, 3) float32 of the window, bottom row first: what the lights of a group send."""
        assert self.progress.groups is not None
        return self.progress.groups.image(name)


def render(
    scene: Scene,
    settings: RenderSettings,
    on_progress: Callable[[Progress], None] = lambda progress: None,
    should_stop: Callable[[], bool] = lambda: False,
    ledger: Ledger | None = None,
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
    ledger : Ledger, optional
        Keeps the books of the time.

    Raises
    ------
    KeyError
        The integrator or the sampler named in `settings` is not registered.
    """
    x0, y0, x1, y1 = settings.window
    integrator = INTEGRATORS[settings.integrator](settings)
    positive = only_positive(scene, integrator)
    worker = ready_worker(scene, settings, integrator)
    order = np.concatenate(worker.groups(morton_order(x1 - x0, y1 - y0)))
    film = Film(
        *(x1 - x0, y1 - y0),
        key=film_key(settings),
        order=order,
        reject_negative=positive,
        correlated=SAMPLERS[settings.sampler].correlated or worker.run > 1,  # samples that share a moment
        halves=settings.half_buffers,
    )
    progress = Progress(film, settings, time.perf_counter())
    progress.caught = CatcherFilm(film, order) if scene.has_catchers else None
    progress.groups = GroupFilms(film, order, scene.light_groups) if scene.light_groups else None
    threads = settings.threads or os.cpu_count() or 1
    progress.in_flight = (threads + 1) / threads if threads > 1 else 1.0
    with kept_buffers():
        asked = units(
            replace(settings, lanes=unit_lanes(settings, integrator.waves)),
            order,
            decisions(film, settings, order),
            split=worker.groups,
            aligned=worker.run,
            in_time=lambda: lanes_in_time(progress),
        )
        work = in_parallel(worker, asked, threads, lambda: is_over(progress), ledger)
        with ledger.running(threads) if ledger else nullcontext():
            for result in work:
                deposit(progress, result)
                progress.forecast.look(progress)
                on_progress(progress)
                progress.stopped = progress.stopped or should_stop()
        seconds = progress.elapsed
        progress.nonfinite = origins(scene, settings, progress.nonfinite, positive)
    return RenderResult(film, progress, seconds, stopped_by(progress))


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
    for name in HOW_MANY:
        del parts[name]
    return json.dumps(parts, sort_keys=True)


def is_over(progress: Progress) -> bool:
    """Whether it was stopped or has used up its time; then it stays over, though the last units be faster."""
    progress.late = progress.late or out_of_time(progress)
    return progress.stopped or progress.late


def stopped_by(progress: Progress) -> str:
    """Why a render is over."""
    settings = progress.settings
    if progress.stopped:
        return "cancelled"
    if settings.samples and progress.camera_samples >= settings.samples * progress.film.pixels:
        return "samples"
    if progress.late or out_of_time(progress):
        return "time"
    if settings.target_error and int(np.max(progress.film.counts())) != settings.samples:
        return "target"
    return "noise" if settings.adaptive else "samples"


def out_of_time(progress: Progress) -> bool:
    """Whether a unit that is started now would end rather after the time limit than before it.

    Those in flight end first: it is as late as the ones before it were.
    """
    limit = progress.settings.seconds
    to_come = 0.5 * progress.latency if progress.units > FIRST else 0.0
    return limit > 0 and progress.elapsed + to_come >= limit


def lanes_in_time(progress: Progress) -> float:
    """How many lanes a unit may have for the time limit to be kept: fewer and fewer toward its end.

    The first sample of all pixels is not cut up: small units take longer, and a picture with holes is none.
    """
    limit = progress.settings.seconds
    if not limit or not progress.samples:
        return float("inf")
    return max(LEAST_LANES, progress.pace * max(LAST_PART * limit, TIME_PART * (limit - progress.elapsed)))


def in_parallel(
    worker: Worker,
    work: Iterator[Unit | None],
    threads: int,
    stop: Callable[[], bool],
    ledger: Ledger | None = None,
) -> Iterator[UnitResult]:
    """Results in the order of the work, one unit per thread in flight; none is started after `stop`.

    Where the work says WAIT, all results before are handed over before it is asked for more.
    """
    if threads == 1:
        for only in work:
            if only is not WAIT:
                yield timed(worker, only)
                if stop():
                    return
        return
    opened = ledger.open_on_thread if ledger else None
    with ThreadPoolExecutor(threads, "pt_engine", opened) as pool:
        pending: deque[Future[UnitResult]] = deque()
        more, started, wait = True, False, False
        while more or pending:
            while more and not (wait and pending) and len(pending) <= threads:
                if started and stop():
                    more = False
                    break
                try:
                    unit = next(work)
                except StopIteration:
                    more = False
                    break
                wait = unit is WAIT
                if unit is not WAIT:
                    pending.append(pool.submit(timed, worker, unit))
                    started = True
            if pending:
                yield pending.popleft().result()


def timed(worker: Worker, unit: Unit) -> UnitResult:
    """A unit's result, and how long it took."""
    started = time.perf_counter()
    return worker.render(unit)._replace(seconds=time.perf_counter() - started)


def deposit(progress: Progress, result: UnitResult) -> None:
    """Add a unit's samples to the film; those that can't be are dropped there and remembered here."""
    unit = result.unit
    bad = progress.film.add(unit.pixels, unit.first, unit.spp, result.radiance, result.alpha)
    if progress.caught is not None and result.caught is not None:
        more = progress.caught.add(unit.pixels, unit.first, unit.spp, result.caught)
        bad = np.union1d(bad, more)
    if progress.groups is not None and result.by_group is not None:
        progress.groups.add(unit.pixels, unit.first, unit.spp, result.by_group, bad)
    for slot in bad[: max(0, REPORTED_NONFINITE - len(progress.nonfinite))]:
        sample, index = divmod(int(slot), len(unit.pixels))
        x0, y0, x1, _ = progress.settings.window
        y, x = divmod(int(unit.pixels[index]), x1 - x0)
        progress.nonfinite.append({"x": x + x0, "y": y + y0, "sample": unit.first + sample})
    progress.nonfinite_count += len(bad)
    count_unit(progress, len(unit.pixels) * unit.spp, result.seconds)
    progress.rays.update(result.rays)


def count_unit(progress: Progress, lanes: int, seconds: float) -> None:
    """One more is done, in so many seconds of its thread."""
    progress.units += 1
    progress.unit_seconds = seconds
    keep = FORGET if progress.units > FIRST else 0.0
    progress.lately = (keep * progress.lately[0] + lanes, keep * progress.lately[1] + seconds)
    progress.camera_samples += lanes
    progress.samples = progress.camera_samples // max(1, progress.film.pixels)
