"""What a point knows of the ray that found it: Light Path, Light Falloff."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..core.raykind import RayKind
from .graph import NodeView
from .ir import FLOAT, Value, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]


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


@node("LightFalloff")
def light_falloff(n: NodeView) -> Outputs:
    strength, smooth = n.float("Strength", 100.0), n.float("Smooth", 0.0)
    return {
        name: n.call(falloff, strength, smooth, static=(power,))
        for name, power in (("Quadratic", 0), ("Linear", 1), ("Constant", 2))
        if n.wants(name)
    }


@lane_op(FLOAT)
def falloff(lanes: Any, power: int, strength: Float32, smooth: Float32) -> Float32:
    """strength · dᵖ · d²/(smooth + d²), d the distance to the light."""
    d = lanes.ray_length
    out = strength * (d**power if power else 1)
    soft = smooth > 0
    return out * (soft * d * d + ~soft) / (soft * (smooth + d * d) + ~soft)  # type: ignore[no-any-return]
