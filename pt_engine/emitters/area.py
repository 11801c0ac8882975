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

from ..core.vectors import dot
from .base import TINY, Draw, Float32, Float64, Hits, Index, Lamp, at, columns, one, scalars, unit

TWO_PI = float(2.0 * np.pi)
SMALL_SOLID_ANGLE = 0.01  # sr; below it rectangles are sampled by area
PARALLEL = 1e-4  # rad; a smaller half spread is a parallel beam


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


class Seen(NamedTuple):
    """A lamp from the lit point, in the lamp's axes: centre x, y, height, half-lengths; each (n,) or (1,)."""

    x: Float32
    y: Float32
    height: Float32
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
        self._centre = columns([lamp.centre for lamp in lamps])
        self._axis_x, self._axis_z = columns(axis_x), columns(axis_z)
        self._axis_y = columns([np.cross(z, x) for z, x in zip(axis_z, axis_x, strict=True)])
        size = np.array([lengths(lamp) for lamp in lamps])
        self._half_x, self._half_y = scalars(0.5 * size[:, 0]), scalars(0.5 * size[:, 1])
        radiance = [strength_per_area(lamp) / np.pi for lamp in lamps]
        self._radiance = columns(radiance)
        self._weight = columns([r / c for r, c in zip(radiance, chance, strict=True)])
        self._chance = scalars(chance)
        self._tan: Float32 | None = None
        if has_spread(lamps[0]):
            alpha = np.array([max(half_spread(lamp), PARALLEL) for lamp in lamps])
            tan = np.tan(alpha)
            self._tan = scalars(tan)
            with np.errstate(divide="ignore"):
                self._narrow = scalars(np.where(alpha > 0.05, 1.0 / (tan - alpha), 3.0 / alpha**3))

    def _seen(self, row: Index | None, p: Float32) -> Seen:
        """The lamp from `p`; height ≤ 0 behind it."""
        to_centre = at(self._centre, row) - p
        x, y = dot(to_centre, at(self._axis_x, row)), dot(to_centre, at(self._axis_y, row))
        height = -dot(to_centre, at(self._axis_z, row))
        return Seen(x, y, height, at(self._half_x, row), at(self._half_y, row))

    def _world(self, row: Index | None, x: Float32, y: Float32, height: Float32) -> Float32:
        """From the lamp's axes to the world."""
        world = x * at(self._axis_x, row)
        world += y * at(self._axis_y, row)
        world -= height * at(self._axis_z, row)
        return world

    def _spread(self, row: Index | None, tan: Float32) -> Float32:
        """How the spread changes the radiance at tan θ `tan`."""
        if self._tan is None:
            raise ValueError("these lamps have no spread")
        return np.maximum((at(self._tan, row) - tan) * at(self._narrow, row), 0.0)

    def _cross(
        self, row: int, o: Float32, d: Float32, t: Float32
    ) -> tuple[Index, Seen, Float32, Float32, Float32]:
        """Lanes that pass the lamp's plane from its bright side before `t`: what they see, x, y, and s."""
        facing = -dot(d, one(self._axis_z, row))
        seen = self._seen_by(row, o)
        front = np.flatnonzero((seen.height > 0.0) & (facing > 0.0) & (seen.height < t * facing))
        seen = Seen(*(a.take(front) for a in seen[:3]), seen.half_x, seen.half_y)
        d = d.take(front, axis=1)
        s = seen.height / np.maximum(facing.take(front), 1e-20)
        return front, seen, s * dot(d, one(self._axis_x, row)), s * dot(d, one(self._axis_y, row)), s

    def _seen_by(self, row: int, o: Float32) -> Seen:
        """`_seen` of one lamp for all lanes."""
        to_centre = one(self._centre, row) - o
        x, y = dot(to_centre, one(self._axis_x, row)), dot(to_centre, one(self._axis_y, row))
        height = -dot(to_centre, one(self._axis_z, row))
        return Seen(x, y, height, one(self._half_x, row), one(self._half_y, row))


class Beams(_Areas):
    """Lamps whose spread is 0: parallel light from the lamp's shape."""

    delta = True

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """The one direction there is, where the foot of the lit point is within the shape."""
        seen = self._seen(row, p)
        lit = (np.abs(seen.x) <= seen.half_x) & (np.abs(seen.y) <= seen.half_y) & (seen.height > 0.0)
        wo, pdf = np.empty_like(p), np.empty_like(u)
        wo[:], pdf[:] = -at(self._axis_z, row), at(self._chance, row)
        weight = float(np.pi) * at(self._weight, row) * lit.astype(np.float32)
        return Draw(wo, np.maximum(seen.height, 0.0), weight, pdf)

    def hits(self, row: int, o: Float32, d: Float32, t: Float32) -> Hits:
        """No ray has just that direction."""
        return Hits(np.empty(0, np.intp), np.empty((3, 0), np.float32), np.empty(0, np.float32))


class RoundBeams(Beams):
    """The same from an ellipse."""

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """As a rectangle's, cut to the ellipse."""
        seen, sample = self._seen(row, p), super().sample(row, p, u, v)
        x, y = seen.x / seen.half_x, seen.y / seen.half_y
        return sample._replace(weight=sample.weight * (x * x + y * y <= 1.0))


class Rectangle(NamedTuple):
    """A rectangle x0..x1 × y0..y1 at height `height` over the lit point; each (n,)."""

    x0: Float32
    x1: Float32
    y0: Float32
    y1: Float32
    height: Float32


def solid_angle(r: Rectangle) -> Float32:
    """(n,) sr: four corners of atan(xy / h√(x² + y² + h²)), each with its sign."""
    h2 = r.height * r.height
    xx0, xx1, yy0, yy1 = r.x0 * r.x0 + h2, r.x1 * r.x1 + h2, r.y0 * r.y0, r.y1 * r.y1
    total = np.arctan2(r.x1 * r.y1, r.height * np.sqrt(xx1 + yy1))
    total -= np.arctan2(r.x0 * r.y1, r.height * np.sqrt(xx0 + yy1))
    total -= np.arctan2(r.x1 * r.y0, r.height * np.sqrt(xx1 + yy0))
    total += np.arctan2(r.x0 * r.y0, r.height * np.sqrt(xx0 + yy0))
    return total


def square_to_spherical_rectangle(
    r: Rectangle, omega: Float32, u: Float32, v: Float32
) -> tuple[Float32, Float32]:
    """x, y (n,) on the rectangle, uniform in the solid angle `omega` (Ureña et al. 2013, algorithm 2).

    With γ₂ + γ₃ written as −asin sums, which for a small rectangle keeps the digits that acos would lose.
    """
    h2 = r.height * r.height
    b0 = -r.y0 / np.sqrt(r.y0 * r.y0 + h2)
    b1 = r.y1 / np.sqrt(r.y1 * r.y1 + h2)
    turned = np.arctan2(r.x0 * r.y1, r.height * np.sqrt(r.x0 * r.x0 + r.y1 * r.y1 + h2))
    turned -= np.arctan2(r.x0 * r.y0, r.height * np.sqrt(r.x0 * r.x0 + r.y0 * r.y0 + h2))
    au = u * omega + turned
    sin = np.sin(au)
    sin += (np.abs(sin) < 1e-12).astype(np.float32) * 1e-12
    fu = (np.cos(au) * b0 + b1) / sin
    cu = np.copysign(1.0 / np.sqrt(fu * fu + b0 * b0), fu)
    cu = np.clip(cu, -1.0, 1.0)
    x = cu * r.height / np.sqrt(np.maximum(1.0 - cu * cu, 1e-14))
    x = np.clip(x, r.x0, r.x1)
    d2 = x * x + h2
    h0 = r.y0 / np.sqrt(d2 + r.y0 * r.y0)
    hv = h0 + v * (r.y1 / np.sqrt(d2 + r.y1 * r.y1) - h0)
    y = hv * np.sqrt(d2 / np.maximum(1.0 - hv * hv, 1e-12))
    return x, np.clip(y, r.y0, r.y1)


class Rectangles(_Areas):
    """Squares and rectangles."""

    def _visible(self, row: Index | None, seen: Seen) -> tuple[Rectangle, Float32]:
        """The part that shines on the lit point, and 1 where there is any, else 0 and something finite."""
        x0, x1 = seen.x - seen.half_x, seen.x + seen.half_x
        y0, y1 = seen.y - seen.half_y, seen.y + seen.half_y
        lit = seen.height > 0.0
        height = np.maximum(seen.height, 1e-12)
        if self._tan is not None:
            reach = height * at(self._tan, row)
            x0, x1 = np.maximum(x0, -reach), np.minimum(x1, reach)
            y0, y1 = np.maximum(y0, -reach), np.minimum(y1, reach)
            lit &= (x1 > x0) & (y1 > y0)
            x1, y1 = np.maximum(x0, x1), np.maximum(y0, y1)
        return Rectangle(x0, x1, y0, y1, height), lit.astype(np.float32)

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform in solid angle, or in area where that is small."""
        r, lit = self._visible(row, self._seen(row, p))
        omega = solid_angle(r)
        x, y = square_to_spherical_rectangle(r, omega, u, v)
        small = np.flatnonzero(omega < SMALL_SOLID_ANGLE)
        if small.size:
            x0, x1, y0, y1, _ = (a.take(small) for a in r)
            x[small] = x0 + u.take(small) * (x1 - x0)
            y[small] = y0 + v.take(small) * (y1 - y0)
        h2 = r.height * r.height
        squared = x * x + y * y + h2
        distance = np.sqrt(squared)
        if small.size:
            s, d = squared.take(small), distance.take(small)
            omega[small] = (x1 - x0) * (y1 - y0) * r.height.take(small) / (s * d)
        wo = self._world(row, x, y, r.height)
        wo /= distance
        scale = omega * lit
        if self._tan is not None:
            scale *= self._spread(row, np.sqrt(x * x + y * y) / r.height)
        pdf = at(self._chance, row) / np.maximum(omega, TINY) * lit
        return Draw(wo, distance, at(self._weight, row) * scale, pdf)

    def hits(self, row: int, o: Float32, d: Float32, t: Float32) -> Hits:
        """Where the ray crosses the rectangle from its bright side."""
        front, seen, x, y, s = self._cross(row, o, d, t)
        inside = (np.abs(x - seen.x) <= seen.half_x) & (np.abs(y - seen.y) <= seen.half_y)
        keep = np.flatnonzero(inside)
        lanes, x, y, s = front.take(keep), x.take(keep), y.take(keep), s.take(keep)
        seen = Seen(*(a.take(keep) for a in seen[:3]), seen.half_x, seen.half_y)
        rows = np.full(lanes.size, row, np.intp)
        r, lit = self._visible(rows, seen)
        omega = solid_angle(r)
        by_area = (r.x1 - r.x0) * (r.y1 - r.y0) * r.height / np.maximum(s * s * s, TINY)
        omega = np.where(omega < SMALL_SOLID_ANGLE, by_area, omega)
        radiance = one(self._radiance, row) * lit
        if self._tan is not None:
            radiance *= self._spread(rows, np.sqrt(x * x + y * y) / r.height)
        return Hits(lanes, radiance, self._chance[row] / np.maximum(omega, TINY) * lit)


class Ellipses(_Areas):
    """Disks and ellipses."""

    def _region(self, row: Index | None, seen: Seen) -> Seen:
        """The ellipse to sample: the lamp, or the circle that its spread lets through if that is smaller."""
        if self._tan is None:
            return seen
        reach = seen.height * at(self._tan, row)
        circle = (reach * reach < seen.half_x * seen.half_y).astype(np.float32)
        lamp = 1.0 - circle
        half_x, half_y = seen.half_x * lamp + reach * circle, seen.half_y * lamp + reach * circle
        return Seen(seen.x * lamp, seen.y * lamp, seen.height, half_x, half_y)

    def _shine(self, row: Index | None, seen: Seen, x: Float32, y: Float32) -> Float32:
        """What spread and shape leave of the radiance toward (x, y) on the lamp's plane."""
        shine = (seen.height > 1e-12).astype(np.float32)
        if self._tan is not None:
            a, b = (x - seen.x) / seen.half_x, (y - seen.y) / seen.half_y
            shine *= a * a + b * b <= 1.000001
            shine *= self._spread(row, np.sqrt(x * x + y * y) / np.maximum(seen.height, 1e-12))
        return shine

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform in area."""
        seen = self._seen(row, p)
        seen = seen._replace(height=np.maximum(seen.height, 1e-12))
        region = self._region(row, seen)
        radius, phi = np.sqrt(u), TWO_PI * v
        x = region.x + region.half_x * radius * np.cos(phi)
        y = region.y + region.half_y * radius * np.sin(phi)
        squared = x * x + y * y + seen.height * seen.height
        distance = np.sqrt(squared)
        wo = self._world(row, x, y, seen.height)
        wo /= distance
        surface = float(np.pi) * region.half_x * region.half_y
        solid = surface * seen.height / (squared * distance)
        shine = self._shine(row, seen, x, y)
        pdf = at(self._chance, row) / np.maximum(solid, TINY) * (seen.height > 1e-12)
        return Draw(wo, distance, at(self._weight, row) * (solid * shine), pdf)

    def hits(self, row: int, o: Float32, d: Float32, t: Float32) -> Hits:
        """Where the ray crosses the ellipse from its bright side."""
        front, seen, x, y, s = self._cross(row, o, d, t)
        a, b = (x - seen.x) / seen.half_x, (y - seen.y) / seen.half_y
        keep = np.flatnonzero(a * a + b * b <= 1.0)
        lanes, x, y, s = front.take(keep), x.take(keep), y.take(keep), s.take(keep)
        seen = Seen(*(c.take(keep) for c in seen[:3]), seen.half_x, seen.half_y)
        rows = np.full(lanes.size, row, np.intp)
        region = self._region(rows, seen)
        solid = float(np.pi) * region.half_x * region.half_y * seen.height / np.maximum(s * s * s, TINY)
        radiance = one(self._radiance, row) * self._shine(rows, seen, x, y)
        return Hits(lanes, radiance, self._chance[row] / np.maximum(solid, TINY))
