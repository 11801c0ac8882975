"""Point and spot lamps: without size, as a sphere, or as a disk that faces the lit point (soft falloff).

With Φ the watts in the panel (kernel/light/point.h and PointLight::area of Cycles):

    no size    I = Φ / 4π  W/sr                         irradiance I·cosθ / d²
    sphere     L = Φ / (4π r² · π)  W·m⁻²·sr⁻¹          uniform in the cone it fills, 1 / 2π(1 − cosθmax)
    disk       the same L on a disk of radius r that always faces the lit point, pdf = t³ / (π r² d)

With *normalize* off the division by the area, 4π r² (or 4 without size), is left out. A lit point inside
the sphere sees it in every direction. A spot multiplies by its beam (spot.py), except inside its sphere.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from ..core.frames import frame
from ..core.vectors import dot
from .base import TINY, Draw, Float32, Float64, Hits, Index, Lamp, at, columns, one, scalars
from .spot import Beam

TWO_PI = float(2.0 * np.pi)


def strength_per_area(lamp: Lamp) -> Float64:
    """(3,) Radiance of a lamp with size; intensity of one without."""
    radius = lamp.data.radius
    area = 4.0 * np.pi * radius**2 if radius > 0.0 else 4.0
    return lamp.strength / np.pi / (area if lamp.data.normalize else 1.0)


class _Points:
    """What the three share: centres, strengths over chance, and the beam of spots."""

    delta: ClassVar[bool] = False

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        self._centre = columns([lamp.centre for lamp in lamps])
        strength = [strength_per_area(lamp) for lamp in lamps]
        self._strength = columns(strength)
        self._weight = columns([s / c for s, c in zip(strength, chance, strict=True)])
        self._chance = scalars(chance)
        self._radius_squared = scalars([lamp.data.radius**2 for lamp in lamps])
        self._beam = Beam(lamps) if lamps[0].data.kind == "SPOT" else None


class DeltaPoints(_Points):
    """Lamps without size."""

    delta = True

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """The one direction there is; nearer than 10⁻⁹ m counts as 10⁻⁹ m."""
        wo = at(self._centre, row) - p
        squared = np.maximum(dot(wo, wo), 1e-18)
        inverse = 1.0 / np.sqrt(squared)
        wo *= inverse
        falloff = inverse * inverse
        if self._beam is not None:
            falloff *= self._beam(row, wo)
        pdf = np.empty_like(squared)
        pdf[:] = at(self._chance, row)
        return Draw(wo, squared * inverse, at(self._weight, row) * falloff, pdf)

    def hits(self, row: int, o: Float32, d: Float32, t: Float32) -> Hits:
        """No ray meets a point."""
        return Hits(np.empty(0, np.intp), np.empty((3, 0), np.float32), np.empty(0, np.float32))


def one_minus_cos_cap(sin_squared: Float32, inside: Float32) -> Float32:
    """1 − cosθmax of the cone that a sphere fills, sin²θmax given; the whole sphere (2) if `inside` is 1.

    sin² / (1 + cos) keeps its digits for the smallest cones.
    """
    return sin_squared / (1.0 + np.sqrt(1.0 - sin_squared)) + inside


class SphereLamps(_Points):
    """Lamps that are uniformly bright spheres."""

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform directions in the cone of the sphere (Shirley et al. 1996)."""
        axis = at(self._centre, row) - p
        squared = np.maximum(dot(axis, axis), TINY)
        radius_squared = at(self._radius_squared, row)
        inside = (squared <= radius_squared).astype(np.float32)
        one_minus_max = one_minus_cos_cap(np.minimum(radius_squared / squared, 1.0), inside)
        distance = np.sqrt(squared)
        axis /= distance
        axis[2] += squared <= TINY  # at the very centre any axis will do

        one_minus_cos = u * one_minus_max
        cos = 1.0 - one_minus_cos
        sin_squared = one_minus_cos * (2.0 - one_minus_cos)
        wo = around(axis, cos, np.sqrt(sin_squared), v)

        half_chord = np.sqrt(np.maximum(radius_squared - squared * sin_squared, 0.0))
        t = distance * cos + (2.0 * inside - 1.0) * half_chord
        cone = TWO_PI * one_minus_max
        scale = cone if self._beam is None else cone * np.maximum(self._beam(row, wo), inside)
        return Draw(wo, t, at(self._weight, row) * scale, at(self._chance, row) / cone)

    def hits(self, row: int, o: Float32, d: Float32, t: Float32) -> Hits:
        """The near side from outside, the far side from inside."""
        to_centre = one(self._centre, row) - o
        along = dot(to_centre, d)
        off = to_centre - along * d
        radius_squared = self._radius_squared[row]
        discriminant = radius_squared - dot(off, off)
        lanes = np.flatnonzero(discriminant >= 0.0)
        squared = np.maximum(dot(*(to_centre.take(lanes, axis=1),) * 2), TINY)
        inside = (squared <= radius_squared).astype(np.float32)
        s = along.take(lanes) + (2.0 * inside - 1.0) * np.sqrt(discriminant.take(lanes))
        keep = np.flatnonzero((s > 0.0) & (s < t.take(lanes)))
        lanes, squared, inside = lanes.take(keep), squared.take(keep), inside.take(keep)
        cone = TWO_PI * one_minus_cos_cap(np.minimum(radius_squared / squared, 1.0), inside)
        radiance = np.repeat(one(self._strength, row), lanes.size, axis=1)
        if self._beam is not None:
            rows = np.full(lanes.size, row, np.intp)
            radiance *= np.maximum(self._beam(rows, d.take(lanes, axis=1)), inside)
        return Hits(lanes, radiance, self._chance[row] / cone)


class DiskLamps(_Points):
    """Lamps with soft falloff: a disk that faces whoever looks."""

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        super().__init__(lamps, chance)
        self._radius = np.sqrt(self._radius_squared)

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform in the area of the disk."""
        axis = at(self._centre, row) - p
        squared = np.maximum(dot(axis, axis), 1e-18)
        distance = np.sqrt(squared)
        axis /= distance
        off = at(self._radius, row) * np.sqrt(u)
        t_squared = squared + off * off
        t = np.sqrt(t_squared)
        wo = around(axis, distance / t, off / t, v)
        per_area = distance / (t_squared * t)  # cos / t²
        area = np.pi * at(self._radius_squared, row)
        scale = area * per_area
        pdf = at(self._chance, row) / scale
        if self._beam is not None:
            scale *= self._beam(row, wo)
        return Draw(wo, t, at(self._weight, row) * scale, pdf)

    def hits(self, row: int, o: Float32, d: Float32, t: Float32) -> Hits:
        """Where the ray crosses the plane through the centre that faces its origin."""
        to_centre = one(self._centre, row) - o
        squared = np.maximum(dot(to_centre, to_centre), 1e-18)
        distance = np.sqrt(squared)
        along = dot(to_centre, d)
        s = squared / np.maximum(along, 1e-6 * distance)
        off = s * d - to_centre
        seen = (dot(off, off) <= self._radius_squared[row]) & (along > 0.0) & (s < t)
        lanes = np.flatnonzero(seen)
        s = s.take(lanes)
        area = float(np.pi) * self._radius_squared[row]
        pdf = self._chance[row] * (s * s * s) / (area * distance.take(lanes))
        radiance = np.repeat(one(self._strength, row), lanes.size, axis=1)
        if self._beam is not None:
            radiance *= self._beam(np.full(lanes.size, row, np.intp), d.take(lanes, axis=1))
        return Hits(lanes, radiance, pdf)


def around(axis: Float32, cos: Float32, sin: Float32, v: Float32) -> Float32:
    """(3, N) unit vectors at polar angle θ (`cos`, `sin`) from `axis`, turned about it by 2π·v."""
    s, t = frame(axis)
    phi = TWO_PI * v
    return cos * axis + (sin * np.cos(phi)) * s + (sin * np.sin(phi)) * t
