"""Where a thread's time goes: functions that are a stage of rendering say so, and a clock that runs notes it.

A stage's time leaves out that of the stages that it calls, so all stages add up to the time of the whole.
It is CPU time where the system measures that finely, so that neither other programs nor threads that wait
for each other are counted. Without a clock on the thread a stage costs one look-up, once a wavefront.

With one it costs ten to twenty microseconds (caches that forget, not the clock's own instructions), a hundred
times a wavefront: 3 to 5 % of a render. So a clock may look into a part of the units of work alone, which are
spread evenly over the render by the golden ratio: no period of tiles or passes keeps step with it. The first
two are looked into, too. The first stands for itself alone, for tables are made in it that last for all, and
short renders have but a few more. Rays, and the vertices of each batch, are counted in all of them; to tell a
batch's materials apart takes 7 ns a vertex, and is left to those units and to the first wavefront that meets
the batch.
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


UNTIMED = "untimed"
IN_UNIT = "unit"  # what a unit spends on no stage, apart from what is done between units
GOLDEN = 0.6180339887498949


class _Account:
    """Seconds of a cell; `inside` are the accounts of stages that were entered from it, by what they said."""

    __slots__ = ("cell", "inside", "seconds")

    def __init__(self, cell: Cell) -> None:
        self.cell, self.seconds = cell, 0.0
        self.inside: dict[tuple[str, str, int], _Account] = {}


class Clock:
    """Of one thread: seconds per cell, rays per stage and bounce, vertices per batch, and per material.

    In the units that it looks into also: rays of each stage by effect, and those that each material sends.

    Parameters
    ----------
    stage : str
        What all the time is for that no stage asks for.
    part : float
        Of the units of work, of which stages are told apart; the others' time is for `UNTIMED`.
    """

    def __init__(self, stage: str = "rest", part: float = 1.0) -> None:
        self._part, self._units = part, 0
        self.first: dict[Cell, float] = {}  # seconds by the end of the first unit
        self.rays: Counter[tuple[str, int]] = Counter()
        self.shaded: Counter[int] = Counter()  # vertices of each batch
        self.vertices: Counter[int] = Counter()  # of each material, where somebody looked
        self.by_effect: Counter[tuple[str, str]] = Counter()  # rays of each stage and effect
        self.sent: Counter[int] = Counter()  # rays that leave some of each material's vertices
        self.senders: Counter[int] = Counter()  # and those vertices
        self._bounce = -1
        self._accounts: dict[Cell, _Account] = {}
        self._stack = [self._account(Cell(stage, "", -1, 0))]
        self._since = now()

    @property
    def seconds(self) -> dict[Cell, float]:
        """Of each cell so far."""
        return {cell: account.seconds for cell, account in self._accounts.items() if account.seconds}

    def enter(self, stage: str, effect: str = "", batch: int = -1) -> None:
        """From here on time counts for `stage`; what is not said stays as it is."""
        stack, at, words = self._stack, now(), (stage, effect, batch)
        caller = stack[-1]
        caller.seconds += at - self._since
        self._since = at
        stack.append(caller.inside.get(words) or self._open(caller, words))

    def leave(self) -> None:
        """Back to the stage that called this one."""
        at = now()
        self._stack.pop().seconds += at - self._since
        self._since = at

    def note(self) -> None:
        """Enter the time until now."""
        at = now()
        self._stack[-1].seconds += at - self._since
        self._since = at

    def _open(self, caller: _Account, words: tuple[str, str, int]) -> _Account:
        stage, effect, batch = words
        old = caller.cell
        cell = Cell(stage or old.stage, effect or old.effect, batch if batch >= 0 else old.batch, old.bounce)
        opened = caller.inside[words] = self._account(cell)
        return opened

    def _account(self, cell: Cell) -> _Account:
        return self._accounts.setdefault(cell, _Account(cell))

    def looks_into_next(self) -> bool:
        """Whether the stages of the next unit are told apart; those of the first two are."""
        if self._units == 1:
            self.first = self.seconds
        looks = self._units < 2 or self._units * GOLDEN % 1.0 < self._part
        self._units += 1
        return looks

    def set_bounce(self, bounce: int) -> None:
        """From here on time and rays count for that bounce of the paths."""
        self._bounce = bounce
        if _thread.clock is None:
            return
        self.note()
        self._stack = [self._account(each.cell._replace(bounce=max(0, bounce))) for each in self._stack]

    def tells_apart(self, batch: int, vertices: int) -> bool:
        """Count them for the batch; whether its materials are to be told apart, too."""
        new = batch not in self.shaded
        self.shaded[batch] += vertices
        return new or _thread.clock is not None

    def count_rays(self, stage: str, number: int) -> None:
        """Rays of a stage; where the clock looks, of the effect that they are for, too."""
        self.rays[stage, max(0, self._bounce)] += number
        if _thread.clock is not None:
            self.by_effect[stage, self._stack[-1].cell.effect] += number

    @property
    def bounce(self) -> int:
        """The paths' edge that time counts for; −1 before the first."""
        return self._bounce


class _Thread(threading.local):
    """Its clock where there is one: who counts, and who times, which is nobody in some units."""

    counting: Clock | None = None
    clock: Clock | None = None


_thread = _Thread()


def counting() -> Clock | None:
    """This thread's clock, for rays and vertices."""
    return _thread.counting


def looking() -> Clock | None:
    """This thread's clock, where it looks into this unit of work."""
    return _thread.clock


def start(clock: Clock | None) -> None:
    """Let a clock run on this thread until the thread ends."""
    _thread.counting = _thread.clock = clock


def unit_of_work(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate what renders a unit of work: the clock may let it pass without looking into it."""

    @functools.wraps(function)
    def timed(*args: P.args, **kwargs: P.kwargs) -> R:
        clock = _thread.clock
        if clock is None:
            return function(*args, **kwargs)
        looks = clock.looks_into_next()
        clock.enter(IN_UNIT if looks else UNTIMED)
        _thread.clock = clock if looks else None
        try:
            return function(*args, **kwargs)
        finally:
            _thread.clock = clock
            clock.leave()

    return timed


def new_paths() -> None:
    """Camera rays are made."""
    if (clock := _thread.counting) is not None:
        clock.set_bounce(-1)


def before_bounce(bounce: int) -> None:
    """The paths' edges that are traced next are those of this bounce."""
    if (clock := _thread.counting) is not None:
        clock.set_bounce(bounce - 1)


def next_bounce() -> None:
    """The paths' next edges are traced; the first are bounce 0."""
    if (clock := _thread.counting) is not None:
        clock.set_bounce(clock.bounce + 1)


def count_rays(stage: str, tfar: NDArray[np.float32]) -> None:
    """Those of a wavefront that are on belong to a stage."""
    if (clock := _thread.counting) is not None:
        clock.count_rays(stage, int(np.count_nonzero(tfar > 0)))


@contextmanager
def runs(clock: Clock) -> Iterator[Clock]:
    """A clock runs on this thread inside."""
    before = _thread.counting
    start(clock)
    try:
        yield clock
        clock.note()
    finally:
        start(before)


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
            clock = _thread.clock
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
