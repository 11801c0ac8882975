"""Disk and elliptic area lamps (area.py), sampled uniformly in area.

Where the spread lets through a circle that is smaller than the lamp, that circle is sampled instead.
"""

from __future__ import annotations

import numpy as np

from .area import LOWEST, AreaLamps, Seen, above, see, toward
from .base import Draw, Float32, Hits, Index, at, rows_met

TWO_PI = float(2.0 * np.pi)


class Ellipses(AreaLamps):
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

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """Where the ray crosses the ellipse from its bright side."""
        met = self._cross(row, o, d, t)
        a, b = (met.x - met.seen.x) / met.seen.half_x, (met.y - met.seen.y) / met.seen.half_y
        met = met.among(a * a + b * b <= 1.0)
        only = rows_met(row, met.lanes)
        tan = None if self._tan is None else at(self._tan, only)
        region = self._region(tan, met.seen)
        cubed: Float32 = np.maximum(met.s * met.s * met.s, 1e-30)
        omega = float(np.pi) * region.half_x * region.half_y * region.height / cubed
        radiance = at(self._radiance, only)
        if tan is None:
            return Hits(met.lanes, radiance, at(self._chance, only) / above(omega))
        radiance *= self._dim(only, tan, met.x, met.y, region.height)
        a, b = (met.x - region.x) / region.half_x, (met.y - region.y) / region.half_y
        return Hits(met.lanes, radiance, at(self._chance, only) / above(omega) * (a * a + b * b <= 1.0))
