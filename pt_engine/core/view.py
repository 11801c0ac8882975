"""The world as a camera sees it: its space, and where in the image a point or a direction lies.

Camera space is Cycles': x to the right, y up, z forward; of a panorama x forward, y to the left, z up (of the
mirror ball y backward). The image is the full, uncropped frame, (0, 0) its lower left and (1, 1) its upper
right corner; see `cameras/panoramic.py` for the projections of panoramas.
"""

from __future__ import annotations

import copy
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]

# rows: the axes of camera space in right, up, forward
AXES = {
    "PERSP": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "PANO": [[0, 0, 1], [-1, 0, 0], [0, 1, 0]],
    "MIRRORBALL": [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
}
NEWTON_STEPS = 20


class View:
    """A camera's own space and image.

    Parameters
    ----------
    kind, panorama : str
        PERSP, ORTHO or PANO, and the projection of the last; see `CameraData`.
    matrix : (4, 4) float64
        Camera to world, without scale; it looks along −Z.
    frame : (4,) float
        Left, right, bottom, top of the image; see `CameraData`.
    polynomial : sequence of float
        Of FISHEYE_LENS_POLYNOMIAL.

    Attributes
    ----------
    pixels : (int, int)
        Width and height of the image.
    """

    pixels = (1, 1)

    def __init__(
        self,
        kind: str = "PERSP",
        matrix: Float64 | None = None,
        frame: tuple[float, float, float, float] = (-0.5, 0.5, -0.5, 0.5),
        panorama: str = "",
        polynomial: tuple[float, ...] = (),
    ) -> None:
        matrix = np.eye(4) if matrix is None else np.asarray(matrix, np.float64)
        self.kind, self.panorama, self._polynomial = kind, panorama, polynomial
        basis = (matrix[:3, :3] * [1.0, 1.0, -1.0]).T  # rows: right, up, forward
        own = panorama if panorama in AXES else kind
        self._axes = (np.array(AXES.get(own, AXES["PERSP"])) @ basis).astype(np.float32)
        self._basis = basis.astype(np.float32)
        self._eye = matrix[:3, 3, None]
        self._frame = frame

    def with_pixels(self, width: int, height: int) -> View:
        """The same view of an image of this size."""
        view = copy.copy(self)
        view.pixels = width, height
        return view

    def vector(self, w: Float32) -> Float32:
        """(3, N) world vectors in camera space."""
        return turned(self._axes, w)

    def point(self, p: Float32) -> Float32:
        """(3, N) world points in camera space."""
        return turned(self._axes, (p - self._eye).astype(np.float32))

    def vector_to_world(self, v: Float32) -> Float32:
        """(3, N) vectors of camera space in the world."""
        return turned(np.ascontiguousarray(self._axes.T), v)

    def point_to_world(self, v: Float32) -> Float32:
        """(3, N) points of camera space in the world."""
        world: Float32 = (self.vector_to_world(v) + self._eye).astype(np.float32)
        return world

    def image_of_point(self, p: Float32) -> Float32:
        """(2, N) where world points lie in the image."""
        return self._image(turned(self._basis, (p - self._eye).astype(np.float32)))

    def image_of_direction(self, d: Float32) -> Float32:
        """(2, N) where what lies at infinity in world directions is in the image; not for ORTHO."""
        return self._image(turned(self._basis, d))

    def _image(self, local: Float32) -> Float32:
        left, right, bottom, top = (np.float32(edge) for edge in self._frame)
        x, y = self._plane(*local)
        return np.stack([(x - left) / (right - left), (y - bottom) / (top - bottom)])

    def _plane(self, right: Float32, up: Float32, forward: Float32) -> tuple[Float32, Float32]:
        if self.kind == "ORTHO":
            return right, up
        if self.kind != "PANO":
            return right / forward, up / forward
        if self.panorama in STRAIGHT:
            return STRAIGHT[self.panorama](right, up, forward)
        across = np.sqrt(right * right + up * up)
        theta = np.arctan2(across, forward)
        radius = self._radius(theta) / (across + (across == 0))
        return right * radius, up * radius

    def _radius(self, theta: Float32) -> Float32:
        """From the centre of a fisheye's image to what lies at an angle from the axis."""
        if self.panorama == "FISHEYE_EQUIDISTANT":
            return theta
        if self.panorama != "FISHEYE_LENS_POLYNOMIAL":
            return 2 * np.sin(theta / 2)
        k = np.array(self._polynomial, np.float64)
        r = (-theta - k[0]) / k[1]
        for _ in range(NEWTON_STEPS):  # −θ = Σ kᵢ rⁱ
            r = r - (np.polyval(k[::-1], r) + theta) / np.polyval(np.polyder(k[::-1]), r)
        root: Float32 = r.astype(np.float32)
        return root


def turned(m: Float32, v: Float32) -> Float32:
    """M v; without a matrix product, which would round differently with the number of lanes."""
    x, y, z = v
    return np.stack([m[k, 0] * x + m[k, 1] * y + m[k, 2] * z for k in range(3)])


def equirectangular(right: Float32, up: Float32, forward: Float32) -> tuple[Float32, Float32]:
    """Longitude and latitude."""
    return np.arctan2(right, forward), np.arctan2(up, np.sqrt(right * right + forward * forward))


def cylindrical(right: Float32, up: Float32, forward: Float32) -> tuple[Float32, Float32]:
    """Longitude, and height over the radius."""
    across: Float32 = np.sqrt(right * right + forward * forward)
    return np.arctan2(right, forward), up / across


def cube_face(right: Float32, up: Float32, forward: Float32) -> tuple[Float32, Float32]:
    """Angles along the middle lines."""
    return np.arctan2(right, forward), np.arctan2(up, forward)


STRAIGHT: dict[str, Callable[[Float32, Float32, Float32], tuple[Float32, Float32]]] = {
    "EQUIRECTANGULAR": equirectangular,
    "CENTRAL_CYLINDRICAL": cylindrical,
    "EQUIANGULAR_CUBEMAP_FACE": cube_face,
}
