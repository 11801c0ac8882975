"""Panoramas: Blender's projections of all directions, θ from the axis or longitude λ and latitude φ.

`CameraData.frame` is given in the projection's own coordinates (x, y), r² = x² + y²:

    EQUIRECTANGULAR            x = λ,  y = φ
    CENTRAL_CYLINDRICAL        x = λ,  y = tan φ
    EQUIANGULAR_CUBEMAP_FACE   tan x, tan y are right and up at depth 1
    FISHEYE_EQUIDISTANT        r = θ
    FISHEYE_EQUISOLID          r = 2 sin(θ/2), lengths on the sensor over the focal length
    MIRRORBALL                 the same, seen to r = 2: a ball's normal stands at half the angle
    FISHEYE_LENS_POLYNOMIAL    θ = −(k₀ + k₁ r + k₂ r² + k₃ r³ + k₄ r⁴), r in millimetres
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import normalize
from ..scene.snapshot import CameraData
from .base import Camera, CameraRays
from .spherical_stereo import of_eye

Float32 = NDArray[np.float32]

DOWN = np.array([[0], [-1], [0]], np.float32)  # right, up, forward are left-handed: d × down is to the right


class Directions(NamedTuple):
    """Where points of an image look.

    Attributes
    ----------
    local : (3, N) float32
        Unit vectors: right, up, forward.
    seen : (N,) bool
        False outside of the image circle; `local` is arbitrary there.
    """

    local: Float32
    seen: NDArray[np.bool_]


class Panoramic(Camera):
    """Clipped by distance from the eye; a point of the image that sees nothing gets a ray that is off."""

    def rays(self, raster: Float32, u_lens: Float32 | None = None) -> CameraRays:
        project = PROJECTIONS.get(self.data.panorama, equirectangular)
        local, seen = project(self.data, *self._plane(raster))
        tfar = np.where(seen, np.float32(self._length), np.float32(-1))
        start: Float32 | None = None  # None: the eye
        if self._aperture is not None and u_lens is not None:
            start = self._on_lens(local, self._aperture.sample(u_lens))
            local = normalize(local * np.float32(self._focus) - start)
        if self.data.stereo is not None:
            offset, local = of_eye(self.data.stereo, local, DOWN)
            start = offset if start is None else start + offset
        d = self._world(*local)
        o = self._eye + d * np.float32(self._near)
        return CameraRays(o if start is None else o + self._world(*start), d, tfar)

    def _on_lens(self, local: Float32, lens: Float32) -> Float32:
        """Points of an aperture that faces each direction d.

        Its x-axis points to Cycles' own first axis a, forward (right for the mirror ball):

            a − (a·d) d  =  (−a p/s, −a q/s, s) s         d = (p, q, a), s² = p² + q²
        """
        order = [2, 1, 0] if self.data.panorama == "MIRRORBALL" else [0, 1, 2]
        p, q, a = local[order]
        s = np.sqrt(p * p + q * q)
        inverse = 1 / np.maximum(s, np.float32(1e-20))  # on the axis itself: the lens' centre
        p, q = p * inverse, q * inverse
        x, y = lens
        return np.stack([-a * p * x - q * y, -a * q * x + p * y, s * x])[order]


def equirectangular(_: CameraData, x: Float32, y: Float32) -> Directions:
    """A full turn or part of it; the poles are lines."""
    c = np.cos(y)
    return everywhere(np.stack([c * np.sin(x), np.sin(y), c * np.cos(x)]))


def central_cylindrical(_: CameraData, x: Float32, y: Float32) -> Directions:
    """The inside of a cylinder, unrolled."""
    return everywhere(normalize(np.stack([np.sin(x), y, np.cos(x)])))


def cube_face(_: CameraData, x: Float32, y: Float32) -> Directions:
    """One side of a cube, equal steps of angle along its middle lines."""
    return everywhere(normalize(np.stack([np.tan(x), np.tan(y), np.ones_like(x)])))


def equidistant(data: CameraData, x: Float32, y: Float32) -> Directions:
    """Equal steps of angle from the axis."""
    r = np.sqrt(x * x + y * y)
    return Directions(around_axis(x, y, r, r), r <= data.fisheye_fov / 2)


def equisolid(data: CameraData, x: Float32, y: Float32) -> Directions:
    """Equal areas see equal solid angles."""
    r = np.sqrt(x * x + y * y)
    theta = 2 * np.arcsin(np.minimum(r / 2, 1))
    return Directions(around_axis(x, y, r, theta), r <= 2 * float(np.sin(data.fisheye_fov / 4)))


def lens_polynomial(data: CameraData, x: Float32, y: Float32) -> Directions:
    """A measured lens."""
    r = np.sqrt(x * x + y * y)
    theta = np.zeros_like(r)
    for k in reversed(data.fisheye_polynomial):
        theta = theta * r - np.float32(k)
    return Directions(around_axis(x, y, r, theta), np.abs(theta) <= data.fisheye_fov / 2)


def everywhere(local: Float32) -> Directions:
    """Directions of an image without an edge."""
    return Directions(local, np.ones(local.shape[1], bool))


def around_axis(x: Float32, y: Float32, r: Float32, theta: Float32) -> Float32:
    """Unit vectors at an angle from the axis, toward (x, y); in the very centre, where that is 0, upward."""
    centre = r == 0
    sine = np.sin(theta) / (r + centre)
    return np.stack([x * sine, (y + centre) * sine, np.cos(theta)])


PROJECTIONS: dict[str, Callable[[CameraData, Float32, Float32], Directions]] = {
    "EQUIRECTANGULAR": equirectangular,
    "EQUIANGULAR_CUBEMAP_FACE": cube_face,
    "MIRRORBALL": equisolid,
    "FISHEYE_EQUIDISTANT": equidistant,
    "FISHEYE_EQUISOLID": equisolid,
    "FISHEYE_LENS_POLYNOMIAL": lens_polynomial,
    "CENTRAL_CYLINDRICAL": central_cylindrical,
}
