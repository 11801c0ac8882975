"""Meshes placed with records of their own, copied or nested (see `instancing`), and all that built."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .accel import Accel
from .geometry import Geometry, Placed, pack, place
from .instancing import Shared, Sharing, candidates, copies
from .nested import Nested
from .sighted import Sighted, among, sighted, standing_out, without
from .snapshot import Snapshot

if TYPE_CHECKING:
    from ..nodes.compile import Materials
    from .nearer import Nearer
    from .slices import Slices


def build(
    snapshot: Snapshot, sharing: Sharing | None, slices: Slices | None = None
) -> tuple[Placed, Accel | Nearer | Nested | Sighted, Geometry]:
    """Triangles in the world, what rays are sent at, and the records.

    Records come after Embree's build, which needs the most memory and then has it. What moves (`slices`) has
    a tree of its own.
    """
    placed = place(snapshot, sharing)
    if sharing is None and slices is None:
        return placed, sighted(placed, snapshot.instances, snapshot.linking), pack(snapshot, placed)
    out = standing_out(snapshot)
    if slices is not None:
        out[slices.moving] = False
    rest = without(placed, out)
    still = (rest.vertices, rest.triangles) if slices is None else slices.still(rest)
    more = () if sharing is None else copies(snapshot, sharing, placed.first_record, placed.origin)
    tree = Accel(*still, more)
    accel: Accel | Nested = tree
    geometry = pack(snapshot, placed, sharing)
    if sharing is not None:
        geometry.shared = Shared(snapshot, placed.origin)
        if sharing.nested.any():
            accel = Nested(tree, snapshot, sharing, placed)
    seen = among(accel, placed, snapshot, out) if out.any() else accel
    return placed, seen if slices is None else slices.tree(seen, placed), geometry


def may_share(snapshot: Snapshot, materials: Materials, alone: list[int]) -> Sharing | None:
    """Who may: not emitters, which differ from each other, nor the instances `alone`."""
    apart = materials.emits[snapshot.instances.materials].any(axis=1)
    apart[alone] = True
    return candidates(snapshot, apart)
