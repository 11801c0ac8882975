"""Two trees as one: that of what stands still, built once, and that of what moves, built for each moment.

A ray is sent through both. The second query stops at the first one's hit, and shadow rays that are blocked
are not sent again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .accel import MISS, Accel, Hits

if TYPE_CHECKING:
    from .nested import Nested

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


class Nearer:
    """See the module; what it answers is what `Accel` would of all triangles.

    Parameters
    ----------
    still : Accel or Nested
    moving : Accel
    first : int
        Number of the moving ones' first triangle.
    """

    def __init__(self, still: Accel | Nested, moving: Accel, first: int) -> None:
        self._still, self._moving, self._first = still, moving, np.int32(first)

    def intersect(self, origin: Float32, direction: Float32, tfar: Float32) -> Hits:
        """See `Accel.intersect`."""
        if self._still.empty:
            return self._moving.intersect(origin, direction, tfar)
        behind = self._still.intersect(origin, direction, tfar)
        before = self._moving.intersect(origin, direction, behind.t)
        lanes = np.flatnonzero(before.prim >= 0)
        u, v, prim = behind.u, behind.v, behind.prim
        u[lanes], v[lanes] = before.u.take(lanes), before.v.take(lanes)
        prim[lanes] = before.prim.take(lanes) + self._first
        if behind.instance is not None:
            behind.instance[lanes] = MISS
        return Hits(before.t, u, v, prim, behind.instance)

    def visible(self, origin: Float32, direction: Float32, tfar: Float32) -> Int32:
        """See `Accel.visible`."""
        clear = self._still.visible(origin, direction, tfar)
        left = tfar.copy()
        left[clear == 0] = -1
        clear &= self._moving.visible(origin, direction, left)
        return clear
