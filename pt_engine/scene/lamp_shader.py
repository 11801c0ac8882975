"""A lamp whose node tree varies: its factor on the lamp's light, seen along rays.

What Cycles' nodes find on a lamp: Position and the object's coordinates of the point that shines; a Normal
that is a sphere's or an area's own, and toward the lit point for lamps without one; Incoming toward the lit
point; uv of the area, of the sphere by angles, of the spot's and the sun's cone projected; the distance as
Ray Length. The kind of the ray is not known there: all of Light Path's flags are 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.view import View
from ..emitters.area import lengths
from ..emitters.base import FAR, Lamp
from ..nodes.batch import Batch
from .no_surface import NoSurface
from .snapshot import LightData

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
PROBES = 512  # directions in which a lamp's mean factor is looked for
FAINTEST = 1e-3  # of what its brightest direction gives: its chance where the mean misses its beam


class LampShader:
    """The factor of one lamp's nodes.

    Parameters
    ----------
    batch : Batch
        The compiled node tree.
    data : LightData
    origin : (3,) float64
        What is subtracted from world positions.
    reach : float
        Distance at which the lamp is taken to light things, for its mean.
    view : View
        The camera's.

    Attributes
    ----------
    brightness : float
        Mean factor, by which the lamp is chosen.
    """

    def __init__(self, batch: Batch, data: LightData, origin: Float64, reach: float, view: View) -> None:
        self._batch, self.data, self.view = batch, data, view
        self._origin = origin.astype(np.float32)[:, None]
        self.lamp = Lamp(data, np.ones(3), np.asarray(data.matrix, np.float64)[:3, 3] - origin)
        self.centre = self.lamp.centre.astype(np.float32)[:, None]
        self.axis = self.lamp.direction.astype(np.float32)[:, None]
        linear = self.lamp.linear
        self.linear = linear.astype(np.float32)
        self.inverse = np.linalg.pinv(linear).astype(np.float32)
        self.brightness = self._mean(reach)

    def factor(self, p: Float32, wo: Float32) -> Float32:
        """(3, n) for light that reaches points p (3, n) from directions wo (3, n)."""
        value = self._batch.emission(LampLanes(self, p, wo, self._origin))
        if value is None:
            return np.zeros((3, 1), np.float32)
        return value

    def distance(self, p: Float32, wo: Float32) -> Float32:
        """(n,) along `wo` to the lamp's surface, finite also where it is missed; FAR for suns."""
        data, to_centre = self.data, self.centre - p
        if data.kind == "SUN":
            return np.full(p.shape[1], np.float32(FAR))
        squared, along = vectors.dot(to_centre, to_centre), vectors.dot(to_centre, wo)
        t: Float32 = np.sqrt(squared)
        with np.errstate(all="ignore"):
            if data.kind == "AREA":
                t = vectors.dot(to_centre, self.axis) / vectors.dot(wo, self.axis)
            elif data.radius > 0.0 and data.soft_falloff:
                t = squared / along
            elif data.radius > 0.0:
                off = to_centre - along * wo
                root = np.sqrt(np.maximum(np.float32(data.radius**2) - vectors.dot(off, off), 0))
                t = along + root * np.where(squared <= data.radius**2, np.float32(1), np.float32(-1))
        return np.nan_to_num(t, nan=0.0, posinf=0.0, neginf=0.0)

    def _mean(self, reach: float) -> float:
        """Over places evenly around the lamp, or in front of an area."""
        k = np.arange(PROBES)
        z, turn = 1 - (2 * k + 1) / PROBES, k * np.pi * (3 - np.sqrt(5))  # Fibonacci's lattice
        side = np.sqrt(1 - z * z)
        d = np.stack([side * np.cos(turn), side * np.sin(turn), z]).astype(np.float32)
        if self.data.kind == "AREA":
            d *= np.copysign(np.float32(1), vectors.dot(d, self.axis))
        if self.data.kind == "SUN":
            d = np.repeat(self.axis, PROBES, axis=1)
        far = np.float32(max(reach, 2.0 * self.data.radius))
        value = np.abs(np.nan_to_num(self.factor(self.centre + far * d, -d), posinf=0.0, neginf=0.0))
        return max(float(value.mean(dtype=np.float64)), FAINTEST * float(value.max()), 1e-6)


class LampLanes(NoSurface):
    """Points on a lamp as its node tree sees them."""

    def __init__(self, shader: LampShader, p: Float32, wo: Float32, origin: Float32) -> None:
        self._shader, self.view = shader, shader.view
        self.n = wo.shape[1]
        t = shader.distance(p, wo)
        distant = shader.data.kind == "SUN"
        self.ray_length = t
        self.wi = -wo
        self.p: Float32 = self.wi - origin if distant else p + t * wo  # a sun's position is its direction
        self.position: Float32 = self.p + origin
        normal = self._normal(wo)
        self.backfacing = (vectors.dot(normal, self.wi) < 0).astype(np.float32)
        self.ns = self.ng = normal * (1 - 2 * self.backfacing)
        zero = np.zeros(self.n, np.int32)
        self.material = self.ray_kind = self.transparent_depth = zero
        self.depth = zero + 1

    def _normal(self, wo: Float32) -> Float32:
        """(3, n) unit, outward."""
        data = self._shader.data
        if data.kind == "AREA":
            return np.repeat(self._shader.axis, self.n, axis=1)
        if data.kind == "SUN" or data.radius <= 0.0 or data.soft_falloff:
            return -wo
        return vectors.normalize(self.p - self._shader.centre)

    def to_object_vector(self, w: Float32) -> Float32:
        """A direction along the lamp's own axes (unnormalised)."""
        m = self._shader.inverse
        return np.stack([m[k, 0] * w[0] + m[k, 1] * w[1] + m[k, 2] * w[2] for k in range(3)])

    def to_world_vector(self, w: Float32) -> Float32:
        """A direction from the lamp's own axes to the world's (unnormalised)."""
        m = self._shader.linear
        return np.stack([m[k, 0] * w[0] + m[k, 1] * w[1] + m[k, 2] * w[2] for k in range(3)])

    def to_object_normal(self, w: Float32) -> Float32:
        """A normal along the lamp's own axes (unnormalised)."""
        m = self._shader.linear
        return np.stack([m[0, k] * w[0] + m[1, k] * w[1] + m[2, k] * w[2] for k in range(3)])

    def to_world_normal(self, w: Float32) -> Float32:
        """A normal from the lamp's own axes to the world's (unnormalised)."""
        m = self._shader.inverse
        return np.stack([m[0, k] * w[0] + m[1, k] * w[1] + m[2, k] * w[2] for k in range(3)])

    def object_position(self) -> Float32:
        """(3, n) position along the lamp's own axes; of a sun, directions from where it stands."""
        return self.to_object_vector(self.p - self._shader.centre)

    generated = object_position

    def object_normal(self) -> Float32:
        """(3, n) the normal along the lamp's own axes."""
        return self.to_object_normal(self.ns)

    def uv(self, name: str) -> Float32:
        """(2, n): over the area; longitude and latitude of a sphere; across a cone."""
        data = self._shader.data
        if data.kind == "AREA":
            return self._on_area()
        if data.kind == "POINT":
            x, y, z = self.to_object_vector(self._normal(-self.wi))
            size = np.sqrt(x * x + y * y + z * z)
            u = np.float32(0.5) - np.arctan2(x, y) * np.float32(0.5 / np.pi)
            v = 1 - np.arccos(np.clip(z / (size + (size == 0)), -1, 1)) * np.float32(1 / np.pi)
            return np.stack([u * ((x != 0) | (y != 0)), v])
        if data.kind == "SPOT":
            x, y, z = self.to_object_vector(self.wi)
            z = -z * np.float32(2 * np.tan(0.5 * data.spot_size))
            z = z + (z == 0)
            return np.stack([x / z, y / z]) + np.float32(0.5)
        half = np.sin(0.25 * data.angle)
        away = vectors.length(-self.wi - self._shader.axis)
        scale = np.float32(0.5 / half if half > 0 else 0.0) / (away + (away == 0))
        place: Float32 = self.to_object_vector(-self.wi)[:2] * scale + np.float32(0.5)
        return place

    def _on_area(self) -> Float32:
        linear, size = self._shader.lamp.linear, lengths(self._shader.lamp)
        inplane = self.p - self._shader.centre
        out = np.empty((2, self.n), np.float32)
        for k in range(2):
            axis = linear[:, k] / max(float(np.sqrt((linear[:, k] ** 2).sum())), 1e-30)
            along = (axis / max(size[k], 1e-30)).astype(np.float32)[:, None]
            out[k] = np.clip(vectors.dot(inplane, along), -0.5, 0.5) + np.float32(0.5)
        return out

    def barycentric(self) -> Float32:
        """(2, n) so that Parametric, (1 − a − b, a), is the uv."""
        u, v = self.uv("")
        return np.stack([v, 1 - u - v])

    def depth_of(self, kind: str) -> NDArray[np.int32]:
        """Zero: the path is not known."""
        return np.zeros(self.n, np.int32)

    def object_location(self) -> Float32:
        """(3, n) of the lamp."""
        where = np.asarray(self._shader.data.matrix, np.float32)[:3, 3:]
        return np.repeat(where, self.n, axis=1)

    def object_color(self) -> Float32:
        """(4, n) of the lamp's object."""
        return np.repeat(np.array([self._shader.data.object_color], np.float32).T, self.n, axis=1)

    def object_index(self) -> Float32:
        """(n,) pass index."""
        return np.full(self.n, np.float32(self._shader.data.pass_index))

    def object_random(self) -> Float32:
        """(n,) the object's random number."""
        return np.full(self.n, np.float32(self._shader.data.random))
