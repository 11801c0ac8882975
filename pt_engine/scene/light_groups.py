"""Light groups: what of each camera ray's radiance comes from each group of emitters.

    L = Σ_g L_g        over the groups and what is in none

Whatever a path adds to its radiance comes from one emitter, so every share is an estimate of the same
integrand times [emitter ∈ g], with the same random numbers: the shares sum to the picture. As in Cycles,
light that a shadow catcher sends is in none of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core.rows import scatter_add

if TYPE_CHECKING:
    from .catcher import Caught

Float32 = NDArray[np.float32]
Groups = int | NDArray[np.integer]


class GroupLight:
    """The radiance along N camera rays, by group.

    Parameters
    ----------
    groups, lanes : int
    caught : Caught or None
        Where there are shadow catchers.
    """

    def __init__(self, groups: int, lanes: int, caught: Caught | None = None) -> None:
        self._lanes, self._caught = lanes, caught
        self._sums = np.zeros((3, (groups + 1) * lanes), np.float32)

    def add(self, group: Groups, slot: NDArray[np.int32], light: Float32) -> None:
        """Note `light` (3, K) of emitters of a `group`, 0 for none, that reaches the rays `slot` (K,)."""
        if self._caught is not None:
            light = light * ~self._caught.hit.take(slot)
        scatter_add(self._sums, np.asarray(group, np.intp) * self._lanes + slot, light)

    @property
    def radiance(self) -> Float32:
        """(3, G + 1, N) W·m⁻²·sr⁻¹; first what is in no group."""
        return self._sums.reshape(3, -1, self._lanes)
