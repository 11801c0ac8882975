"""Lanes as they were before displacement, for the displacement that is shaded as well as moved (BOTH)."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .moved import across

if TYPE_CHECKING:
    from .lanes import Lanes

Float32 = NDArray[np.float32]


def at_rest(lanes: Lanes, axis: int, width: float) -> Lanes:
    """The lanes on the undisplaced triangles, or (axis 1 or 2) one step of their footprint along.

    The step is made on the displaced face; its barycentrics carry it over.
    """
    si, scene = lanes.si, lanes.scene
    u, v = si.u, si.v
    if axis:
        du, dv = across(lanes, lanes.bump_steps(width)[axis - 1])
        u, v = u + du, v + dv
    there = copy.copy(si)
    there.moved_uv = (u, v)
    there.p = scene.transforms.point_to_world(lanes.faces.at(there, "rest"), si.instance)
    out = copy.copy(lanes)
    out.si, out.p, out.displaced = there, there.p, lanes
    out.__dict__["ns"] = _normal(lanes)
    return out


def rest_steps(lanes: Lanes, displaced: Lanes, width: float) -> tuple[Float32, Float32]:
    """What the undisplaced surface makes of two steps (3, n) along the displaced one."""
    _, e1, e2 = lanes.faces.spans("rest")
    along = [across(displaced, step) for step in displaced.bump_steps(width)]
    x, y = (lanes.to_world_vector(du * e1 + dv * e2) for du, dv in along)
    return x, y


def _normal(lanes: Lanes) -> Float32:
    """Unit shading normal of the undisplaced surface, on the viewer's side."""
    si, scene = lanes.si, lanes.scene
    if lanes.smooth:
        n = scene.layer("rest_normal", "").at(si.prim, si.instance, si.u, si.v)
    else:
        _, e1, e2 = lanes.faces.spans("rest")
        n = vectors.cross(e1, e2)
    n = lanes.to_world_normal(n)
    n *= 1 - 2 * lanes.backfacing
    return vectors.normalize(n)
