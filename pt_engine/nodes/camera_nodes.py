"""Where a point is, seen from the camera: Camera Data."""

from __future__ import annotations

from .graph import NodeView
from .ir import VECTOR
from .light_path import ray_length
from .registry import Outputs, node


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
