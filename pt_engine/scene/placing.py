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
    from .nearer import Nearer
    from .slices import Slices


def build(
    snapshot: Snapshot, sharing: Sharing | None, slices: Slices | None = None
) -> tuple[Placed, Accel | Nearer | Nested, Geometry]:
    """Triangles in the world, what rays are sent at, and the records.

    Records come after Embree's build, which needs the most memory and then has it. What moves (`slices`) has
    a tree of its own.
    """
    placed = place(snapshot, sharing)
    still = (placed.vertices, placed.triangles) if slices is None else slices.still(placed)
    more = () if sharing is None else copies(snapshot, sharing, placed.first_record, placed.origin)
    tree = Accel(*still, more)
    accel: Accel | Nested = tree
    geometry = pack(snapshot, placed, sharing)
    if sharing is not None:
        geometry.shared = Shared(snapshot, placed.origin)
        if sharing.nested.any():
            accel = Nested(tree, snapshot, sharing, placed)
    return placed, accel if slices is None else slices.tree(accel, placed), geometry


def may_share(snapshot: Snapshot, materials: Materials, alone: list[int]) -> Sharing | None:
    """Who may: not emitters, which differ from each other, nor the instances `alone`."""
    apart = materials.emits[snapshot.instances.materials].any(axis=1)
    apart[alone] = True
    return candidates(snapshot, apart)
