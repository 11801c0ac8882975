"""Perspective: all rays pass through the eye, or through the lens about it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import dot, normalize
from .base import Camera, CameraRays
from .spherical_stereo import of_eye

Float32 = NDArray[np.float32]

WORLD_UP = np.array([[0], [0], [1]], np.float32)


class Perspective(Camera):
    """Clipped at planes of depth `near` and `far`.

    With a lens the cut is made where the ray through the lens' centre would meet the plane, as in Cycles: all
    rays of a raster point start and end at the same distances.
    """

    def footprint(self, d: Float32) -> tuple[Float32, Float32]:
        """Of the direction (x, y, 1)/s, a step w in x changes (w/s)·√(1 − (x/s)²)."""
        x, y, z = (dot(self._basis[:, i : i + 1], d) for i in range(3))  # x/s, y/s, 1/s
        z = np.maximum(z, np.float32(1e-6))
        width, height = np.abs(self._pixel[:, 0])
        spread = 0.5 * z * (width * np.sqrt(1 - x * x) + height * np.sqrt(1 - y * y))
        return spread * (np.float32(self._near) / z), spread

    def rays(self, raster: Float32, u_lens: Float32 | None = None) -> CameraRays:
        x, y = self._plane(raster)
        toward = self._world(x, y, 1.0)  # one unit deep
        slant = np.sqrt(x * x + y * y + 1.0)  # distance per depth
        if self.data.stereo is not None:
            return self._one_eye(toward, slant, u_lens)
        if self._aperture is None or u_lens is None:
            o = self._eye + toward * np.float32(self._near)
            return CameraRays(o, normalize(toward), slant * np.float32(self._length))
        on_lens, d = self._through_lens(toward, u_lens)
        o = self._eye + on_lens
        o += d * (slant * np.float32(self._near))
        return CameraRays(o, d, slant * np.float32(self._length))

    def _through_lens(self, toward: Float32, u_lens: Float32 | None) -> tuple[Float32, Float32]:
        """Points on the lens, from its centre, and directions from there to the plane in focus."""
        if self._aperture is None or u_lens is None:
            return np.zeros_like(toward), normalize(toward)
        lens = self._aperture.sample(u_lens)
        on_lens = self._world(lens[0], lens[1], 0.0)
        d = toward * np.float32(self._focus)
        d -= on_lens
        d *= np.reciprocal(np.sqrt(dot(d, d)))
        return on_lens, d

    def _one_eye(self, toward: Float32, slant: Float32, u_lens: Float32 | None) -> CameraRays:
        """Of a head that turns about the world's axis, as Cycles has it for perspective cameras."""
        if self.data.stereo is None:
            raise ValueError("this camera has no eyes")
        on_lens, d = self._through_lens(toward, u_lens)
        offset, d = of_eye(self.data.stereo, d, WORLD_UP)
        o = self._eye + on_lens + offset
        o += d * (slant * np.float32(self._near))
        return CameraRays(o, d, slant * np.float32(self._length))
