"""Vectors: Vector Math, Mapping, Vector Rotate, Vector Transform, Normal, Separate and Combine XYZ."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .graph import NodeView
from .ir import FLOAT, VECTOR, Op, Value, lane_op, op
from .math_nodes import divide, floored_modulo, power, round_half_up, select
from .registry import Outputs, node

Float32 = NDArray[np.float32]
SMALLEST_SCALE = 1e-5  # of a texture mapping that divides by it, as in Cycles


def stack(x: Float32, y: Float32, z: Float32) -> Float32:
    """Three numbers, each (n,) or (1,), as one vector."""
    return np.stack(np.broadcast_arrays(x, y, z))


def unit(a: Float32) -> Float32:
    """a/|a|, 0 for the zero vector."""
    size = vectors.length(a)
    return a / (size + (size == 0))  # type: ignore[no-any-return]


def truncated_modulo(a: Float32, b: Float32) -> Float32:
    """a − b·trunc(a/b), 0 where b is 0: what Cycles' vectors have, which rounds otherwise than C's fmod."""
    zero = b == 0
    return select(zero, np.float32(0), a - np.trunc(a / (b + zero)) * b)


def wrap_vector(value: Float32, high: Float32, low: Float32) -> Float32:
    """value moved into [low, high) by whole ranges; `low` is added last."""
    return floored_modulo(value - low, high - low) + low


def project(a: Float32, b: Float32) -> Float32:
    """a's part along b."""
    return divide(vectors.dot(a, b), vectors.dot(b, b)) * b


def refract(incident: Float32, normal: Float32, eta: Float32) -> Float32:
    """Refraction of an incident direction (GLSL's), 0 under total reflection."""
    c = vectors.dot(incident, normal)
    k = 1 - eta * eta * (1 - c * c)
    through = eta * incident - (eta * c + np.sqrt(np.maximum(k, 0))) * normal
    return through * (k >= 0)  # type: ignore[no-any-return]


VECTOR_MATH: dict[str, Callable[[Float32, Float32, Float32, Float32], Any]] = {
    "ADD": lambda a, b, c, s: a + b,
    "SUBTRACT": lambda a, b, c, s: a - b,
    "MULTIPLY": lambda a, b, c, s: a * b,
    "DIVIDE": lambda a, b, c, s: divide(a, b),
    "MULTIPLY_ADD": lambda a, b, c, s: a * b + c,
    "CROSS_PRODUCT": lambda a, b, c, s: vectors.cross(a, b),
    "PROJECT": lambda a, b, c, s: project(a, b),
    "REFLECT": lambda a, b, c, s: a - 2 * vectors.dot(unit(b), a) * unit(b),
    "REFRACT": lambda a, b, c, s: refract(a, unit(b), s),
    "FACEFORWARD": lambda a, b, c, s: a * select(vectors.dot(c, b) < 0, 1, -1),
    "DOT_PRODUCT": lambda a, b, c, s: vectors.dot(a, b),
    "DISTANCE": lambda a, b, c, s: vectors.length(a - b),
    "LENGTH": lambda a, b, c, s: vectors.length(a),
    "SCALE": lambda a, b, c, s: a * s,
    "NORMALIZE": lambda a, b, c, s: unit(a),
    "ABSOLUTE": lambda a, b, c, s: np.abs(a),
    "POWER": lambda a, b, c, s: power(a, b),
    "SIGN": lambda a, b, c, s: np.sign(a),
    "MINIMUM": lambda a, b, c, s: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c, s: np.maximum(a, b),
    "ROUND": lambda a, b, c, s: round_half_up(a),
    "FLOOR": lambda a, b, c, s: np.floor(a),
    "CEIL": lambda a, b, c, s: np.ceil(a),
    "FRACTION": lambda a, b, c, s: a - np.floor(a),
    "MODULO": lambda a, b, c, s: truncated_modulo(a, b),
    "WRAP": lambda a, b, c, s: wrap_vector(a, b, c),
    "SNAP": lambda a, b, c, s: np.floor(divide(a, b)) * b,
    "SINE": lambda a, b, c, s: np.sin(a),
    "COSINE": lambda a, b, c, s: np.cos(a),
    "TANGENT": lambda a, b, c, s: np.tan(a),
}
NUMBERS = {"DOT_PRODUCT", "DISTANCE", "LENGTH"}


@op(VECTOR)
def vector_math(operation: str, a: Float32, b: Float32, c: Float32, scale: Float32) -> Float32:
    """A Vector Math operation that gives a vector."""
    return VECTOR_MATH[operation](a, b, c, scale)  # type: ignore[no-any-return]


@op(FLOAT)
def vector_number(operation: str, a: Float32, b: Float32) -> Float32:
    """A Vector Math operation that gives a number."""
    return VECTOR_MATH[operation](a, b, b, b)  # type: ignore[no-any-return]


@node("VectorMath")
def vector_math_node(n: NodeView) -> Outputs:
    operation = str(n.prop("operation", "ADD"))
    a, b, c = (n.vector(name) for name in ("Vector", "Vector_001", "Vector_002"))
    zero = {"Vector": n.constant(0.0, VECTOR), "Value": n.constant(0.0, FLOAT)}
    if operation not in VECTOR_MATH:
        n.ignored(f"operation {operation} is not understood: 0")
        return zero
    if operation in NUMBERS:
        return zero | {"Value": n.call(vector_number, a, b, static=(operation,))}
    scale = n.float("Scale", 1.0)
    return zero | {"Vector": n.call(vector_math, a, b, c, scale, static=(operation,))}


# ------------------------------------------------------------------ separate, combine


def _separate(v: Float32) -> tuple[Float32, Float32, Float32]:
    """The components of a vector."""
    return v[0], v[1], v[2]


separate = Op(_separate, (FLOAT, FLOAT, FLOAT), splits=True)


@op(VECTOR)
def combine(x: Float32, y: Float32, z: Float32) -> Float32:
    """A vector of three numbers."""
    return stack(x, y, z)


@node("SeparateXYZ")
def separate_xyz(n: NodeView) -> Outputs:
    return dict(zip("XYZ", n.calls(separate, n.vector("Vector")), strict=True))


@node("CombineXYZ")
def combine_xyz(n: NodeView) -> Outputs:
    return {"Vector": n.call(combine, n.float("X"), n.float("Y"), n.float("Z"))}


# ------------------------------------------------------------------ Mapping and rotations


Rows = tuple[tuple[Any, Any, Any], tuple[Any, Any, Any], tuple[Any, Any, Any]]


def euler(r: Float32) -> Rows:
    """Rows of the rotation about x, then y, then z by angles r (3, n)."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(r), np.sin(r)
    return (
        (cy * cz, sy * sx * cz - cx * sz, sy * cx * cz + sx * sz),
        (cy * sz, sy * sx * sz + cx * cz, sy * cx * sz - sx * cz),
        (-sy, cy * sx, cy * cx),
    )


def rotate(m: Rows, v: Float32) -> Float32:
    """m v."""
    return stack(*(row[0] * v[0] + row[1] * v[1] + row[2] * v[2] for row in m))


def rotate_back(m: Rows, v: Float32) -> Float32:
    """mᵀ v."""
    return stack(*(m[0][k] * v[0] + m[1][k] * v[1] + m[2][k] * v[2] for k in range(3)))


@op(VECTOR)
def mapping(
    kind: str, turned: bool, vector: Float32, location: Float32, rotation: Float32, scale: Float32
) -> Float32:
    """The Mapping node; `turned` False where the rotation is constantly 0."""
    if kind == "TEXTURE":
        moved = vector - location
        return divide(rotate_back(euler(rotation), moved) if turned else moved, scale)
    if kind == "NORMAL":
        scaled = divide(vector, scale)
        return unit(rotate(euler(rotation), scaled) if turned else scaled)
    scaled = vector * scale
    out = rotate(euler(rotation), scaled) if turned else scaled
    return out + location if kind == "POINT" else out


def mapped(n: NodeView, kind: str, vector: Value, location: Value, rotation: Value, scale: Value) -> Value:
    """A call of `mapping` that knows whether there is a rotation."""
    from .surface import is_zero

    return n.call(mapping, vector, location, rotation, scale, static=(kind, not is_zero(rotation)))


@node("Mapping")
def mapping_node(n: NodeView) -> Outputs:
    kind = str(n.prop("vector_type", "POINT"))
    inputs = n.vector("Vector"), n.vector("Location"), n.vector("Rotation"), n.vector("Scale", 1.0)
    return {"Vector": mapped(n, kind, *inputs)}


@op(VECTOR)
def pick_axes(axes: str, v: Float32) -> Float32:
    """Components by name; N is 0."""
    zero = np.zeros_like(v[0])
    return stack(*(zero if a == "N" else v["XYZ".index(a)] for a in axes))


def texture_mapping(n: NodeView, vector: Value) -> Value:
    """The texture mapping that old files carry inside a texture node."""
    settings = dict(n.node.props["texture_mapping"])  # type: ignore[call-overload]
    axes = "".join(
        {"NONE": "N"}.get(str(settings.get(f"mapping_{a}", a.upper())), str(settings.get(f"mapping_{a}")))
        for a in "xyz"
    )
    if axes != "XYZ":
        vector = n.call(pick_axes, vector, static=(axes,))
    kind = str(settings.get("vector_type", "POINT"))
    scale = settings.get("scale", (1.0, 1.0, 1.0))
    if kind in ("TEXTURE", "NORMAL"):
        scale = tuple(map(invertible, scale))
    parts = settings.get("translation", 0.0), settings.get("rotation", 0.0), scale
    return mapped(n, kind, vector, *(n.constant(part, VECTOR) for part in parts))


def invertible(scale: float) -> float:
    """A factor that can be divided by."""
    return scale if abs(scale) >= SMALLEST_SCALE else math.copysign(SMALLEST_SCALE, scale)


@op(VECTOR)
def rotate_about(vector: Float32, center: Float32, axis: Float32, angle: Float32) -> Float32:
    """Rotation by `angle` about `axis` through `center`; unchanged where the axis is 0."""
    size = vectors.length(axis)
    a = axis / (size + (size == 0))
    p = vector - center
    cos, sin = np.cos(angle), np.sin(angle)
    turned = p * cos + vectors.cross(a + 0 * p, p) * sin + a * vectors.dot(a, p) * (1 - cos) + center
    return select(size == 0, vector, turned)


@op(VECTOR)
def rotate_euler(invert: bool, vector: Float32, center: Float32, rotation: Float32) -> Float32:
    """Rotation by Euler angles about `center`."""
    turn = rotate_back if invert else rotate
    return turn(euler(rotation), vector - center) + center


@node("VectorRotate")
def vector_rotate_node(n: NodeView) -> Outputs:
    kind, invert = str(n.prop("rotation_type", "AXIS_ANGLE")), bool(n.prop("invert", False))
    vector, center = n.vector("Vector"), n.vector("Center")
    if kind == "EULER_XYZ":
        return {"Vector": n.call(rotate_euler, vector, center, n.vector("Rotation"), static=(invert,))}
    fixed = {"X_AXIS": (1, 0, 0), "Y_AXIS": (0, 1, 0), "Z_AXIS": (0, 0, 1)}
    axis = n.constant(fixed[kind], VECTOR) if kind in fixed else n.vector("Axis", (0, 0, 1))
    angle = n.float("Angle")
    if invert:
        angle = n.builder.multiply(angle, n.constant(-1.0, FLOAT))
    return {"Vector": n.call(rotate_about, vector, center, axis, angle)}


@lane_op(VECTOR, reads=lambda kind, *spaces: ("view",) if "CAMERA" in spaces else ())
def change_space(lanes: Any, kind: str, source: str, target: str, vector: Float32) -> Float32:
    """Between world, object and camera space, as a vector, a point or a normal, by way of the world."""
    v = np.ascontiguousarray(np.broadcast_to(vector, (3, lanes.n)))
    has_object = hasattr(lanes, "to_object_vector")  # a world has none
    if source == "CAMERA":
        v = lanes.view.point_to_world(v) if kind == "POINT" else lanes.view.vector_to_world(v)
    elif source == "OBJECT" and has_object:
        v = object_to_world(lanes, kind, v)
    if target == "CAMERA":
        v = lanes.view.point(v) if kind == "POINT" else lanes.view.vector(v)
    elif target == "OBJECT" and has_object:
        v = world_to_object(lanes, kind, v)
    converted = "CAMERA" in (source, target) or has_object
    return unit(v) if kind == "NORMAL" and converted else v


def object_to_world(lanes: Any, kind: str, v: Float32) -> Float32:
    """A vector, point or normal of the object in the world."""
    if kind == "NORMAL":
        return lanes.to_world_normal(v)  # type: ignore[no-any-return]
    turned: Float32 = lanes.to_world_vector(v)
    return turned + lanes.object_location() if kind == "POINT" else turned


def world_to_object(lanes: Any, kind: str, v: Float32) -> Float32:
    """A vector, point or normal of the world in the object."""
    if kind == "NORMAL":
        return lanes.to_object_normal(v)  # type: ignore[no-any-return]
    turned: Float32 = lanes.to_object_vector(v)
    if kind == "POINT":
        turned = turned + (lanes.object_position() - lanes.to_object_vector(lanes.position))
    return turned


@node("VectorTransform")
def vector_transform_node(n: NodeView) -> Outputs:
    source, target = str(n.prop("convert_from", "WORLD")), str(n.prop("convert_to", "OBJECT"))
    vector = n.vector("Vector", 0.5)
    if source == target:
        return {"Vector": vector}
    kind = str(n.prop("vector_type", "VECTOR"))
    return {"Vector": n.call(change_space, vector, static=(kind, source, target))}


@op(FLOAT)
def dot_of_units(v: Float32, direction: Float32) -> Float32:
    """Cosine between two vectors."""
    return vectors.dot(unit(direction), unit(v))


@op(VECTOR)
def normalized(v: Float32) -> Float32:
    """Unit length."""
    return unit(v)


@node("Normal")
def normal_node(n: NodeView) -> Outputs:
    direction = n.constant(n.prop("value", (0, 0, 1)), VECTOR)
    out = {"Normal": n.call(normalized, direction)}
    if n.wants("Dot"):
        out["Dot"] = n.call(dot_of_units, n.vector("Normal", (0, 0, 1)), direction)
    return out
