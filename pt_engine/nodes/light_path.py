"""What a point knows of the ray that found it: Light Path."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..core.raykind import RayKind
from .graph import NodeView
from .ir import FLOAT, Call, Value, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]
BOUNCE_KIND = "bounce_kind"  # read by what depends on how the last surface has scattered


ANY_KIND = RayKind.CAMERA | RayKind.SHADOW


@lane_op(FLOAT, reads=lambda bit: ("ray_kind",) if bit & ANY_KIND else ("ray_kind", BOUNCE_KIND))
def is_ray_kind(lanes: Any, bit: int) -> Float32:
    """1 for rays of a kind."""
    return ((lanes.ray_kind & bit) != 0).astype(np.float32)  # type: ignore[no-any-return]


@lane_op(FLOAT)
def ray_length(lanes: Any) -> Float32:
    """From the last bounce to here."""
    return lanes.ray_length  # type: ignore[no-any-return]


@lane_op(FLOAT, reads="depth")
def ray_depth(lanes: Any) -> Float32:
    """Bounces so far; a shadow ray is one bounce further, as in Cycles."""
    depth = lanes.depth + ((lanes.ray_kind & RayKind.SHADOW) != 0)
    return depth.astype(np.float32)  # type: ignore[no-any-return]


@lane_op(FLOAT, reads=lambda kind: (f"{kind}_depth", BOUNCE_KIND))
def depth_of_kind(lanes: Any, kind: str) -> Float32:
    """Bounces of one kind so far."""
    return lanes.depth_of(kind).astype(np.float32)  # type: ignore[no-any-return]


@lane_op(FLOAT, reads="transparent_depth")
def transparent_depth(lanes: Any) -> Float32:
    """Transparent surfaces passed so far."""
    return lanes.transparent_depth.astype(np.float32)  # type: ignore[no-any-return]


def tells_shadow_rays(call: Call) -> bool:
    """Whether a call's result differs between shadow rays and others that go the same way."""
    return call.op is ray_depth or (call.op is is_ray_kind and bool(call.static[0] & RayKind.SHADOW))


KINDS: Final = {
    "Is Camera Ray": RayKind.CAMERA,
    "Is Shadow Ray": RayKind.SHADOW,
    "Is Diffuse Ray": RayKind.DIFFUSE,
    "Is Glossy Ray": RayKind.GLOSSY,
    "Is Singular Ray": RayKind.SINGULAR,
    "Is Reflection Ray": RayKind.REFLECTION,
    "Is Transmission Ray": RayKind.TRANSMISSION,
    "Is Volume Scatter Ray": RayKind.VOLUME,
}


@node("LightPath")
def light_path(n: NodeView) -> Outputs:
    wanted = n.reader.used.get(n.number, set())
    out: dict[str, Value | None] = {
        name: n.call(is_ray_kind, static=(bit,)) for name, bit in KINDS.items() if name in wanted
    }
    table = {"Ray Length": ray_length, "Ray Depth": ray_depth, "Transparent Depth": transparent_depth}
    out.update({name: n.call(what) for name, what in table.items() if name in wanted})
    for kind in ("Diffuse", "Glossy", "Transmission", "Portal"):
        if f"{kind} Depth" in wanted:
            out[f"{kind} Depth"] = n.call(depth_of_kind, static=(kind.lower(),))
    return out
