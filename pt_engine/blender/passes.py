"""The render passes: a table of what each is called, and what of a film it shows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ..render.film import Film


class Pass(NamedTuple):
    """A pass in Blender's words; `switch` is the view layer's property that enables it."""

    switch: str
    name: str
    channels: int
    letters: str
    kind: str
    image: Callable[[Film], np.ndarray]


COMBINED = ("Combined", 4, "RGBA", "COLOR")
PASSES = (
    Pass("use_pass_standard_error", "Standard Error", 3, "RGB", "COLOR", lambda film: film.standard_error()),
    Pass("use_pass_sample_count", "Sample Count", 1, "X", "VALUE", lambda film: film.counts()),
    Pass("use_pass_halves", "Half A", 3, "RGB", "COLOR", lambda film: film.half(0)),
    Pass("use_pass_halves", "Half B", 3, "RGB", "COLOR", lambda film: film.half(1)),
)


def enabled(layer) -> tuple[Pass, ...]:
    """The passes that are switched on in a view layer, beyond Combined."""
    own = getattr(layer, "pt_engine", None)
    return tuple(p for p in PASSES if getattr(own, p.switch, False))


def wants_halves(layer) -> bool:
    """Whether the film has to keep its halves apart."""
    return any(p.switch == "use_pass_halves" for p in enabled(layer))


def registered_passes(layer) -> Iterator[tuple[str, int, str, str]]:
    """Name, channels, letters and kind of each pass, for Blender's list of sockets."""
    yield COMBINED
    for p in enabled(layer):
        yield p.name, p.channels, p.letters, p.kind


def add_to(engine, layer) -> None:
    """Have the next render result hold the passes of a view layer."""
    for p in enabled(layer):
        engine.add_pass(p.name, p.channels, p.letters, layer=layer.name)
