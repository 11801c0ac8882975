"""Wireframe: 1 near the edges of triangles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .graph import NodeView
from .ir import FLOAT, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]


@lane_op(FLOAT, moves=True, reads="position")
def near_edges(lanes: Any, in_pixels: bool, size: Float32) -> Float32:
    """Whether an edge is nearer than half the size, in the world or in units of the pixel's footprint.

    |e × w|² < |e|² (size/2)², w from a corner of edge e to the point.
    """
    reach = size * np.float32(0.5)
    if in_pixels:
        reach = reach * footprint(lanes)
    near = np.zeros(lanes.n, bool)
    for edge, toward in lanes.sides():
        across = vectors.cross(edge, toward)
        near |= vectors.dot(across, across) < vectors.dot(edge, edge) * reach * reach
    return near.astype(np.float32)


def footprint(lanes: Any) -> Float32:
    """(n,) how wide a pixel is at the point, seen along the ray: the mean over two directions of the face."""
    one, other = (step - vectors.dot(step, lanes.wi) * lanes.wi for step in lanes.bump_steps(1.0))
    width: Float32 = (vectors.length(one) + vectors.length(other)) * np.float32(0.5)
    return width


@node("Wireframe")
def wireframe_node(n: NodeView) -> Outputs:
    if n.reader.world:
        return {"Fac": n.constant(0.0, FLOAT)}
    in_pixels = bool(n.prop("use_pixel_size", False))
    if in_pixels:
        n.approximate("a pixel's footprint is the camera's, after bounces too")
    return {"Fac": n.call(near_edges, n.float("Size", 0.01), static=(in_pixels,))}
