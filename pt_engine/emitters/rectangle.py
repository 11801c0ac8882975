"""Square and rectangular area lamps (area.py).

Sampled uniformly in solid angle (Ureña, Fajardo, King 2013, "An Area-Preserving Parametrization for Spherical
Rectangles") where they look large, and uniformly in area where they look small or are seen edge-on, which
there is as good and keeps its digits. Against area sampling alone the standard deviation of an unshadowed
Lambert plane's irradiance is a quarter at a distance of the lamp's size, and less nearer by.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .area import LOWEST, AreaLamps, Seen, above, see, toward
from .base import Draw, Float32, Hits, Index, at, rows_met

SMALL_SOLID_ANGLE = 0.01  # sr


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


def square_to_spherical_rectangle(
    r: Rectangle, omega: Float32, left: Float32, u: Float32, v: Float32
) -> tuple[Float32, Float32]:
    """x, y (n,) on the rectangle, uniform in solid angle; `omega` and `left` from `solid_angle`.

    With a = u·Ω + left, rᵢ = 1 / √(yᵢ² + h²), their c_u = sin a / √(…) written without dividing by sin a:

        x = h·sin a / √((y1·r1 − y0·r0·cos a)² − (h·r0·sin a)²)
    """
    angle = u * omega
    angle += left
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
    return x, np.minimum(np.maximum(hv, r.y0), r.y1)


def square_to_rectangle(r: Rectangle, u: Float32, v: Float32) -> tuple[Float32, Float32]:
    """x, y (n,) on the rectangle, uniform in area."""
    return r.x0 + u * (r.x1 - r.x0), r.y0 + v * (r.y1 - r.y0)


class Rectangles(AreaLamps):
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
        omega, left = solid_angle(r)
        small = np.flatnonzero(omega < SMALL_SOLID_ANGLE)
        if small.size == omega.size:
            x, y = square_to_rectangle(r, u, v)
        else:
            x, y = square_to_spherical_rectangle(r, omega, left, u, v)
        if 0 < small.size < omega.size:
            part = Rectangle(*(a.take(small) for a in r))
            x[small], y[small] = square_to_rectangle(part, u.take(small), v.take(small))
        squared = x * x
        squared += y * y
        squared += r.height_squared
        distance: Float32 = np.sqrt(squared)
        if small.size:
            omega[small] = (r.area * r.height / (squared * distance)).take(small)
        pdf = at(self._chance, row) / above(omega) * lit
        omega *= lit
        if tan is not None:
            omega *= self._dim(row, tan, x, y, r.height)
        return Draw(toward(axes, x, y, r.height, distance), distance, at(self._weight, row) * omega, pdf)

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """Where the ray crosses the rectangle from its bright side."""
        met = self._cross(row, o, d, t)
        only = rows_met(row, met.lanes)
        tan = None if self._tan is None else at(self._tan, only)
        r, lit = self._bright_part(tan, met.seen)
        omega, _ = solid_angle(r)
        small = np.flatnonzero(omega < SMALL_SOLID_ANGLE)
        omega[small] = (r.area * r.height / np.maximum(met.s * met.s * met.s, 1e-30)).take(small)
        radiance = at(self._radiance, only) * lit
        if tan is not None:
            radiance *= self._dim(only, tan, met.x, met.y, r.height)
            lit &= (met.x >= r.x0) & (met.x <= r.x1) & (met.y >= r.y0) & (met.y <= r.y1)
        return Hits(met.lanes, radiance, at(self._chance, only) * lit / above(omega))
