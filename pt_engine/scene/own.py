"""Rays that see only the object they start on.

Embree cannot be asked to leave triangles out, and going on behind another object's would miss what lies in
its plane (a box on a floor). So each object whose material asks has a small tree of its own triangles.
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .accel import MISS, Accel, Hits
from .geometry import Placed
from .rounds import rounds_among
from .snapshot import Snapshot

if TYPE_CHECKING:
    from ..nodes.compile import Materials

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


class OwnObjects:
    """A tree for each of some instances.

    Parameters
    ----------
    placed : Placed
    instances : iterable of int
        Those whose materials look at their own object.
    """

    def __init__(self, placed: Placed, instances: list[int]) -> None:
        self._first = placed.first_triangle
        self._trees: dict[int, Accel] = {}
        for k in instances:
            triangles = placed.triangles[self._first[k] : self._first[k + 1]]
            if len(triangles):
                low, high = int(np.min(triangles)), int(np.max(triangles)) + 1
                self._trees[k] = Accel(placed.vertices[low:high].copy(), triangles - np.int32(low))

    def with_last(self, placed: Placed, instances: list[int]) -> OwnObjects:
        """The same with other trees for some of the last instances, which are all that `placed` has."""
        joined, moved = copy.copy(self), OwnObjects(placed, instances)
        shift = len(self._first) - len(placed.first_triangle)
        joined._trees = self._trees | {k + shift: tree for k, tree in moved._trees.items()}
        return joined

    def intersect(self, instance: Int32, o: Float32, d: Float32, tfar: Float32) -> Hits:
        """Closest hits of rays (3, N), each with its `instance` (N,) alone; see `Accel.intersect`."""
        t, u, v = (np.zeros(len(tfar), np.float32) for _ in range(3))
        prim = np.full(len(tfar), MISS, np.int32)
        for k in np.unique(instance):
            tree = self._trees.get(int(k))
            if tree is None:
                continue
            lanes = np.flatnonzero(instance == k)
            hits = tree.intersect(o.take(lanes, axis=1), d.take(lanes, axis=1), tfar.take(lanes))
            t[lanes], u[lanes], v[lanes] = hits.t, hits.u, hits.v
            prim[lanes] = np.where(hits.prim >= 0, hits.prim + np.int32(self._first[k]), MISS)
        return Hits(t, u, v, prim)


def looking_at_themselves(snapshot: Snapshot, materials: Materials) -> list[int]:
    """Instances of which some material traces rays within its own object."""
    asks = [m for m, b in enumerate(materials.batch_of) if "own" in materials.batches[b].needs]
    if not asks:
        return []
    asking = np.isin(snapshot.instances.materials, asks).any(axis=1)
    asking[rounds_among(snapshot)] = False  # hulls are no surfaces
    return [int(k) for k in np.flatnonzero(asking)]
