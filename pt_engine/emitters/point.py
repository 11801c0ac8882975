"""Point lamps: without size, as a sphere, or as a disk that faces the lit point (soft falloff).

With Φ the watts in the panel (kernel/light/point.h and PointLight::area of Cycles):

    no size    I = Φ / 4π  W/sr                         irradiance I·cosθ / d²
    sphere     L = Φ / (4π r² · π)  W·m⁻²·sr⁻¹          uniform in the cone it fills, 1 / 2π(1 − cosθmax)
    disk       the same L on a disk of radius r that always faces the lit point, pdf = t³ / (π r² d)

With *normalize* off the division by the area, 4π r² (or 4 without size), is left out. A lit point inside
the sphere sees it in every direction. Spots are these, times a beam (spot.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from ..core.frames import frame
from ..core.vectors import dot
from .base import NO_HITS, TINY, Draw, Float32, Float64, Hits, Index, Lamp, at, columns, of_met, one, scalars

TWO_PI = float(2.0 * np.pi)


SMALLEST = 1e-12  # m: the radiance of a smaller lamp, and squares of its size, leave float32's range


def has_size(lamp: Lamp) -> bool:
    """Whether the lamp is more than a point."""
    return lamp.data.radius >= SMALLEST


def strength_per_area(lamp: Lamp) -> Float64:
    """(3,) Radiance of a lamp with size; intensity of one without."""
    radius, normalize = lamp.data.radius, lamp.data.normalize
    if has_size(lamp):
        return lamp.strength / np.pi / (4.0 * np.pi * radius**2 if normalize else 1.0)
    if normalize:
        return lamp.strength / (4.0 * np.pi)
    return lamp.strength * (radius**2 if radius > 0.0 else 1.0 / np.pi)


class Points:
    """What the three share: centres, sizes, strengths."""

    delta: ClassVar[bool] = False

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        self._centre = columns([lamp.centre for lamp in lamps])
        strength = [strength_per_area(lamp) for lamp in lamps]
        self._strength = columns(strength)
        self._weight = columns([s / c for s, c in zip(strength, chance, strict=True)])
        self._chance = scalars(chance)
        self._radius_squared = scalars([lamp.data.radius**2 for lamp in lamps])


class DeltaPoints(Points):
    """Lamps without size."""

    delta = True

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """The one direction there is; nearer than 10⁻⁹ m counts as 10⁻⁹ m."""
        wo = at(self._centre, row) - p
        squared: Float32 = np.maximum(dot(wo, wo), 1e-18)
        inverse: Float32 = np.reciprocal(np.sqrt(squared))
        wo *= inverse
        falloff = inverse * inverse
        pdf = np.empty_like(squared)
        pdf[:] = at(self._chance, row)
        return Draw(wo, squared * inverse, at(self._weight, row) * falloff, pdf)

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """No ray meets a point."""
        return NO_HITS


class Cone(NamedTuple):
    """Directions that a sphere fills, from the lit point."""

    axis: Float32  # (3, n) unit, to the centre
    squared: Float32  # (n,) distance to the centre, squared
    inside: Float32  # (n,) 1 where the lit point is in the sphere, else 0
    one_minus_cos: Float32  # (n,) of the half angle; 2, all directions, inside


class SphereLamps(Points):
    """Lamps that are uniformly bright spheres."""

    def _cone(self, to_centre: Float32, radius_squared: Float32) -> Cone:
        """The cone; sin² / (1 + cos) for 1 − cos keeps the digits of the smallest ones."""
        squared: Float32 = np.maximum(dot(to_centre, to_centre), TINY)
        inside = (squared <= radius_squared).astype(np.float32)
        sin_squared: Float32 = np.minimum(radius_squared / squared, 1.0)
        cos: Float32 = np.sqrt(1.0 - sin_squared)
        one_minus_cos = sin_squared / (1.0 + cos) + inside
        distance: Float32 = np.sqrt(squared)
        axis = to_centre / distance
        axis[2] += squared <= TINY  # at the very centre any axis will do
        return Cone(axis, squared, inside, one_minus_cos)

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform directions in the cone of the sphere."""
        radius_squared = at(self._radius_squared, row)
        cone = self._cone(at(self._centre, row) - p, radius_squared)
        one_minus_cos = u * cone.one_minus_cos
        cos = 1.0 - one_minus_cos
        sin_squared = one_minus_cos * (2.0 - one_minus_cos)
        wo = around(cone.axis, cos, np.sqrt(sin_squared), v)
        half_chord = np.sqrt(np.maximum(radius_squared - cone.squared * sin_squared, 0.0))
        t = np.sqrt(cone.squared) * cos + (2.0 * cone.inside - 1.0) * half_chord
        solid: Float32 = TWO_PI * cone.one_minus_cos
        return Draw(wo, t, at(self._weight, row) * solid, at(self._chance, row) / solid)

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """The near side from outside, the far side from inside."""
        lanes, cone = self._meet(row, o, d, t)
        chance = of_met(self._chance, row, lanes)
        return Hits(lanes, of_met(self._strength, row, lanes), chance / (TWO_PI * cone.one_minus_cos))

    def _meet(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> tuple[Index, Cone]:
        """Lanes that meet the sphere before t, and its cone from their origins."""
        to_centre = one(self._centre, row) - o
        along = dot(to_centre, d)
        off = along * d
        np.subtract(to_centre, off, out=off)
        discriminant = dot(off, off)
        np.subtract(one(self._radius_squared, row), discriminant, out=discriminant)
        lanes = np.flatnonzero(discriminant >= 0.0)
        cone = self._cone(to_centre.take(lanes, axis=1), of_met(self._radius_squared, row, lanes))
        s = along.take(lanes) + (2.0 * cone.inside - 1.0) * np.sqrt(discriminant.take(lanes))
        keep = np.flatnonzero((s > 0.0) & (s < t.take(lanes)))
        return lanes.take(keep), Cone(*(a.take(keep, axis=-1) for a in cone))


class DiskLamps(Points):
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
        return Draw(wo, t, at(self._weight, row) * scale, pdf)

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """Where the ray crosses the plane through the centre that faces its origin."""
        to_centre = one(self._centre, row) - o
        squared = np.maximum(dot(to_centre, to_centre), 1e-18)
        distance = np.sqrt(squared)
        along = dot(to_centre, d)
        s = squared / np.maximum(along, 1e-6 * distance)
        off = s * d - to_centre
        seen = (dot(off, off) <= one(self._radius_squared, row)) & (along > 0.0) & (s < t)
        lanes = np.flatnonzero(seen)
        s = s.take(lanes)
        area = float(np.pi) * of_met(self._radius_squared, row, lanes)
        pdf = of_met(self._chance, row, lanes) * (s * s * s) / (area * distance.take(lanes))
        return Hits(lanes, of_met(self._strength, row, lanes), pdf)


def around(axis: Float32, cos: Float32, sin: Float32, v: Float32) -> Float32:
    """(3, N) unit vectors at polar angle θ (`cos`, `sin`) from `axis`, turned about it by 2π·v."""
    s, t = frame(axis)
    phi = TWO_PI * v
    wo: Float32 = (sin * np.cos(phi)) * s
    wo += (sin * np.sin(phi)) * t
    wo += cos * axis
    return wo
