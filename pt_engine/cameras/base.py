"""What every camera is: the frame it stands in, and `rays`.

A camera looks along its local −Z with +Y up. Inside this package "forward" is positive: a point of the
image plane is (x, y, 1) in the basis right, up, forward.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene.snapshot import CameraData
from .thin_lens import Aperture

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]


class CameraRays(NamedTuple):
    """Rays that start on the near plane.

    Attributes
    ----------
    o, d : (3, N) float32
        Origin, in the recentred world, and unit direction.
    tfar : (N,) float32
        Distance from the origin to the far plane; there is no near limit, the origin is it.
    """

    o: Float32
    d: Float32
    tfar: Float32


class Camera(ABC):
    """A camera of one resolution.

    Parameters
    ----------
    data : CameraData
    origin : (3,) float64
        The world's point that the scene has as 0; subtracted in float64.
    resolution : (width, height)
        Of the full, uncropped image, the unit of `raster`. With (1, 1), `raster` is in [0, 1].
    """

    def __init__(self, data: CameraData, origin: Float64, resolution: tuple[float, float]) -> None:
        self.data, self.origin = data, np.asarray(origin, np.float64)
        self.resolution = resolution
        matrix = np.asarray(data.matrix, np.float64)
        axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
        self._basis = (axes * [1.0, 1.0, -1.0]).astype(np.float32)  # columns: right, up, forward
        self._eye = (matrix[:3, 3] - self.origin).astype(np.float32)[:, None]
        left, right, bottom, top = data.frame
        width, height = resolution
        self._corner = np.array([[left], [bottom]], np.float32)
        self._pixel = np.array([[(right - left) / width], [(top - bottom) / height]], np.float32)
        self._near, far = (float(c) for c in data.clip)
        self._length = max(far - self._near, 0.0)
        self._aperture = Aperture.of(data)
        self._focus = max(float(data.focus_distance), 1e-5)

    @property
    def has_lens(self) -> bool:
        """Whether `rays` needs points on a lens."""
        return self._aperture is not None

    def at_resolution(self, width: float, height: float) -> Camera:
        """The same camera, `raster` in pixels of an image of this size."""
        return type(self)(self.data, self.origin, (width, height))

    @abstractmethod
    def rays(self, raster: Float32, u_lens: Float32 | None = None) -> CameraRays:
        """Rays through points of the image.

        Parameters
        ----------
        raster : (2, N) float32
            x to the right and y up from the lower left corner of the full image, in pixels.
        u_lens : (2, N) float32 in [0, 1), or None
            Ignored without a lens; None means the centre of the lens.
        """

    def footprint(self, d: Float32) -> tuple[Float32, Float32]:
        """How wide a pixel's ray is where it starts, and how fast it widens: (N,) each.

        The mean length of what one pixel to the right and one up change of origin and direction, for rays
        from the lens' centre along `d`; this one for rays all around.
        """
        spread = np.full(d.shape[1], np.float32(2 * np.pi / self.resolution[0]))
        return spread * np.float32(self._near), spread

    def _plane(self, raster: Float32) -> Float32:
        """Points of `data.frame`: (2, N)."""
        plane: Float32 = raster * self._pixel + self._corner
        return plane

    def _world(self, x: Float32, y: Float32, z: Float32 | float) -> Float32:
        """Vector with these parts to the right, up and forward."""
        right, up, forward = (self._basis[:, i : i + 1] for i in range(3))
        world: Float32 = right * x
        world += up * y
        world += forward * z
        return world
