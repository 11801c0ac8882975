"""Meshes placed with records of their own, copied or nested (see `instancing`), and all that built."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .accel import Accel
from .geometry import Geometry, Placed, pack, place
from .instancing import Shared, Sharing, candidates, copies
from .nested import Nested
from .snapshot import Snapshot

if TYPE_CHECKING:
    from ..nodes.compile import Materials


def build(snapshot: Snapshot, sharing: Sharing | None) -> tuple[Placed, Accel | Nested, Geometry]:
    """Triangles in the world, what rays are sent at, and the records.

    These come last: Embree's build needs the most memory, and then has it.
    """
    placed = place(snapshot, sharing)
    if sharing is None:
        accel = Accel(placed.vertices, placed.triangles)
        return placed, accel, pack(snapshot, placed)
    more = copies(snapshot, sharing, placed.first_record, placed.origin)
    accel = Accel(placed.vertices, placed.triangles, more)
    geometry = pack(snapshot, placed, sharing)
    geometry.shared = Shared(snapshot, placed.origin)
    if sharing.nested.any():
        return placed, Nested(accel, snapshot, sharing, placed), geometry
    return placed, accel, geometry


def may_share(snapshot: Snapshot, materials: Materials, selves: list[int]) -> Sharing | None:
    """Who may: not emitters, which differ from each other, nor instances that look at themselves."""
    apart = materials.emits[snapshot.instances.materials].any(axis=1)
    apart[selves] = True
    return candidates(snapshot, apart)
