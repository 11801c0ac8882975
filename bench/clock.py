"""Timing from outside: methods of the engine are wrapped while a measurement lasts.

A stage's time excludes that of the stages that it calls, so the stages of a pass add up to the pass.
Thread CPU time is taken, which other programs on the machine lengthen much less than wall time.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import GeneratorType
from typing import Any

Function = Callable[..., Any]


class Clock:
    """Seconds and calls per stage."""

    def __init__(self) -> None:
        self.seconds: Counter[str] = Counter()
        self.calls: Counter[str] = Counter()
        self.counts: Counter[str] = Counter()
        self._stack: list[str] = []
        self._since = 0.0

    def _switch(self) -> None:
        now = time.thread_time()
        if self._stack:
            self.seconds[self._stack[-1]] += now - self._since
        self._since = now

    def enter(self, stage: str) -> None:
        """From here on time counts for `stage`."""
        self._switch()
        self._stack.append(stage)
        self.calls[stage] += 1

    def leave(self) -> None:
        """Back to the stage that called this one."""
        self._switch()
        self._stack.pop()


def timed(function: Function, clock: Clock, stage: str) -> Function:
    """The same function, its time counted for `stage`; a generator is run to its end at once."""

    def wrapper(*args: Any, **kwargs: Any) -> Any:
        clock.enter(stage)
        try:
            result = function(*args, **kwargs)
            return list(result) if isinstance(result, GeneratorType) else result
        finally:
            clock.leave()

    return wrapper


@contextmanager
def wrapped(targets: list[tuple[Any, str, Callable[[Function], Function]]]) -> Iterator[None]:
    """Replace attributes (owner, name) by what their third member makes of them, for a while."""
    originals = [(owner, name, owner.__dict__[name]) for owner, name, _ in targets]
    try:
        for owner, name, make in targets:
            setattr(owner, name, make(owner.__dict__[name]))
        yield
    finally:
        for owner, name, original in reversed(originals):
            setattr(owner, name, original)
