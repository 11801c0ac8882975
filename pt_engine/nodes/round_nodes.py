"""What hair and point clouds know of themselves: Hair Info (Curves Info), Point Info. All 0 on meshes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .graph import NodeView
from .ir import FLOAT, VECTOR, Value, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]

NUMBERS = {"Intercept": 0, "Length": 1, "Random": 2, "Thickness": 3}


@lane_op(FLOAT)
def on_strand(lanes: Any) -> Float32:
    """1 on curves."""
    out = np.zeros(lanes.n, np.float32)
    if lanes.rounds is not None:
        out[lanes.rounds.curves] = 1
    return out


@lane_op(FLOAT, reads="strand")
def strand_number(lanes: Any, which: int) -> Float32:
    """Where along the strand the point is, the strand's length, random number or thickness."""
    return lanes.strand()[which]  # type: ignore[no-any-return]


@lane_op(VECTOR)
def tangent_normal(lanes: Any) -> Float32:
    """The part of wi across the strand, unit length: the normal of a ribbon as it is."""
    out = np.zeros((3, lanes.n), np.float32)
    if lanes.rounds is not None:
        where, tangent = lanes.rounds.curves, lanes.rounds.tangent
        wi = lanes.wi.take(where, axis=1)
        out[:, where] = vectors.normalize(wi - vectors.dot(wi, tangent) * tangent)
    return out


@node("HairInfo")
def hair_info(n: NodeView) -> Outputs:
    out: dict[str, Value | None] = {
        name: n.call(strand_number, static=(k,)) for name, k in NUMBERS.items() if n.wants(name)
    }
    out["Is Strand"] = n.call(on_strand)
    if n.wants("Tangent Normal"):
        out["Tangent Normal"] = n.call(tangent_normal)
    return out


@lane_op(VECTOR, FLOAT, FLOAT)
def point_of_cloud(lanes: Any) -> tuple[Float32, Float32, Float32]:
    """World position, radius and random number of the point whose sphere was hit."""
    position, radius, random = (np.zeros(shape, np.float32) for shape in ((3, lanes.n), lanes.n, lanes.n))
    if lanes.rounds is not None:
        where = lanes.rounds.points
        position[:, where] = lanes.rounds.centre + lanes.scene.origin32
        radius[where], random[where] = lanes.rounds.radius, lanes.rounds.random
    return position, radius, random


@node("PointInfo")
def point_info(n: NodeView) -> Outputs:
    position, radius, random = n.calls(point_of_cloud)
    return {"Position": position, "Radius": radius, "Random": random}
