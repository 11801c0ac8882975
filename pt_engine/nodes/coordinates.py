"""Where a point is, in the world, in its object and on its maps: Texture Coordinate, UV Map."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .camera_nodes import camera_position, window_coordinates
from .followed import coordinates_of
from .graph import NodeView
from .ir import VECTOR, Op, Value, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]


@lane_op(VECTOR, moves=True)
def position(lanes: Any) -> Float32:
    """World position."""
    return lanes.position  # type: ignore[no-any-return]


@lane_op(VECTOR, moves=True, reads="generated")
def generated(lanes: Any) -> Float32:
    """Generated coordinates."""
    return lanes.generated()  # type: ignore[no-any-return]


@lane_op(VECTOR, moves=True)
def object_position(lanes: Any) -> Float32:
    """Position in object space."""
    return lanes.object_position()  # type: ignore[no-any-return]


@lane_op(VECTOR, moves=True)
def transformed_position(lanes: Any, *matrix: float) -> Float32:
    """World position through a 4×4 matrix, 16 numbers by rows: another object's coordinates."""
    m = np.array(matrix, np.float32).reshape(4, 4)
    p = lanes.position
    return np.stack([m[k, 0] * p[0] + m[k, 1] * p[1] + m[k, 2] * p[2] + m[k, 3] for k in range(3)])


@lane_op(VECTOR, moves=True, reads=lambda name: (f"uv:{name}",))
def uv_coordinates(lanes: Any, name: str) -> Float32:
    """(u, v, 0) of a uv map."""
    out = np.zeros((3, lanes.n), np.float32)
    out[:2] = lanes.uv(name)
    return out


@lane_op(VECTOR, moves=True)
def object_space_normal(lanes: Any, *normal: Float32) -> Float32:
    """The shading normal in object space."""
    n = normal[0] if normal else lanes.ns
    to_object = getattr(lanes, "to_object_normal", None)
    return n if to_object is None else vectors.normalize(to_object(n))


@lane_op(VECTOR, moves=True)
def normal_at_rest(lanes: Any, bent: Float32) -> Float32:
    """The same where displacement bends it to `bent`, which coordinates that Bump follows take no notice of.

    So it is in Cycles, on smooth faces: on flat ones, curves and points it has the bent normal to follow.
    """
    if not lanes.smooth:
        return object_space_normal(lanes, bent)  # type: ignore[no-any-return]
    if lanes.rounds is None:
        return object_space_normal(lanes)  # type: ignore[no-any-return]
    where = np.concatenate([lanes.rounds.curves, lanes.rounds.points])
    normal = lanes.ns.copy()
    normal[:, where] = np.broadcast_to(bent, normal.shape)[:, where]
    return object_space_normal(lanes, normal)  # type: ignore[no-any-return]


@lane_op(VECTOR, reads="object")
def instancer_coordinates(lanes: Any, what: str) -> Float32:
    """Where on its instancer the object was placed, `what` being "uv" or "generated"."""
    return lanes.per_object(f"instancer {what}")[:3]  # type: ignore[no-any-return]


@lane_op(VECTOR)
def mirrored_view(lanes: Any, in_world: bool, *normal: Float32) -> Float32:
    """Texture Coordinate's Reflection: wi mirrored about the normal; in a world the ray itself."""
    return lanes.wi if in_world else vectors.reflect(lanes.wi, normal[0] if normal else lanes.ns)


def coordinates(n: NodeView, default: Op = generated, static: tuple[Any, ...] = ()) -> Value:
    """A texture's Vector input; with neither link nor value it has its own. Then the old texture mapping."""
    is_constant = n.linked("Vector") is None and n.node.inputs.get("Vector") is not None
    given = n.vector("Vector") if is_constant else n.optional("Vector")
    vector = n.call(default, static=static) if given is None else given
    if n.node.props.get("texture_mapping"):
        from .vector_nodes import texture_mapping

        vector = texture_mapping(n, vector)
    return vector


@node("TexCoord")
def tex_coord(n: NodeView) -> Outputs:
    wanted = n.reader.used.get(n.number, set())
    from_instancer, in_world = bool(n.prop("from_instancer", False)), n.reader.world
    matrix = n.prop("object_matrix", None)
    table: dict[str, tuple[Op, tuple[Any, ...]]] = {
        "Generated": (generated, ()),
        "Normal": (object_space_normal, ()),
        "UV": (uv_coordinates, ("",)),
        "Object": (object_position, ()),
        "Camera": (camera_position, (in_world,)),
        "Reflection": (mirrored_view, (in_world,)),
    }
    if matrix is not None:
        table["Object"] = transformed_position, tuple(float(x) for x in matrix)
    if from_instancer:
        table["UV"] = instancer_coordinates, ("uv",)
        if not in_world:
            table["Generated"] = instancer_coordinates, ("generated",)
    if "Normal" in wanted and n.bent() and coordinates_of(n.node) in n.reader.followed:
        table["Normal"] = normal_at_rest, ()
    looking = {"Normal", "Reflection"}
    found = {"Window": window_coordinates(n)} if "Window" in wanted else {}
    return found | {
        name: n.call(what, *(n.bent() if name in looking else ()), static=static)
        for name, (what, static) in table.items()
        if name in wanted
    }


@node("UVMap")
def uv_map(n: NodeView) -> Outputs:
    if n.prop("from_instancer", False):
        return {"UV": n.call(instancer_coordinates, static=("uv",))}
    return {"UV": n.call(uv_coordinates, static=(str(n.prop("uv_map", "")),))}
