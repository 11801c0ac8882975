"""Who sees what, as the snapshot says it: ray visibility, light and shadow linking. Pure data."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Int32: TypeAlias = NDArray[np.int32]


class Visibility:
    """Which rays see an object (bits; Blender's ray visibility panel)."""

    CAMERA, DIFFUSE, GLOSSY, TRANSMISSION, SHADOW, VOLUME = 1, 2, 4, 8, 16, 32
    ALL = 63
    # no kinds of rays: where the camera sees it, the film has a hole; or only shadows on it
    HOLDOUT, CATCHER = 64, 128


UNLIMITED = 1024  # bounces


@dataclass(frozen=True)
class Linking:
    """Light and shadow linking: emitters, receivers and blockers in sets, set 0 those without any link.

    Attributes
    ----------
    receives : (R, E) uint8
        1 where receivers of a set get the light of emitters of a set.
    blocks : (B, E) uint8
        1 where blockers of a set cast shadows in the light of emitters of a set.
    receiver, blocker, emitter : (I,) int32
        Sets of each instance.
    """

    receives: NDArray[np.uint8]
    blocks: NDArray[np.uint8]
    receiver: Int32
    blocker: Int32
    emitter: Int32

    def of(self, rows: slice | NDArray[np.intp]) -> Linking:
        """The same for some instances."""
        return Linking(
            self.receives, self.blocks, self.receiver[rows], self.blocker[rows], self.emitter[rows]
        )
