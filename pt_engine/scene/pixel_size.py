"""How large a pixel is at a place in the world: what dicing measures edges by.

As Cycles does, every place counts as if it lay straight ahead at its distance; out of view, pixels grow
with the distance to the view's sides, times `offscreen` − 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..cameras import make_camera
from .snapshot import CameraData

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]


def pixel_size(camera: CameraData, width: int, height: int, offscreen: float) -> Callable[[Float64], Float64]:
    """The function that gives the pixel size (n,), in metres, at world positions (n, 3)."""
    place = np.linalg.inv(np.asarray(camera.matrix, np.float64))
    step = pixel_step(camera, width, height)
    left, right, bottom, top = camera.frame

    def of_view(world: Float64) -> Float64:
        p = world @ place[:3, :3].T + place[:3, 3]
        p[:, 2] *= -1  # forward
        if camera.kind == "ORTHO":
            outside = beside_box(p, left, right, bottom, top)
            return np.asarray(step * (1 + outside * (offscreen - 1)))
        size = step * np.maximum(np.linalg.norm(p, axis=1), camera.clip[0])  # nothing nearer is seen
        if camera.kind == "PERSP" and offscreen > 1:
            size += step * (offscreen - 1) * beside_view(p, left, right, bottom, top)
        return np.asarray(size)

    return of_view


def pixel_step(camera: CameraData, width: int, height: int) -> float:
    """What one pixel adds to the ray of the image's centre: to its direction, or to its origin."""
    middle = np.array([[width / 2], [height / 2]])
    raster = (middle + np.array([[0, 1, 0], [0, 0, 1]])).astype(np.float32)
    at_zero = make_camera(camera, np.asarray(camera.matrix, np.float64)[:3, 3])
    rays = at_zero.at_resolution(width, height).rays(raster)
    ray = (rays.o if camera.kind == "ORTHO" else rays.d).astype(np.float64)
    centre, sides = rays.d[:, :1].astype(np.float64), ray[:, 1:] - ray[:, :1]
    across = sides - centre * (centre * sides).sum(axis=0)
    return float(np.sqrt((across * across).sum(axis=0)).min())


def beside_box(p: Float64, left: float, right: float, bottom: float, top: float) -> Float64:
    """How far points are out of an orthographic view, in units of its size."""
    c = p.clip([left, bottom, 0], [right, top, np.inf])
    return np.asarray(np.linalg.norm(p - c, axis=1) / np.sqrt((right * right + top * top) / 2))


def beside_view(p: Float64, left: float, right: float, bottom: float, top: float) -> Float64:
    """Distance of points to the pyramid of a perspective view; behind the eye that to the eye."""
    normals = np.array([(1, 0, -right), (-1, 0, left), (0, 1, -top), (0, -1, bottom)], np.float64)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    along = np.array([(right, 0, 1), (left, 0, 1), (0, top, 1), (0, bottom, 1)], np.float64)
    out = p @ normals.T
    beyond = p @ along.T >= 0
    far = np.linalg.norm(p, axis=1)
    side = np.where((out > 0) & beyond, out, 0).max(axis=1)
    past = ((out > 0) & ~beyond).any(axis=1)
    result = np.where(past, np.where(side > 0, np.minimum(side, far), far), side)
    return np.asarray(np.where((out > 0).all(axis=1), far, result))
