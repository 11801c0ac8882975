"""Nodes that look around: Ambient Occlusion, Bevel and Raycast."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .coordinates import position
from .graph import NodeView, shading_normal
from .ir import COLOR, FLOAT, VECTOR, Const, Op, Value, lane_op
from .registry import Outputs, node
from .surface import is_zero
from .vector_nodes import unit

Float32 = NDArray[np.float32]

GLOBAL_DISTANCE = 10.0  # metres: what a new world's ambient occlusion reaches


@lane_op(FLOAT, reads=lambda key, samples, inside, local: ("traced", *["own"] * local))
def ambient_occlusion(
    lanes: Any, key: int, samples: int, inside: bool, local: bool, distance: Float32, *normal: Float32
) -> Float32:
    """Share of the half space about the normal that is open within `distance`; 1 in the sky."""
    around = getattr(lanes, "open_share", None)
    if around is None:
        return np.ones(lanes.n, np.float32)
    n = unit(np.broadcast_to(normal[0], (3, lanes.n))) if normal else lanes.ns
    return around(-n if inside else n, distance, samples, local, key)  # type: ignore[no-any-return]


@node("AmbientOcclusion")
def ambient_occlusion_node(n: NodeView) -> Outputs:
    distance: Value = n.float("Distance", 1.0)
    normal = n.normal()
    if is_zero(distance):
        n.approximate("distance 0 is the world's: 10 is taken")
        distance = n.constant(GLOBAL_DISTANCE, FLOAT)
    static = (
        n.number,
        int(n.prop("samples", 16)),
        bool(n.prop("inside", False)),
        bool(n.prop("only_local", False)),
    )
    if n.reader.world or (isinstance(distance, Const) and distance.data[0] < 0):
        share: Value = n.builder.one
    else:
        extra = () if normal is None else (normal,)
        share = n.call(ambient_occlusion, distance, *extra, static=static)
    return {"AO": share, "Color": n.builder.multiply(n.color("Color", 1.0), n.builder.convert(share, COLOR))}


@lane_op(VECTOR, reads=lambda *_: ("traced", "own", "sharpness"))
def bevel(lanes: Any, key: int, samples: int, linked: bool, radius: Float32, *normals: Float32) -> Float32:
    """The normal of rounded edges; what they turn it by is added to a linked normal, the first of `normals`.

    The last of them is the surface's where displacement bends it.
    """
    surface = normals[-1] if len(normals) > linked else lanes.ns
    around = getattr(lanes, "bevelled", None)
    rounded = surface if around is None else around(radius, samples, key, surface)
    return unit(normals[0] + (rounded - surface)) if linked else rounded


@node("Bevel")
def bevel_node(n: NodeView) -> Outputs:
    radius, normal = n.float("Radius", 0.05), n.optional("Normal")
    if n.reader.world or is_zero(radius):
        return {"Normal": n.normal()}
    extra = () if normal is None else (normal,)
    static = (n.number, int(n.prop("samples", 4)), normal is not None)
    return {"Normal": n.call(bevel, radius, *extra, *n.bent(), static=static)}


@functools.cache
def raycast(count: int) -> Op:
    """The op that also gives `count` attributes of what is met."""

    def raycast(
        lanes: Any, local: bool, names: tuple[str, ...], at: Float32, toward: Float32, reach: Float32
    ) -> tuple[Float32, ...]:
        """Whether a ray meets something, whether that is the own object, how far, where, its normal, more."""
        reach = np.broadcast_to(reach, lanes.n)
        at, toward = (np.ascontiguousarray(np.broadcast_to(v, (3, lanes.n))) for v in (at, toward))
        cast = getattr(lanes, "raycast", None)
        met = None if cast is None else cast(at, toward, reach, local, names)
        if met is None:
            zero, nowhere = np.zeros(lanes.n, np.float32), np.zeros((3, lanes.n), np.float32)
            return (zero, zero, reach, nowhere, nowhere, *[nowhere] * count)
        return (*met[:5], *met.attributes)

    def reads(local: bool, names: tuple[str, ...]) -> tuple[str, ...]:
        return ("traced", *["own"] * local, *(f"attribute:{name}" for name in names))

    types = (FLOAT, FLOAT, FLOAT, VECTOR, VECTOR, *[VECTOR] * count)
    return lane_op(*types, moves=True, reads=reads)(raycast)


@node("Raycast")
def raycast_node(n: NodeView) -> Outputs:
    length, outputs = (
        n.float("Length", 1.0),
        ["Is Hit", "Self Hit", "Hit Distance", "Hit Position", "Hit Normal"],
    )
    if n.reader.world:
        zero = n.constant(0.0, VECTOR)
        return dict.fromkeys(outputs + sampled(n), zero) | {"Hit Distance": length}
    at, toward = n.optional("Position"), n.optional("Direction")
    at = n.call(position) if at is None else at
    if toward is None:
        toward = n.bent()[0] if n.bent() else n.call(shading_normal)
    names = tuple(str(n.node.inputs[f"Value_{k.removeprefix('Attribute_')}"]) for k in sampled(n))
    if names:
        n.approximate("attributes of other objects only where their own materials read them too")
    static = (bool(n.prop("only_local", False)), names)
    values = n.calls(raycast(len(names)), at, toward, length, static=static)
    return dict(zip(outputs + sampled(n), values, strict=True))


def sampled(n: NodeView) -> list[str]:
    """Those outputs of attributes that some link reads."""
    return sorted(name for name in n.reader.used.get(n.number, ()) if name.startswith("Attribute_"))
