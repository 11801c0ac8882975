"""The Geometry node: the surface at the point, its normals and sides."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .attribute_nodes import mesh_attribute
from .coordinates import position
from .graph import NodeView, shading_normal
from .ir import FLOAT, VECTOR, Op, Value, lane_op
from .registry import Outputs, node
from .tangents import surface_tangent

Float32 = NDArray[np.float32]


@lane_op(VECTOR)
def true_normal(lanes: Any) -> Float32:
    """The face's normal, on the viewer's side."""
    return lanes.ng  # type: ignore[no-any-return]


@lane_op(VECTOR)
def face_normal(lanes: Any) -> Float32:
    """The true normal on the viewer's side: ribbons face the ray, though they are shaded as if round."""
    if lanes.rounds is None or not len(lanes.rounds.ribbons):
        return lanes.ng  # type: ignore[no-any-return]
    normal: Float32 = lanes.ng.copy()
    normal[:, lanes.rounds.ribbons] = lanes.wi.take(lanes.rounds.ribbons, axis=1)
    return normal


@lane_op(VECTOR)
def incoming(lanes: Any) -> Float32:
    """Toward the viewer."""
    return lanes.wi  # type: ignore[no-any-return]


@lane_op(VECTOR, moves=True)
def parametric(lanes: Any) -> Float32:
    """Barycentric weights of the first two corners."""
    uv = lanes.barycentric()
    return np.stack([1 - uv[0] - uv[1], uv[0], np.zeros_like(uv[0])])


@lane_op(FLOAT)
def backfacing(lanes: Any) -> Float32:
    """1 behind the face."""
    return lanes.backfacing  # type: ignore[no-any-return]


@node("NewGeometry")
def geometry(n: NodeView) -> Outputs:
    wanted = n.reader.used.get(n.number, set())
    table: dict[str, tuple[Op, tuple[Any, ...]]] = {
        "Position": (position, ()),
        "Normal": (shading_normal, ()),
        "Tangent": (surface_tangent, ()),
        "True Normal": (face_normal, ()),
        "Incoming": (incoming, ()),
        "Parametric": (parametric, ()),
        "Backfacing": (backfacing, ()),
    }
    out: dict[str, Value | None] = {
        name: n.call(what, *(n.bent() if name == "Tangent" else ()), static=static)
        for name, (what, static) in table.items()
        if name in wanted
    }
    if "Normal" in wanted and n.reader.surface_normal is not None:
        out["Normal"] = n.reader.surface_normal
    if n.reader.world:
        out["Tangent"] = n.constant(0.0, VECTOR)
    for name in wanted & {"Pointiness", "Random Per Island"}:
        own = name.lower().replace(" ", "_")
        out[name] = n.constant(0.0, FLOAT) if n.reader.world else n.calls(mesh_attribute, static=(own,))[2]
    return out
