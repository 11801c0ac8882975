"""Rays against instances that are not placed: each ray is taken to the meshes whose boxes it runs through.

embreex cannot nest Embree scenes, so the upper level is ours (`box_tree`) and the lower one a small Embree
scene for each mesh. A ray visits its boxes from the nearest on, and stops where what it has found is nearer
than the next.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .accel import MISS, Accel, Hits
from .box_tree import BoxTree
from .geometry import Placed, world_boxes
from .instancing import Sharing
from .snapshot import Snapshot
from .transforms import Transforms

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Index = NDArray[np.intp]

CHUNK = 1 << 13  # rays whose pairs with boxes are listed at once


class Taken(NamedTuple):
    """Rays in the space of one mesh: its tree, and each ray's instance, lane, origin and direction."""

    accel: Accel
    instance: Int32
    lanes: Index
    o: Float32
    d: Float32


class Nested:
    """What `placed` holds, and nested instances; never empty.

    Parameters
    ----------
    placed : Accel
    snapshot : Snapshot
    sharing : Sharing
    geometry : Placed
        Tells the origin, and where the instances' records begin.
    """

    empty = False

    def __init__(self, placed: Accel, snapshot: Snapshot, sharing: Sharing, geometry: Placed) -> None:
        meshes, instances, origin = snapshot.meshes, snapshot.instances, geometry.origin
        self._placed, self._instance = placed, sharing.left_out()
        self._prototype = sharing.prototype[self._instance]
        self._first = geometry.first_record.astype(np.int32)
        self._transforms = Transforms(instances.matrix, origin)
        low, high = (corner[self._instance] - origin for corner in world_boxes(meshes, instances))
        self._tree = BoxTree(low, high)
        self._accels = {}
        for number in np.flatnonzero(sharing.nested):
            mesh = meshes[instances.mesh[sharing.sample[number]]]
            self._accels[int(number)] = Accel(mesh.vertices, mesh.triangles)

    def intersect(self, origin: Float32, direction: Float32, tfar: Float32) -> Hits:
        """See `Accel.intersect`."""
        hits = self._placed.intersect(origin, direction, tfar)
        instance = np.full(len(tfar), MISS, np.int32) if hits.instance is None else hits.instance
        columns = hits.t, hits.u, hits.v, hits.prim, instance
        for part in chunks(len(tfar)):
            self._closest(origin[:, part], direction[:, part], [column[part] for column in columns])
        return Hits(*columns)

    def visible(self, origin: Float32, direction: Float32, tfar: Float32) -> Int32:
        """See `Accel.visible`."""
        clear = self._placed.visible(origin, direction, tfar)
        left = np.where(clear != 0, tfar, np.float32(-1))
        for part in chunks(len(tfar)):
            self._blocked(origin[:, part], direction[:, part], left[part])
        return clear & -(left >= 0).astype(np.int32)

    def _closest(self, o: Float32, d: Float32, best: list[NDArray[Any]]) -> None:
        """Put nearer hits into the columns `best`, in the order of `Hits`."""
        for lanes, box in self._visits(o, d, best[0]):
            for ray in self._taken(lanes, box, o, d):
                hits = ray.accel.intersect(ray.o, ray.d, best[0].take(ray.lanes))
                met = np.flatnonzero(hits.prim >= 0)
                instance = ray.instance.take(met)
                row = hits.prim.take(met) + self._first.take(instance)
                found = (hits.t.take(met), hits.u.take(met), hits.v.take(met), row, instance)
                for column, value in zip(best, found, strict=True):
                    column[ray.lanes.take(met)] = value

    def _blocked(self, o: Float32, d: Float32, tfar: Float32) -> None:
        """Set `tfar` to −1 where something lies before it."""
        for lanes, box in self._visits(o, d, tfar):
            for ray in self._taken(lanes, box, o, d):
                clear = ray.accel.visible(ray.o, ray.d, tfar.take(ray.lanes))
                tfar[ray.lanes[clear == 0]] = -1

    def _visits(self, o: Float32, d: Float32, t: Float32) -> Iterator[tuple[Index, Index]]:
        """Lanes and the next box of each, until none is nearer than `t` (N,), which may shrink meanwhile."""
        pairs = self._tree.pairs(o, d, t)
        count = np.bincount(pairs.ray, minlength=len(t))
        first = np.cumsum(count) - count
        lanes = np.flatnonzero(count)
        visit = 0
        while len(lanes):
            row = first.take(lanes) + visit
            on = np.flatnonzero(pairs.enters.take(row) <= t.take(lanes))
            lanes, row = lanes.take(on), row.take(on)
            if len(lanes):
                yield lanes, pairs.box.take(row)
            visit += 1
            lanes = lanes[count.take(lanes) > visit]

    def _taken(self, lanes: Index, box: Index, o: Float32, d: Float32) -> Iterator[Taken]:
        """Rays and boxes, mesh by mesh."""
        prototype = self._prototype.take(box)
        for number in np.unique(prototype):
            some = np.flatnonzero(prototype == number)
            own, instance = lanes.take(some), self._instance.take(box.take(some))
            ray = self._transforms.ray_to_object(o.take(own, axis=1), d.take(own, axis=1), instance)
            yield Taken(self._accels[int(number)], instance, own, *ray)


def chunks(n: int) -> Iterator[slice]:
    """Slices that cover range(n)."""
    return (slice(k, k + CHUNK) for k in range(0, n, CHUNK))
