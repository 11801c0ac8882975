"""Where a point is, seen from the camera: Camera Data, and Texture Coordinate's Camera and Window."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .graph import NodeView
from .ir import FLOAT, REST, VECTOR, Value, lane_op, op, shift_of
from .registry import Outputs, node

Float32 = NDArray[np.float32]


@lane_op(VECTOR, moves=True, reads="view")
def camera_position(lanes: Any, in_world: bool) -> Float32:
    """The point in camera space; what is infinitely far is a direction."""
    view = lanes.view
    return view.vector(lanes.position) if in_world else view.point(lanes.position)  # type: ignore[no-any-return]


@lane_op(VECTOR, reads="view")
def window(lanes: Any, in_world: bool, axis: int = 0, width: float = 0.0) -> Float32:
    """(u, v, 0) in the image, [0, 1] from its lower left corner; or `width` pixels along axis 1 or 2."""
    out = np.zeros((3, lanes.n), np.float32)
    out[:2] = lanes.window() if in_world else lanes.view.image_of_point(lanes.position)
    if axis:
        out[axis - 1] += np.float32(width / lanes.view.pixels[axis - 1])
    return out


def window_coordinates(n: NodeView) -> Value:
    """Texture Coordinate's Window. Bump's steps in it are pixels, however the face lies, as in Cycles."""
    code, width = shift_of(n.shift)
    axis = code & ~REST
    return n.call(window, static=(n.reader.world, axis, width) if axis else (n.reader.world,))


@lane_op(VECTOR, reads="view")
def from_camera(lanes: Any) -> Float32:
    """The point in camera space. In a world it is the ray's direction taken as a point, as in Cycles."""
    return lanes.view.point(lanes.position)  # type: ignore[no-any-return]


@op(VECTOR, FLOAT, FLOAT)
def direction_depth_distance(v: Float32) -> tuple[Float32, Float32, Float32]:
    """Unit vector, depth along the view axis, length."""
    return vectors.normalize(v), v[2], vectors.length(v)


@node("CameraData")
def camera_data(n: NodeView) -> Outputs:
    values = n.calls(direction_depth_distance, n.call(from_camera))
    return dict(zip(("View Vector", "View Z Depth", "View Distance"), values, strict=True))
