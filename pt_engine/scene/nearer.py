"""Two trees as one: that of what stands still, built once, and that of what moves, built for each moment.

A ray is sent through both. The second query stops at the first one's hit, and shadow rays that are blocked
are not sent again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from ..core.raykind import RayKind
from .accel import MISS, Accel, Hits
from .nested import Nested
from .sighted import Kinds, Sighted

if TYPE_CHECKING:
    from .round_accel import RoundAccel

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Still: TypeAlias = "Accel | Nested | Sighted"


class Nearer:
    """See the module; what it answers is what `Accel` would of all triangles.

    Parameters
    ----------
    still : Accel, Nested or Sighted
    moving : Accel or Sighted
    first : int
        Number of the moving ones' first triangle.
    """

    def __init__(self, still: Still, moving: Accel | Sighted, first: int) -> None:
        self._still, self._moving, self._first = still, moving, np.int32(first)

    def intersect(self, origin: Float32, direction: Float32, tfar: Float32, kind: Kinds = 0) -> Hits:
        """See `Accel.intersect`; `kind` as for `Sighted`."""
        if self._still.empty:
            return closest(self._moving, origin, direction, tfar, kind)
        behind = closest(self._still, origin, direction, tfar, kind)
        before = closest(self._moving, origin, direction, behind.t, kind)
        lanes = np.flatnonzero(before.prim >= 0)
        u, v, prim = behind.u, behind.v, behind.prim
        u[lanes], v[lanes] = before.u.take(lanes), before.v.take(lanes)
        prim[lanes] = before.prim.take(lanes) + self._first
        if behind.instance is not None:
            behind.instance[lanes] = MISS
        return Hits(before.t, u, v, prim, behind.instance)

    def visible(
        self, origin: Float32, direction: Float32, tfar: Float32, kind: Kinds = RayKind.SHADOW
    ) -> Int32:
        """See `Accel.visible`."""
        free = clear(self._still, origin, direction, tfar, kind)
        left = tfar.copy()
        left[free == 0] = -1
        free &= clear(self._moving, origin, direction, left, kind)
        return free


def closest(
    accel: Still | Nearer | RoundAccel,
    o: Float32,
    d: Float32,
    tfar: Float32,
    kind: Kinds,
    strand: Int32 | None = None,
) -> Hits:
    """Closest hits of rays of a `kind`, where that matters; `strand` where there are curves."""
    if strand is not None:
        return cast("RoundAccel", accel).intersect(o, d, tfar, kind, strand)
    if isinstance(accel, Accel | Nested):
        return accel.intersect(o, d, tfar)
    return accel.intersect(o, d, tfar, kind)


def clear(
    accel: Still | Nearer | RoundAccel,
    o: Float32,
    d: Float32,
    tfar: Float32,
    kind: Kinds,
    strand: Int32 | None = None,
) -> Int32:
    """Whether nothing that rays of a kind see is in their way; as `Accel.visible`."""
    if strand is not None:
        return cast("RoundAccel", accel).visible(o, d, tfar, kind, strand)
    if isinstance(accel, Accel | Nested):
        return accel.visible(o, d, tfar)
    return accel.visible(o, d, tfar, kind)
