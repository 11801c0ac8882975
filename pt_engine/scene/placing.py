"""Meshes placed with records of their own, copied or nested (see `instancing`), and all that built."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .accel import Accel
from .geometry import Float32, Geometry, Int32, Placed, pack, place
from .instancing import Shared, Sharing, candidates, copies
from .nearer import Nearer
from .nested import Nested
from .snapshot import Snapshot

if TYPE_CHECKING:
    from ..nodes.compile import Materials

Mesh = tuple[Float32, Int32]


def build(
    snapshot: Snapshot, sharing: Sharing | None, moving: range
) -> tuple[Placed, Accel | Nested | Nearer, Geometry]:
    """Triangles in the world, what rays are sent at, and the records.

    These come last: Embree's build needs the most memory, and then has it. The instances `moving`, the last
    ones, have a tree of their own.
    """
    placed = place(snapshot, sharing)
    still, last = halves(snapshot, placed, moving)
    more = () if sharing is None else copies(snapshot, sharing, placed.first_record, placed.origin)
    flat = Accel(*still, more)
    moved = Accel(*last) if moving else None
    geometry = pack(snapshot, placed, sharing)
    accel: Accel | Nested = flat
    if sharing is not None:
        geometry.shared = Shared(snapshot, placed.origin)
        if sharing.nested.any():
            accel = Nested(flat, snapshot, sharing, placed)
    if moved is None:
        return placed, accel, geometry
    return placed, Nearer(accel, moved, len(still[1])), geometry


def halves(snapshot: Snapshot, placed: Placed, moving: range) -> tuple[Mesh, Mesh]:
    """Placed vertices and triangles of what stands still, and of the instances `moving` behind it."""
    if not moving:
        return (placed.vertices, placed.triangles), (placed.vertices[:0], placed.triangles[:0])
    size = sum(len(snapshot.meshes[m].vertices) for m in snapshot.instances.mesh[moving.start :])
    vertex, triangle = len(placed.vertices) - size, placed.first_triangle[moving.start]
    last = placed.vertices[vertex:], placed.triangles[triangle:] - np.int32(vertex)
    return (placed.vertices[:vertex], placed.triangles[:triangle]), last


def may_share(snapshot: Snapshot, materials: Materials, alone: list[int]) -> Sharing | None:
    """Who may: not emitters, which differ from each other, nor the instances `alone`."""
    apart = materials.emits[snapshot.instances.materials].any(axis=1)
    apart[alone] = True
    return candidates(snapshot, apart)
