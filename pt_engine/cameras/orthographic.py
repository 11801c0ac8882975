"""Orthographic: parallel rays, `frame` in metres; a lens blurs what is not at the focus distance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .base import Camera, CameraRays

Float32 = NDArray[np.float32]


class Orthographic(Camera):
    """A point at depth z becomes a disk of diameter 2 r |1 − z/f| in the image plane."""

    def footprint(self, d: Float32) -> tuple[Float32, Float32]:
        """A pixel everywhere."""
        n = d.shape[1]
        return np.full(n, np.abs(self._pixel).mean(), np.float32), np.zeros(n, np.float32)

    def rays(self, raster: Float32, u_lens: Float32 | None = None) -> CameraRays:
        x, y = self._plane(raster)
        tfar = np.full(x.shape, self._length, np.float32)
        if self._aperture is None or u_lens is None:
            o = self._world(x, y, self._near)
            o += self._eye
            return CameraRays(o, np.repeat(self._basis[:, 2:], x.size, axis=1), tfar)
        lens_x, lens_y = self._aperture.sample(u_lens)
        # Toward (0, 0, f) from the lens, then along it to the near plane.
        scale: Float32 = np.reciprocal(
            np.sqrt(lens_x * lens_x + lens_y * lens_y + np.float32(self._focus * self._focus))
        )
        d = self._world(-lens_x * scale, -lens_y * scale, np.float32(self._focus) * scale)
        rest = np.float32(1.0 - self._near / self._focus)
        o = self._world(x + lens_x * rest, y + lens_y * rest, self._near)
        o += self._eye
        return CameraRays(o, d, tfar)
