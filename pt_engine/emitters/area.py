"""Area lamps: rectangles and ellipses that shine to one side, with or without spread.

With Φ the watts in the panel and A the area after scaling (kernel/light/area.h and AreaLight of Cycles):

    L = Φ / (π A)                                         (*normalize* off: Φ / π)
    L(θ) = L · max(tan α − tan θ, 0) / (tan α − α)        α half the spread, θ from the lamp's axis;
                                                          below α = 0.05 the series 3 (tan α − tan θ) / α³
    α = 0:  a parallel beam of irradiance Φ / A           (*normalize* off: Φ)

A lit point at height h over the lamp's plane sees only a circle of radius h·tan α about its foot, so only
there are samples drawn. Rectangles are sampled uniformly in solid angle (Ureña, Fajardo, King 2013,
"An Area-Preserving Parametrization for Spherical Rectangles") where they look large, and uniformly in area
where they look small or are seen edge-on, which there is as good and keeps its digits. Ellipses are sampled
uniformly in area.

All is computed in the lamp's own axes, from the lit point: the lamp fills x0..x1 × y0..y1 at height h.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import dot
from .base import FAR, NO_HITS, Draw, Float32, Float64, Hits, Index, Lamp, at, columns, scalars, unit

TWO_PI = float(2.0 * np.pi)
SMALL_SOLID_ANGLE = 0.01  # sr; below it rectangles are sampled by area
PARALLEL = 1e-4  # rad; a smaller half spread is a parallel beam
SMALLEST = 1e-15  # sr; densities stay below its reciprocal
LOWEST = 1e-12  # m; height of a lit point in the lamp's plane


def has_extent(lamp: Lamp) -> bool:
    """Whether the lamp has an area at all; without, Cycles lets it shine nothing."""
    return all(length > 0.0 for length in lengths(lamp))


def lengths(lamp: Lamp) -> tuple[float, float]:
    """Edge lengths, or diameters, after scaling."""
    x, y = lamp.data.size
    if lamp.data.shape in ("SQUARE", "DISK"):
        y = x
    scale = np.sqrt((lamp.linear**2).sum(axis=0))
    return float(abs(x) * scale[0]), float(abs(y) * scale[1])


def is_ellipse(lamp: Lamp) -> bool:
    """Whether the shape is round."""
    return lamp.data.shape in ("DISK", "ELLIPSE")


def area(lamp: Lamp) -> float:
    """In m², after scaling."""
    x, y = lengths(lamp)
    return x * y * (0.25 * float(np.pi) if is_ellipse(lamp) else 1.0)


def half_spread(lamp: Lamp) -> float:
    """α in radians; π/2 for none."""
    return 0.5 * min(max(lamp.data.spread, 0.0), float(np.pi))


def is_parallel(lamp: Lamp) -> bool:
    """Whether the spread is too small to be anything but a beam."""
    return half_spread(lamp) < PARALLEL


def has_spread(lamp: Lamp) -> bool:
    """Whether the spread narrows the light at all."""
    return half_spread(lamp) < 0.5 * float(np.pi) - 1e-6


def strength_per_area(lamp: Lamp) -> Float64:
    """(3,) Irradiance in a parallel beam; π times the radiance along the axis of any other but for spread."""
    return lamp.strength / (area(lamp) if lamp.data.normalize else 1.0)


class Axes(NamedTuple):
    """Centre and unit axes of lamps, z where they shine; (3, n), or (3, 1) to broadcast."""

    centre: Float32
    x: Float32
    y: Float32
    z: Float32


class Seen(NamedTuple):
    """Lamps from the lit point, in their axes: centre, height of the point, half-lengths; (n,) or (1,)."""

    x: Float32
    y: Float32
    height: Float32  # ≤ 0 behind the lamp
    half_x: Float32
    half_y: Float32


class _Areas:
    """What all area lamps share: axes and sizes, strength, spread."""

    delta: ClassVar[bool] = False

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        axis_z = [lamp.direction for lamp in lamps]
        axis_x = []
        for lamp, z in zip(lamps, axis_z, strict=True):
            x = lamp.linear[:, 0]
            axis_x.append(unit(x - (x * z).sum() * z, fallback=(1.0, 0.0, 0.0)))
        axis_y = [np.cross(z, x) for z, x in zip(axis_z, axis_x, strict=True)]
        centre = [lamp.centre for lamp in lamps]
        self._axes = Axes(columns(centre), columns(axis_x), columns(axis_y), columns(axis_z))
        size = np.array([lengths(lamp) for lamp in lamps])
        self._half_x, self._half_y = scalars(0.5 * size[:, 0]), scalars(0.5 * size[:, 1])
        radiance = [strength_per_area(lamp) / np.pi for lamp in lamps]
        self._radiance = columns(radiance)
        self._weight = columns([r / c for r, c in zip(radiance, chance, strict=True)])
        self._chance = scalars(chance)
        self._tan: Float32 | None = None
        self._narrow = self._chance
        if has_spread(lamps[0]):
            alpha = np.array([max(half_spread(lamp), PARALLEL) for lamp in lamps])
            tan = np.tan(alpha)
            self._tan = scalars(tan)
            wide = alpha > 0.05
            self._narrow = scalars(1.0 / (wide * (tan - alpha) + ~wide * alpha**3 / 3.0))

    def _lamps(self, row: Index | None) -> tuple[Axes, Float32, Float32]:
        """Axes and half-lengths of each lane's lamp."""
        return Axes(*(at(table, row) for table in self._axes)), at(self._half_x, row), at(self._half_y, row)

    def _dim(self, row: Index | None, tan: Float32, x: Float32, y: Float32, height: Float32) -> Float32:
        """How the spread changes the radiance toward (x, y) of the lamp's plane."""
        off: Float32 = np.sqrt(x * x + y * y)
        dim: Float32 = np.maximum((tan - off / height) * at(self._narrow, row), 0.0)
        return dim

    def _cross(self, row: int, o: Float32, d: Float32, t: Float32) -> Crossing:
        """Lanes that pass the lamp's plane from its bright side before `t`."""
        axes, half_x, half_y = self._lamps(np.array([row]))
        facing = -dot(d, axes.z)
        height = dot(o, axes.z) - dot(axes.centre, axes.z)
        front = np.flatnonzero((height > 0.0) & (height < np.minimum(t, FAR) * facing))
        to_centre, d = axes.centre - o.take(front, axis=1), d.take(front, axis=1)
        height = -dot(to_centre, axes.z)
        s: Float32 = height / facing.take(front)
        seen = Seen(dot(to_centre, axes.x), dot(to_centre, axes.y), height, half_x, half_y)
        return Crossing(front, seen, s * dot(d, axes.x), s * dot(d, axes.y), s)


class Crossing(NamedTuple):
    """Where rays cross a lamp's plane: lanes, the lamp as their origins see it, the place, the distance."""

    lanes: Index
    seen: Seen
    x: Float32
    y: Float32
    s: Float32

    def among(self, inside: NDArray[np.bool_]) -> Crossing:
        """Those that are `inside`."""
        keep = np.flatnonzero(inside)
        x, y, height, half_x, half_y = self.seen
        seen = Seen(x.take(keep), y.take(keep), height.take(keep), half_x, half_y)
        return Crossing(self.lanes.take(keep), seen, self.x.take(keep), self.y.take(keep), self.s.take(keep))


def see(axes: Axes, half_x: Float32, half_y: Float32, p: Float32) -> Seen:
    """Lamps from the points p."""
    to_centre = axes.centre - p
    return Seen(dot(to_centre, axes.x), dot(to_centre, axes.y), -dot(to_centre, axes.z), half_x, half_y)


def toward(axes: Axes, x: Float32, y: Float32, height: Float32, distance: Float32) -> Float32:
    """(3, n) unit world directions to (x, y) of the lamps' planes."""
    wo = x * axes.x
    wo += y * axes.y
    wo -= height * axes.z
    wo /= distance
    return wo


def above(omega: Float32) -> Float32:
    """Solid angles that can be divided by."""
    raised: Float32 = np.maximum(omega, SMALLEST)
    return raised


class Beams(_Areas):
    """Lamps whose spread is 0: parallel light from the lamp's shape."""

    delta = True

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """The one direction there is, where the foot of the lit point is within the shape."""
        axes, half_x, half_y = self._lamps(row)
        seen = see(axes, half_x, half_y, p)
        lit = self._within(seen.x / half_x, seen.y / half_y) & (seen.height > 0.0)
        wo, pdf = np.empty_like(p), np.empty_like(u)
        wo[:], pdf[:] = -axes.z, at(self._chance, row)
        weight: Float32 = float(np.pi) * at(self._weight, row) * lit.astype(np.float32)
        return Draw(wo, np.maximum(seen.height, 0.0), weight, pdf)

    def _within(self, x: Float32, y: Float32) -> NDArray[np.bool_]:
        """Whether a point is in the shape, in half-lengths."""
        return (np.abs(x) <= 1.0) & (np.abs(y) <= 1.0)

    def hits(self, row: int, o: Float32, d: Float32, t: Float32) -> Hits:
        """No ray has just that direction."""
        return NO_HITS


class RoundBeams(Beams):
    """The same from an ellipse."""

    def _within(self, x: Float32, y: Float32) -> NDArray[np.bool_]:
        return np.asarray(x * x + y * y <= 1.0)


class Rectangle(NamedTuple):
    """A rectangle x0..x1 × y0..y1 at height `height` over the lit point, and that squared; each (n,)."""

    x0: Float32
    x1: Float32
    y0: Float32
    y1: Float32
    height: Float32
    height_squared: Float32

    @property
    def area(self) -> Float32:
        """(n,) m²."""
        return (self.x1 - self.x0) * (self.y1 - self.y0)


def solid_angle(r: Rectangle) -> tuple[Float32, Float32]:
    """(n,) sr: four corners of atan(xy / h√(x² + y² + h²)), each with its sign; and what those at x0 add.

    The latter is the angle −γ₂ − γ₃ + π of Ureña et al., without their cancellation.
    """
    xx0, xx1 = r.x0 * r.x0 + r.height_squared, r.x1 * r.x1 + r.height_squared
    yy0, yy1 = r.y0 * r.y0, r.y1 * r.y1
    left: Float32 = np.arctan2(r.x0 * r.y1, r.height * np.sqrt(xx0 + yy1))
    left -= np.arctan2(r.x0 * r.y0, r.height * np.sqrt(xx0 + yy0))
    omega: Float32 = np.arctan2(r.x1 * r.y1, r.height * np.sqrt(xx1 + yy1))
    omega -= np.arctan2(r.x1 * r.y0, r.height * np.sqrt(xx1 + yy0))
    omega -= left
    return omega, left


def square_to_spherical_rectangle(r: Rectangle, u: Float32, v: Float32) -> tuple[Float32, Float32, Float32]:
    """x, y (n,) on the rectangle, uniform in its solid angle, which comes along (Ureña et al. 2013).

    With a = u·Ω + left, rᵢ = 1 / √(yᵢ² + h²), their c_u = sin a / √(…) written without dividing by sin a:

        x = h·sin a / √((y1·r1 − y0·r0·cos a)² − (h·r0·sin a)²)
    """
    omega, angle = solid_angle(r)
    angle += u * omega
    sin = np.sin(angle)
    r0: Float32 = np.reciprocal(np.sqrt(r.y0 * r.y0 + r.height_squared))
    part = r.y1 / np.sqrt(r.y1 * r.y1 + r.height_squared)
    part -= r.y0 * r0 * np.cos(angle)
    sin *= r.height
    r0 *= sin
    part *= part
    part -= r0 * r0
    sin /= np.sqrt(np.maximum(part, 1e-30))
    x: Float32 = np.minimum(np.maximum(sin, r.x0), r.x1)
    d2 = x * x
    d2 += r.height_squared
    h0 = r.y0 / np.sqrt(d2 + r.y0 * r.y0)
    hv = r.y1 / np.sqrt(d2 + r.y1 * r.y1)
    hv -= h0
    hv *= v
    hv += h0
    d2 /= np.maximum(1.0 - hv * hv, 1e-12)
    hv *= np.sqrt(d2)
    return x, np.minimum(np.maximum(hv, r.y0), r.y1), omega


class Rectangles(_Areas):
    """Squares and rectangles."""

    def _bright_part(self, tan: Float32 | None, seen: Seen) -> tuple[Rectangle, NDArray[np.bool_]]:
        """The part that shines on the lit point, and whether there is any; if not, something finite."""
        x0, x1 = seen.x - seen.half_x, seen.x + seen.half_x
        y0, y1 = seen.y - seen.half_y, seen.y + seen.half_y
        lit = seen.height > 0.0
        height = np.maximum(seen.height, LOWEST)
        if tan is not None:
            reach = height * tan
            x0, x1 = np.maximum(x0, -reach), np.minimum(x1, reach)
            y0, y1 = np.maximum(y0, -reach), np.minimum(y1, reach)
            lit &= (x1 > x0) & (y1 > y0)
            x1, y1 = np.maximum(x0, x1), np.maximum(y0, y1)
        return Rectangle(x0, x1, y0, y1, height, height * height), lit

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform in solid angle, or in area where that is small."""
        axes, half_x, half_y = self._lamps(row)
        tan = None if self._tan is None else at(self._tan, row)
        r, lit = self._bright_part(tan, see(axes, half_x, half_y, p))
        x, y, omega = square_to_spherical_rectangle(r, u, v)
        small = np.flatnonzero(omega < SMALL_SOLID_ANGLE)
        if small.size:
            x0, x1, y0, y1, _, _ = s = Rectangle(*(a.take(small) for a in r))
            x[small] = x0 + u.take(small) * (x1 - x0)
            y[small] = y0 + v.take(small) * (y1 - y0)
        squared = x * x
        squared += y * y
        squared += r.height_squared
        distance: Float32 = np.sqrt(squared)
        if small.size:
            omega[small] = s.area * s.height / (squared.take(small) * distance.take(small))
        pdf = at(self._chance, row) / above(omega) * lit
        omega *= lit
        if tan is not None:
            omega *= self._dim(row, tan, x, y, r.height)
        return Draw(toward(axes, x, y, r.height, distance), distance, at(self._weight, row) * omega, pdf)

    def hits(self, row: int, o: Float32, d: Float32, t: Float32) -> Hits:
        """Where the ray crosses the rectangle from its bright side."""
        met = self._cross(row, o, d, t)
        half_x, half_y = met.seen.half_x, met.seen.half_y
        met = met.among((np.abs(met.x - met.seen.x) <= half_x) & (np.abs(met.y - met.seen.y) <= half_y))
        only = np.array([row])
        tan = None if self._tan is None else at(self._tan, only)
        r, lit = self._bright_part(tan, met.seen)
        omega, _ = solid_angle(r)
        small = np.flatnonzero(omega < SMALL_SOLID_ANGLE)
        omega[small] = (r.area * r.height / np.maximum(met.s * met.s * met.s, 1e-30)).take(small)
        radiance = at(self._radiance, only) * lit
        if tan is not None:
            radiance *= self._dim(only, tan, met.x, met.y, r.height)
            lit &= (met.x >= r.x0) & (met.x <= r.x1) & (met.y >= r.y0) & (met.y <= r.y1)
        return Hits(met.lanes, radiance, self._chance[row] * lit / above(omega))


class Ellipses(_Areas):
    """Disks and ellipses."""

    def _region(self, tan: Float32 | None, seen: Seen) -> Seen:
        """The ellipse to sample: the lamp, or the circle that its spread lets through if that is smaller."""
        if tan is None:
            return seen
        reach = seen.height * tan
        circle = (reach * reach < seen.half_x * seen.half_y).astype(np.float32)
        lamp = 1.0 - circle
        half_x, half_y = seen.half_x * lamp + reach * circle, seen.half_y * lamp + reach * circle
        return Seen(seen.x * lamp, seen.y * lamp, seen.height, half_x, half_y)

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform in area."""
        axes, half_x, half_y = self._lamps(row)
        seen = see(axes, half_x, half_y, p)
        lit = seen.height > 0.0
        seen = seen._replace(height=np.maximum(seen.height, LOWEST))
        tan = None if self._tan is None else at(self._tan, row)
        region = self._region(tan, seen)
        radius, phi = np.sqrt(u), TWO_PI * v
        x = region.x + region.half_x * radius * np.cos(phi)
        y = region.y + region.half_y * radius * np.sin(phi)
        squared = x * x + y * y + seen.height * seen.height
        distance: Float32 = np.sqrt(squared)
        surface = float(np.pi) * region.half_x * region.half_y
        omega = surface * seen.height / (squared * distance)
        if tan is not None:
            a, b = (x - seen.x) / half_x, (y - seen.y) / half_y
            lit &= a * a + b * b <= 1.0
        pdf = at(self._chance, row) / above(omega) * lit
        omega *= lit
        if tan is not None:
            omega *= self._dim(row, tan, x, y, seen.height)
        return Draw(toward(axes, x, y, seen.height, distance), distance, at(self._weight, row) * omega, pdf)

    def hits(self, row: int, o: Float32, d: Float32, t: Float32) -> Hits:
        """Where the ray crosses the ellipse from its bright side."""
        met = self._cross(row, o, d, t)
        a, b = (met.x - met.seen.x) / met.seen.half_x, (met.y - met.seen.y) / met.seen.half_y
        met = met.among(a * a + b * b <= 1.0)
        only = np.array([row])
        tan = None if self._tan is None else at(self._tan, only)
        region = self._region(tan, met.seen)
        cubed: Float32 = np.maximum(met.s * met.s * met.s, 1e-30)
        omega = float(np.pi) * region.half_x * region.half_y * region.height / cubed
        radiance = np.repeat(at(self._radiance, only), met.lanes.size, axis=1)
        if tan is None:
            return Hits(met.lanes, radiance, self._chance[row] / above(omega))
        radiance *= self._dim(only, tan, met.x, met.y, region.height)
        a, b = (met.x - region.x) / region.half_x, (met.y - region.y) / region.half_y
        return Hits(met.lanes, radiance, self._chance[row] / above(omega) * (a * a + b * b <= 1.0))
