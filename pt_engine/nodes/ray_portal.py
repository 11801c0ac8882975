"""Ray Portal: rays that meet the surface leave elsewhere, in another direction."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .graph import NodeView
from .ir import VECTOR, Value, lane_op
from .registry import shader
from .surface import SurfaceBuilder

Float32 = NDArray[np.float32]
PORTAL = "ray_portal"


@lane_op(VECTOR)
def outward(lanes: Any, direction: Float32) -> Float32:
    """A direction at unit length; straight on where it is zero."""
    given = vectors.dot(direction, direction) > 0
    away = -lanes.wi
    return vectors.normalize(away + (direction - away) * given)


@lane_op(VECTOR)
def world_axis(lanes: Any, axis: int) -> Float32:
    """One of the world's axes, for every lane."""
    return np.repeat(np.eye(3, dtype=np.float32)[:, axis : axis + 1], lanes.n, axis=1)


def lets_light_through(out: SurfaceBuilder) -> bool:
    """Add portals to what shadow rays see of a surface that is transparent too; whether there is such a mix.

    As in Cycles: a surface of portals alone, or with opaque closures, stops shadow rays, but once something
    of it is transparent they pass straight through the portal's share as well.
    """
    portals = [leaf for leaf in out.leaves if leaf.bsdf == PORTAL]
    if out.transparency is None or not portals:
        return False
    for leaf in portals:
        out.transparency = out.builder.add(out.transparency, leaf.weight)
    return True


@shader("BsdfRayPortal")
def ray_portal(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    """A portal, in the world's frame so that its direction needs no turning."""
    params, position = {"direction": n.call(outward, n.vector("Direction"))}, n.optional("Position")
    if position is not None:
        params["position"] = position
    normal, tangent = n.call(world_axis, static=(2,)), n.call(world_axis, static=(0,))
    weight = n.builder.multiply(weight, n.color("Color", 1.0))
    out.add(PORTAL, params, weight, normal, tangent, dirac=True)
