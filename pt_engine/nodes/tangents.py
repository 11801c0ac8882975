"""Directions along the surface: around an axis, or along a uv map."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .graph import NodeView
from .ir import FLOAT, VECTOR, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]


@lane_op(VECTOR, reads="generated")
def around_axis(lanes: Any, axis: str, *normal: Float32) -> Float32:
    """Unit tangent that runs around an axis of the Generated box."""
    x, y, z = lanes.generated() - np.float32(0.5)
    zero = np.zeros_like(x)
    around = {"X": (zero, -z, y), "Y": (-z, zero, x), "Z": (-y, x, zero)}[axis]
    n = normal[0] if normal else lanes.ns
    return orthogonal_to(n, lanes.to_world_normal(np.stack(around)))


@lane_op(VECTOR, reads="generated")
def surface_tangent(lanes: Any, *normal: Float32) -> Float32:
    """Cycles' default tangent: along a strand, else around Generated's Z."""
    tangent: Float32 = around_axis.function(lanes, "Z", *normal)
    if lanes.rounds is not None:
        tangent[:, lanes.rounds.curves] = lanes.rounds.tangent
    return tangent


@lane_op(VECTOR, reads=lambda name: (f"tangent:{name}",))
def uv_tangent(lanes: Any, name: str, *normal: Float32) -> Float32:
    """Unit tangent along growing u; it comes to the world as if it were a normal, as in Cycles."""
    tangent, _ = lanes.object_tangent(name)
    return orthogonal_to(normal[0] if normal else lanes.ns, lanes.to_world_normal(tangent))


@lane_op(VECTOR, FLOAT, moves=True, reads=lambda name: (f"tangent:{name}",))
def stored_tangent(lanes: Any, name: str) -> tuple[Float32, Float32]:
    """The object's tangent along growing u as it is stored, and the sign of the bitangent."""
    return lanes.object_tangent(name)  # type: ignore[no-any-return]


def orthogonal_to(normal: Float32, tangent: Float32) -> Float32:
    """The part of `tangent` in the plane of `normal`, unit length."""
    return vectors.cross(normal, vectors.normalize(vectors.cross(tangent, normal)))


@node("Tangent")
def tangent_node(n: NodeView) -> Outputs:
    if n.reader.world:
        return {"Tangent": n.constant(0.0, VECTOR)}
    if n.prop("direction_type", "RADIAL") == "UV_MAP":
        return {"Tangent": n.call(uv_tangent, *n.bent(), static=(str(n.prop("uv_map", "")),))}
    return {"Tangent": n.call(around_axis, *n.bent(), static=(str(n.prop("axis", "Z")),))}
