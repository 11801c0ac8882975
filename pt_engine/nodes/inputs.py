"""Nodes that read the shading point: coordinates, geometry, object, ray."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.raykind import RayKind
from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, Op, Value, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]


# ------------------------------------------------------------------ what the lanes give


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


@lane_op(COLOR, FLOAT, moves=True, reads=lambda name: (f"color:{name}",))
def color_attribute(lanes: Any, name: str) -> tuple[Float32, Float32]:
    """Colour and alpha of a colour attribute."""
    rgba = lanes.color(name)
    return rgba[:3], rgba[3]


@lane_op(VECTOR)
def shading_normal(lanes: Any) -> Float32:
    """Interpolated normal, on the viewer's side."""
    return lanes.ns  # type: ignore[no-any-return]


@lane_op(VECTOR)
def true_normal(lanes: Any) -> Float32:
    """The face's normal, on the viewer's side."""
    return lanes.ng  # type: ignore[no-any-return]


@lane_op(VECTOR)
def incoming(lanes: Any) -> Float32:
    """Toward the viewer."""
    return lanes.wi  # type: ignore[no-any-return]


@lane_op(VECTOR, moves=True)
def object_space_normal(lanes: Any) -> Float32:
    """The shading normal in object space."""
    to_object = getattr(lanes, "to_object_normal", None)
    return lanes.ns if to_object is None else vectors.normalize(to_object(lanes.ns))


@lane_op(VECTOR)
def mirrored_view(lanes: Any, in_world: bool) -> Float32:
    """Texture Coordinate's Reflection: wi mirrored about the normal; in a world the ray itself."""
    return lanes.wi if in_world else vectors.reflect(lanes.wi, lanes.ns)


@lane_op(VECTOR, moves=True)
def parametric(lanes: Any) -> Float32:
    """Barycentric weights of the first two corners."""
    uv = lanes.barycentric()
    return np.stack([1 - uv[0] - uv[1], uv[0], np.zeros_like(uv[0])])


@lane_op(FLOAT)
def backfacing(lanes: Any) -> Float32:
    """1 behind the face."""
    return lanes.backfacing  # type: ignore[no-any-return]


@lane_op(FLOAT, reads="ray_kind")
def is_ray_kind(lanes: Any, bit: int) -> Float32:
    """1 for rays of a kind."""
    return ((lanes.ray_kind & bit) != 0).astype(np.float32)  # type: ignore[no-any-return]


@lane_op(FLOAT)
def ray_length(lanes: Any) -> Float32:
    """From the ray's origin to here."""
    return lanes.ray_length  # type: ignore[no-any-return]


@lane_op(FLOAT, reads="depth")
def ray_depth(lanes: Any) -> Float32:
    """Bounces so far; a shadow ray is one bounce further, as in Cycles."""
    depth = lanes.depth + ((lanes.ray_kind & RayKind.SHADOW) != 0)
    return depth.astype(np.float32)  # type: ignore[no-any-return]


@lane_op(FLOAT, reads="transparent_depth")
def transparent_depth(lanes: Any) -> Float32:
    """Transparent surfaces passed so far."""
    return lanes.transparent_depth.astype(np.float32)  # type: ignore[no-any-return]


@lane_op(VECTOR, reads="object")
def object_location(lanes: Any) -> Float32:
    """World location of the object's origin."""
    return lanes.object_location()  # type: ignore[no-any-return]


@lane_op(COLOR, FLOAT, reads="object")
def object_color(lanes: Any) -> tuple[Float32, Float32]:
    """The object's colour and alpha."""
    rgba = lanes.object_color()
    return rgba[:3], rgba[3]


@lane_op(FLOAT, reads="object")
def object_index(lanes: Any) -> Float32:
    """Pass index."""
    return lanes.object_index()  # type: ignore[no-any-return]


@lane_op(FLOAT, reads="object")
def object_random(lanes: Any) -> Float32:
    """Random number of the object."""
    return lanes.object_random()  # type: ignore[no-any-return]


@lane_op(VECTOR, reads="generated")
def around_axis(lanes: Any, axis: str) -> Float32:
    """Unit tangent that runs around an axis of the Generated box: Cycles' default tangent is around Z."""
    x, y, z = lanes.generated() - np.float32(0.5)
    zero = np.zeros_like(x)
    around = {"X": (zero, -z, y), "Y": (-z, zero, x), "Z": (-y, x, zero)}[axis]
    return orthogonal_to(lanes.ns, lanes.to_world_normal(np.stack(around)))


@lane_op(VECTOR, reads=lambda name: (f"tangent:{name}", f"uv:{name}"))
def uv_tangent(lanes: Any, name: str) -> Float32:
    """Unit tangent along growing u."""
    tangent, _ = lanes.tangent(name)
    return orthogonal_to(lanes.ns, tangent)


def orthogonal_to(normal: Float32, tangent: Float32) -> Float32:
    """The part of `tangent` in the plane of `normal`, unit length."""
    return vectors.cross(normal, vectors.normalize(vectors.cross(tangent, normal)))


# ------------------------------------------------------------------ nodes


def coordinates(n: NodeView, default: Op = generated, static: tuple[Any, ...] = ()) -> Value:
    """A texture's Vector input; unlinked it has coordinates of its own. Then the old texture mapping."""
    linked = n.optional("Vector")
    vector = n.call(default, static=static) if linked is None else linked
    if n.node.props.get("texture_mapping"):
        from .vector_nodes import texture_mapping

        vector = texture_mapping(n, vector)
    return vector


@node("TexCoord")
def tex_coord(n: NodeView) -> Outputs:
    out: dict[str, Value | None] = {}
    wanted = n.reader.used.get(n.number, set())
    if n.prop("from_instancer", False):
        n.ignored("coordinates of the instancer are not known: zero")
        return {name: n.constant(0.0, VECTOR) for name in wanted}
    simple = {"Generated": generated, "Normal": object_space_normal}
    out.update({name: n.call(what) for name, what in simple.items() if name in wanted})
    if "UV" in wanted:
        out["UV"] = n.call(uv_coordinates, static=("",))
    if "Object" in wanted:
        matrix = n.prop("object_matrix", None)
        out["Object"] = (
            n.call(object_position)
            if matrix is None
            else n.call(transformed_position, static=tuple(float(x) for x in matrix))
        )
    if "Reflection" in wanted:
        out["Reflection"] = n.call(mirrored_view, static=(n.reader.world,))
    for name in wanted & {"Camera", "Window"}:
        n.ignored(f"{name} coordinates are not known: zero")
        out[name] = n.constant(0.0, VECTOR)
    return out


@node("UVMap")
def uv_map(n: NodeView) -> Outputs:
    if n.prop("from_instancer", False):
        n.ignored("the instancer's uv map is not known: zero")
        return {"UV": n.constant(0.0, VECTOR)}
    return {"UV": n.call(uv_coordinates, static=(str(n.prop("uv_map", "")),))}


@node("NewGeometry")
def geometry(n: NodeView) -> Outputs:
    wanted = n.reader.used.get(n.number, set())
    table: dict[str, tuple[Op, tuple[Any, ...]]] = {
        "Position": (position, ()),
        "Normal": (shading_normal, ()),
        "Tangent": (around_axis, ("Z",)),
        "True Normal": (true_normal, ()),
        "Incoming": (incoming, ()),
        "Parametric": (parametric, ()),
        "Backfacing": (backfacing, ()),
    }
    out: dict[str, Value | None] = {
        name: n.call(what, static=static) for name, (what, static) in table.items() if name in wanted
    }
    if "Normal" in wanted and n.reader.surface_normal is not None:
        out["Normal"] = n.reader.surface_normal
    if n.reader.world:
        out["Tangent"] = n.constant(0.0, VECTOR)
    if "Pointiness" in wanted:
        n.ignored("Pointiness is not known: flat (0.5) everywhere")
        out["Pointiness"] = n.constant(0.5, FLOAT)
    if "Random Per Island" in wanted:
        n.ignored("Random Per Island is not known: 0 everywhere")
        out["Random Per Island"] = n.constant(0.0, FLOAT)
    return out


@node("ObjectInfo")
def object_info(n: NodeView) -> Outputs:
    if n.wants("Material Index"):
        n.ignored("Material Index is not known: 0")
    out: dict[str, Value | None] = {"Material Index": n.constant(0.0, FLOAT)}
    if n.wants("Color") or n.wants("Alpha"):
        out["Color"], out["Alpha"] = n.calls(object_color)
    table = {"Location": object_location, "Object Index": object_index, "Random": object_random}
    out.update({name: n.call(what) for name, what in table.items() if n.wants(name)})
    return out


KINDS: Final = {
    "Is Camera Ray": RayKind.CAMERA,
    "Is Shadow Ray": RayKind.SHADOW,
    "Is Diffuse Ray": RayKind.DIFFUSE,
    "Is Glossy Ray": RayKind.GLOSSY,
    "Is Singular Ray": RayKind.SINGULAR,
    "Is Reflection Ray": RayKind.REFLECTION,
    "Is Transmission Ray": RayKind.TRANSMISSION,
}


@node("LightPath")
def light_path(n: NodeView) -> Outputs:
    wanted = n.reader.used.get(n.number, set())
    out: dict[str, Value | None] = {
        name: n.call(is_ray_kind, static=(bit,)) for name, bit in KINDS.items() if name in wanted
    }
    table = {"Ray Length": ray_length, "Ray Depth": ray_depth, "Transparent Depth": transparent_depth}
    out.update({name: n.call(what) for name, what in table.items() if name in wanted})
    for name in wanted & {"Diffuse Depth", "Glossy Depth", "Transmission Depth"}:
        n.approximate(f"{name} counts bounces of every kind")
        out[name] = n.call(ray_depth)
    for name in ("Is Volume Scatter Ray", "Portal Depth"):
        out[name] = n.constant(0.0, FLOAT)
    return out


@node("CameraData")
def camera_data(n: NodeView) -> Outputs:
    n.approximate("distance along the ray, also for rays that do not come from the camera")
    distance = n.call(ray_length)
    if n.wants("View Vector"):
        n.ignored("View Vector is not known: zero")
    return {
        "View Vector": n.constant(0.0, VECTOR),
        "View Z Depth": distance,
        "View Distance": distance,
    }


@node("Attribute")
def attribute(n: NodeView) -> Outputs:
    name = str(n.prop("attribute_name", ""))
    if n.prop("attribute_type", "GEOMETRY") != "GEOMETRY":
        n.ignored("attributes of objects, instancers and view layers are not known: 0")
        zero = n.constant(0.0, FLOAT)
        return {
            "Color": n.constant(0.0, COLOR),
            "Vector": n.constant(0.0, VECTOR),
            "Fac": zero,
            "Alpha": zero,
        }
    color, alpha = n.calls(color_attribute, static=(name,))
    # a mesh without the colour attribute gives 0, one without the uv map too: at most one is there
    vector = n.builder.add(n.builder.convert(color, VECTOR), n.call(uv_coordinates, static=(name,)))
    return {
        "Color": n.builder.convert(vector, COLOR),
        "Vector": vector,
        "Fac": n.builder.convert(vector, FLOAT),
        "Alpha": alpha,
    }


@node("VertexColor")
def vertex_color(n: NodeView) -> Outputs:
    color, alpha = n.calls(color_attribute, static=(str(n.prop("layer_name", "")),))
    return {"Color": color, "Alpha": alpha}


@node("Value")
def value_node(n: NodeView) -> Outputs:
    return {"Value": n.constant(n.prop("value", 0.0), FLOAT)}


@node("RGB")
def rgb_node(n: NodeView) -> Outputs:
    return {"Color": n.constant(n.prop("value", (0.5, 0.5, 0.5)), COLOR)}


@node("Tangent")
def tangent_node(n: NodeView) -> Outputs:
    if n.reader.world:
        return {"Tangent": n.constant(0.0, VECTOR)}
    if n.prop("direction_type", "RADIAL") == "UV_MAP":
        n.approximate("uv tangents are per triangle, not smoothed over vertices")
        return {"Tangent": n.call(uv_tangent, static=(str(n.prop("uv_map", "")),))}
    return {"Tangent": n.call(around_axis, static=(str(n.prop("axis", "Z")),))}


for _name, _outputs in {
    "ParticleInfo": {
        "Index": FLOAT,
        "Random": FLOAT,
        "Age": FLOAT,
        "Lifetime": FLOAT,
        "Location": VECTOR,
        "Size": FLOAT,
        "Velocity": VECTOR,
        "Angular Velocity": VECTOR,
    },
    "HairInfo": {
        "Is Strand": FLOAT,
        "Intercept": FLOAT,
        "Length": FLOAT,
        "Thickness": FLOAT,
        "Tangent Normal": VECTOR,
        "Random": FLOAT,
    },
    "PointInfo": {"Position": VECTOR, "Radius": FLOAT, "Random": FLOAT},
}.items():

    @node(_name)
    def _zeros(n: NodeView, outputs: dict[str, str] = _outputs) -> Outputs:
        if n.node.kind != "HairInfo" or any(n.wants(name) for name in outputs if name != "Is Strand"):
            n.ignored(f"{n.node.kind} is not known: 0")
        return {name: n.constant(0.0, kind) for name, kind in outputs.items()}
