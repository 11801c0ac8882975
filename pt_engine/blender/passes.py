"""The render passes: a table of what each is called, and what of a film it shows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ..render.film import Film
from ..render.progressive import RenderResult


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


def switch_on(layer) -> None:
    """All of them, in a view layer."""
    for each in PASSES:
        setattr(layer.pt_engine, each.switch, True)


def wants_halves(layer) -> bool:
    """Whether the film has to keep its halves apart."""
    return any(p.switch == "use_pass_halves" for p in enabled(layer))


def of_groups(layer) -> dict[str, str]:
    """The passes of a view layer's light groups, by their names, and the groups'."""
    return {f"Combined_{group.name}": group.name for group in layer.lightgroups}


def films(layer) -> int:
    """How many pictures are kept of a view layer: one, and one for each light group."""
    return 1 + len(layer.lightgroups)


def beside_combined(layer) -> Iterator[tuple[str, int, str, str]]:
    """Name, channels, letters and kind of each pass of a view layer but the first."""
    for p in enabled(layer):
        yield p.name, p.channels, p.letters, p.kind
    for name in of_groups(layer):
        yield name, 3, "RGB", "COLOR"


def registered_passes(layer) -> Iterator[tuple[str, int, str, str]]:
    """The same with Combined, for Blender's list of sockets."""
    yield COMBINED
    yield from beside_combined(layer)


def add_to(engine, layer) -> None:
    """Have the next render result hold the passes of a view layer."""
    for name, channels, letters, _ in beside_combined(layer):
        engine.add_pass(name, channels, letters, layer=layer.name)


def images(layer, result: RenderResult) -> Iterator[tuple[str, np.ndarray]]:
    """Name and image of each pass of a view layer but the first."""
    for p in enabled(layer):
        yield p.name, p.image(result.film)
    for name, group in of_groups(layer).items():
        yield name, result.light_group(group)
