"""Where a thread's time goes: functions that are a stage of rendering say so, and a clock that runs notes it.

A stage's time leaves out that of the stages that it calls, so all stages add up to the time of the whole.
It is CPU time where the system measures that finely, so that neither other programs nor threads that wait
for each other are counted. Without a clock on the thread a stage costs one look-up, once a wavefront.
"""

from __future__ import annotations

import functools
import inspect
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

P = ParamSpec("P")
R = TypeVar("R")

FINE = time.get_clock_info("thread_time").resolution < 1e-4  # on Windows it is 16 ms
now = time.thread_time if FINE else time.perf_counter


class Cell(NamedTuple):
    """What time is spent on: a stage, an effect (or ""), a batch of materials (or −1), and a bounce."""

    stage: str
    effect: str
    batch: int
    bounce: int


class Clock:
    """Of one thread: seconds per cell, rays per stage and bounce, vertices per material.

    Parameters
    ----------
    stage : str
        What all the time is for that no stage asks for.
    """

    def __init__(self, stage: str = "rest") -> None:
        self.seconds: dict[tuple[str, str, int, int], float] = {}  # by `Cell`
        self.rays: Counter[tuple[str, int]] = Counter()
        self.vertices: Counter[int] = Counter()
        self._bounce = -1
        self._stack: list[tuple[str, str, int, int]] = [(stage, "", -1, 0)]  # made faster than a `Cell`
        self._since = now()

    def enter(self, stage: str, effect: str = "", batch: int = -1) -> None:
        """From here on time counts for `stage`; what is not said stays as it is."""
        self._note()
        old_stage, old_effect, old_batch, bounce = self._stack[-1]
        cell = (stage or old_stage, effect or old_effect, batch if batch >= 0 else old_batch, bounce)
        self._stack.append(cell)

    def leave(self) -> None:
        """Back to the stage that called this one."""
        self._note()
        self._stack.pop()

    def _note(self) -> None:
        at, cell = now(), self._stack[-1]
        self.seconds[cell] = self.seconds.get(cell, 0.0) + at - self._since
        self._since = at

    def set_bounce(self, bounce: int) -> None:
        """From here on time counts for that bounce of the paths."""
        self._note()
        self._bounce = bounce
        self._stack = [(*cell[:3], max(0, bounce)) for cell in self._stack]

    @property
    def bounce(self) -> int:
        """The paths' edge that time counts for; −1 before the first."""
        return self._bounce

    def count_rays(self, number: int) -> None:
        """Rays of the stage that is running."""
        stage, _, _, bounce = self._stack[-1]
        self.rays[stage, bounce] += number


class _Thread(threading.local):
    clock: Clock | None = None


_thread = _Thread()


def running() -> Clock | None:
    """This thread's clock."""
    return _thread.clock


def start(clock: Clock) -> None:
    """Let a clock run on this thread until the thread ends."""
    _thread.clock = clock


def new_paths() -> None:
    """Camera rays are made."""
    if (clock := running()) is not None:
        clock.set_bounce(-1)


def before_bounce(bounce: int) -> None:
    """The paths' edges that are traced next are those of this bounce."""
    if (clock := running()) is not None:
        clock.set_bounce(bounce - 1)


def next_bounce() -> None:
    """The paths' next edges are traced; the first are bounce 0."""
    if (clock := running()) is not None:
        clock.set_bounce(clock.bounce + 1)


def count_rays(tfar: NDArray[np.float32]) -> None:
    """Those of a wavefront that are on belong to the stage that is running."""
    if (clock := running()) is not None:
        clock.count_rays(int(np.count_nonzero(tfar > 0)))


@contextmanager
def runs(clock: Clock) -> Iterator[Clock]:
    """A clock runs on this thread inside."""
    before = running()
    _thread.clock = clock
    try:
        yield clock
        clock._note()
    finally:
        _thread.clock = before


def stage(
    name: str, effect: str = "", batch: Callable[..., int] | None = None
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a function whose time counts for stage `name` ("": whichever calls it) and for an effect.

    `batch` gives the batch of materials, from the function's arguments. Of a generator, the time that it
    runs counts, not that of who asks it.
    """

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(function)
        def timed(*args: P.args, **kwargs: P.kwargs) -> R:
            clock = _thread.clock
            if clock is None:
                return function(*args, **kwargs)
            clock.enter(name, effect, batch(*args, **kwargs) if batch else -1)
            try:
                return function(*args, **kwargs)
            finally:
                clock.leave()

        @functools.wraps(function)
        def timed_generator(*args: P.args, **kwargs: P.kwargs) -> Any:
            made = cast("Iterator[Any]", function(*args, **kwargs))
            clock = running()
            return made if clock is None else _timed(made, clock, name, effect)

        return cast("Callable[P, R]", timed_generator) if inspect.isgeneratorfunction(function) else timed

    return decorate


def _timed(made: Iterator[Any], clock: Clock, name: str, effect: str) -> Iterator[Any]:
    while True:
        clock.enter(name, effect)
        try:
            item = next(made)
        except StopIteration:
            return
        finally:
            clock.leave()
        yield item
