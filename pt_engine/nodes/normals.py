"""Normal Map, Bump, and the normals that glossy closures may use."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.clock import stage
from .graph import GraphReader, NodeView
from .ir import VECTOR, Const, Value, lane_op, shift_code
from .registry import Outputs, node
from .surface import is_zero
from .vector_nodes import unit

Float32 = NDArray[np.float32]


# ------------------------------------------------------------------ Normal Map


@lane_op(VECTOR, reads=lambda name, flip: (f"tangent:{name}",))
def tangent_space_normal(
    lanes: Any, name: str, flip: bool, color: Float32, strength: Float32, *surface: Float32
) -> Float32:
    """A normal from a map in tangent space.

    x and y are scaled by the strength, z faded to 1, all in the frame (T, B, N) of the uv map; back
    faces see the whole frame turned around, as in Cycles. Where the map is missing the normal stays.
    """
    x, y, z = 2 * color - 1
    if flip:
        y = -y
    side = 1 - 2 * lanes.backfacing
    normal = lanes.frame_normal() if lanes.smooth else unit(lanes.to_object_normal(lanes.ng * side))
    tangent, sign = lanes.object_tangent(name)
    bitangent = sign * vectors.cross(normal, tangent)
    z = 1 + np.clip(strength, 0, 1) * (z - 1)
    out = (x * strength) * tangent + (y * strength) * bitangent + z * normal
    mapped = unit(lanes.to_world_normal(unit(out))) * (side * (sign != 0))
    return usable(mapped, surface[0] if surface else lanes.ns)


@lane_op(VECTOR)
def space_normal(
    lanes: Any, space: str, flip: bool, color: Float32, strength: Float32, *surface: Float32
) -> Float32:
    """A normal from a map in object or world space, blended with the shading normal by strength."""
    n = 2 * color - 1
    turned = np.array([1, -1 if flip != space.startswith("BLENDER") else 1, 1], np.float32)[:, None]
    if space.startswith("BLENDER"):
        turned[2] = -1
    n = np.ascontiguousarray(np.broadcast_to(n * turned, (3, lanes.n)))
    if space.endswith("OBJECT"):
        n = lanes.to_world_normal(n)
    n = unit(n) * (1 - 2 * lanes.backfacing)
    ns = surface[0] if surface else lanes.ns
    return usable(unit(ns + (n - ns) * np.maximum(strength, 0)), ns)


def usable(n: Float32, fallback: Float32) -> Float32:
    """n, or the fallback where n is zero or not finite."""
    size = vectors.dot(n, n)
    bad = np.flatnonzero(~(size > 0.25))
    if len(bad):
        n = n.copy()
        n[:, bad] = fallback[:, bad]
    return n


@node("NormalMap")
def normal_map_node(n: NodeView) -> Outputs:
    strength = n.float("Strength", 1.0)
    if is_zero(strength) or n.reader.world:
        return {"Normal": None}
    space, color = str(n.prop("space", "TANGENT")), n.color("Color", (0.5, 0.5, 1.0))
    flip = n.prop("convention", "OPENGL") == "DIRECTX"
    if space == "TANGENT":
        static = (str(n.prop("uv_map", "")), flip)
        return {"Normal": n.call(tangent_space_normal, color, strength, *n.bent(), static=static)}
    return {"Normal": n.call(space_normal, color, strength, *n.bent(), static=(space, flip))}


# ------------------------------------------------------------------ Bump


@lane_op(VECTOR, reads=lambda invert, width, rest: ("position", "footprint", *["rest"] * rest))
@stage("", "bump")
def bump(
    lanes: Any,
    invert: bool,
    width: float,
    rest: bool,
    height: Float32,
    height_x: Float32,
    height_y: Float32,
    strength: Float32,
    distance: Float32,
    *normal: Float32,
) -> Float32:
    """The normal of the surface raised by height · distance, mixed in by strength.

    N' = |det|·N − distance·sign(det)·(Δh_x R_x + Δh_y R_y), R_x = dy × N, R_y = N × dx, det = dx·R_x
    (Mikkelsen 2010, "Bump Mapping Unparametrized Surfaces on the GPU"), the steps `width` of the ray's width
    long. A negative width turns it round, as in Cycles.
    """
    n = normal[0] if normal else lanes.ns
    dx, dy = lanes.bump_steps(width)
    if rest:  # Cycles does this one in object space
        n, dx, dy = unit(lanes.to_object_normal(n)), lanes.to_object_vector(dx), lanes.to_object_vector(dy)
    rx, ry = vectors.cross(dy, n), vectors.cross(n, dx)
    det = vectors.dot(dx, rx)
    gradient = (height_x - height) * rx + (height_y - height) * ry
    scale = (-distance if invert else distance) * np.copysign(np.float32(1), det)
    bent = unit(np.abs(det) * n - scale * gradient) * np.float32(-1 if width < 0 else 1)
    s = np.maximum(strength, 0)
    out = unit(s * usable(bent, n) + (1 - s) * n)
    if rest:
        out, n = unit(lanes.to_world_normal(out)), lanes.ns
    return usable(out, n)


FILTER_WIDTH = float(np.float32(0.1))  # of a pixel: Bump's default, and what displacement is shaded with


def shifts(width: float) -> tuple[int, int, int]:
    """Where Bump wants the height: here and one step along each of the face's directions."""
    return 0, shift_code(1, width), shift_code(2, width)


def filter_width(n: NodeView) -> float:
    """The node's Filter Width; in the place of one that varies Cycles takes the socket's own value."""
    value = n.float("Filter Width", FILTER_WIDTH)
    return float(value.data[0] if isinstance(value, Const) else n.prop("filter_width", FILTER_WIDTH))


@node("Bump")
def bump_node(n: NodeView) -> Outputs:
    normal = n.normal()
    strength, distance = n.float("Strength", 1.0), n.float("Distance", 0.1)
    if n.linked("Height") is None or isinstance(n.float("Height"), Const) or n.reader.world:
        return {"Normal": normal}  # at whatever length it has, as in Cycles
    if is_zero(strength) or is_zero(distance):
        return {"Normal": None if normal is None else n.call(facing_normal, normal, *n.bent())}
    width = filter_width(n)
    if width == 0:
        return {"Normal": normal}
    heights: list[Value] = [n.shifted_float("Height", shift) for shift in shifts(width)]
    extra = () if normal is None else (normal,)
    static = (bool(n.prop("invert", False)), width, False)
    return {"Normal": n.call(bump, *heights, strength, distance, *extra, static=static)}


# ------------------------------------------------------------------ normals for closures


@lane_op(VECTOR)
def facing_normal(lanes: Any, normal: Float32, *surface: Float32) -> Float32:
    """A linked normal at unit length; the surface's where it is unusable."""
    return usable(unit(np.broadcast_to(normal, (3, lanes.n))), surface[0] if surface else lanes.ns)


def surface_normal(reader: GraphReader) -> Value | None:
    """The normal of closures that have none of their own, where displacement bends it."""
    bent = reader.surface_normal
    return None if bent is None else reader.builder.call(facing_normal, bent)[0]


def closure_normal(n: NodeView, name: str = "Normal") -> Value | None:
    """A closure's normal; None for the shading normal. The scene raises it where it mirrors into the face."""
    linked = n.normal(name)
    return None if linked is None else n.call(facing_normal, linked, *n.bent())
