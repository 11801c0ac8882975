"""Methods of the engine replaced while a measurement lasts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Function = Callable[..., Any]


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
