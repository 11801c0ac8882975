"""Panoramas: all directions around the eye, by Blender's projections.

In the basis forward, right, up, with u and v in [0, 1] across the image:

    EQUIRECTANGULAR       longitude and latitude linear in u and v
    FISHEYE_EQUIDISTANT   angle from the axis θ = r·fov/2,     r = 1 on the inscribed circle
    FISHEYE_EQUISOLID     θ = 2 asin(r / (2·lens)),            r in millimetres on the sensor
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import cross, normalize
from ..scene.snapshot import CameraData
from .base import Camera, CameraRays

Float32 = NDArray[np.float32]
Direction = tuple[Float32, Float32, Float32, NDArray[np.bool_]]  # right, up, forward; whether there is one


class Panoramic(Camera):
    """Clipped by distance from the eye; black where the image is outside the lens."""

    def rays(self, raster: Float32, u_lens: Float32 | None = None) -> CameraRays:
        u, v = self._plane(raster)
        right, up, forward, seen = PROJECTIONS[self.data.panorama](self.data, u, v)
        d = self._world(right, up, forward)
        o = self._eye + d * np.float32(self._near)
        if self._aperture is not None and u_lens is not None:
            o, d = self._through_lens(d, u_lens)
        return CameraRays(o, d, seen * np.float32(self._length) - ~seen)

    def _through_lens(self, d: Float32, u_lens: Float32) -> tuple[Float32, Float32]:
        """The lens stands across each ray; its rays meet at the focus distance from the eye."""
        if self._aperture is None:
            raise ValueError("a pinhole has no lens")
        lens = self._aperture.sample(u_lens)
        axis = self._basis[:, 2:3]
        across = normalize(axis - (axis * d).sum(axis=0) * d)
        on_lens = across * lens[0] + normalize(cross(d, across)) * lens[1]
        toward = normalize(d * np.float32(self._focus) - on_lens)
        o: Float32 = self._eye + on_lens + toward * np.float32(self._near)
        return o, toward


def equirectangular(data: CameraData, u: Float32, v: Float32) -> Direction:
    """Longitude to the right, latitude upward."""
    west, east, south, north = (np.float32(angle) for angle in data.sphere)
    longitude, latitude = west + u * (east - west), south + v * (north - south)
    c = np.cos(latitude)
    return c * np.sin(longitude), np.sin(latitude), c * np.cos(longitude), np.ones(u.shape, bool)


def equidistant(data: CameraData, u: Float32, v: Float32) -> Direction:
    """The whole field of view in the circle that fits the image."""
    x, y = 2 * u - 1, 2 * v - 1
    r = np.sqrt(x * x + y * y)
    return _around_axis(x, y, r, r * np.float32(data.fisheye[0] / 2), r <= 1)


def equisolid(data: CameraData, u: Float32, v: Float32) -> Direction:
    """As a lens of that focal length projects on that sensor, up to the field of view."""
    fov, lens, width, height = (float(x) for x in data.fisheye)
    x, y = (u - np.float32(0.5)) * np.float32(width), (v - np.float32(0.5)) * np.float32(height)
    r = np.sqrt(x * x + y * y)
    theta = 2 * np.arcsin(np.minimum(r / np.float32(2 * lens), 1))
    return _around_axis(x, y, r, theta, r <= np.float32(2 * lens * np.sin(fov / 4)))


def _around_axis(x: Float32, y: Float32, r: Float32, theta: Float32, seen: NDArray[np.bool_]) -> Direction:
    sine: Float32 = (np.sin(theta) / np.maximum(r, np.float32(1e-20))).astype(np.float32, copy=False)
    return x * sine, y * sine, np.cos(theta), seen


PROJECTIONS: dict[str, Callable[[CameraData, Float32, Float32], Direction]] = {
    "EQUIRECTANGULAR": equirectangular,
    "FISHEYE_EQUIDISTANT": equidistant,
    "FISHEYE_EQUISOLID": equisolid,
}
