"""Other versions of a prepared scene, which shade or choose their lights otherwise."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .scene import Scene


def changed(scene: Scene, change: Callable[[Scene], None]) -> Scene:
    """A copy that was changed, at every moment of its motion and as its catchers are seen alone."""
    made = copy.copy(scene)
    change(made)
    if scene.alone is not None:
        made.alone = changed(scene.alone, change)
    if scene.slices is not None:
        made.slices = scene.slices.of(made)
    return made
