"""Area lamps that shine to one side, with or without spread: what rectangles and ellipses share.

With Φ the watts in the panel and A the area after scaling (kernel/light/area.h and AreaLight of Cycles):

    L = Φ / (π A)                                         (*normalize* off: Φ / π)
    L(θ) = L · max(tan α − tan θ, 0) / (tan α − α)        α half the spread, θ from the lamp's axis;
                                                          below α = 0.05 the series 3 (tan α − tan θ) / α³
    α = 0:  a parallel beam of irradiance Φ / A           (*normalize* off: Φ)

A lit point at height h over the lamp's plane sees only a circle of radius h·tan α about its foot, so only
there are samples drawn. All is computed in the lamp's own axes, from the lit point.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import dot
from .base import NO_HITS, Draw, Float32, Float64, Hits, Index, Lamp, at, columns, scalars, unit

PARALLEL = 1e-4  # rad; a smaller half spread is a parallel beam
SMALLEST = 1e-15  # sr; densities stay below its reciprocal
SHORTEST = 1e-12  # m; a shorter edge counts as this: watts over its square leave float32's range
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
    return at_least(abs(x) * scale[0]), at_least(abs(y) * scale[1])


def at_least(edge: float) -> float:
    """A length that float32 can square and divide by; none stays none."""
    return max(float(edge), SHORTEST) if edge > 0.0 else 0.0


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


class AreaLamps:
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

    def _cross(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Crossing:
        """Lanes that pass the lamp's bounding rectangle from its bright side before `t`."""
        axes, half_x, half_y = self._lamps(np.atleast_1d(row))
        seen = see(axes, half_x, half_y, o)
        facing = -dot(d, axes.z)
        ahead: Float32 = np.maximum(facing, 1e-9)
        s = np.maximum(seen.height, 0.0).astype(np.float32, copy=False) / ahead
        x, y = s * dot(d, axes.x), s * dot(d, axes.y)
        within = (np.abs(x - seen.x) <= half_x) & (np.abs(y - seen.y) <= half_y)
        within &= (facing > 0.0) & (s > 0.0) & (s < t)
        return Crossing(np.arange(s.size, dtype=np.intp), seen, x, y, s).among(within)


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
        if half_x.size > 1:  # a lamp of its own for each lane
            half_x, half_y = half_x.take(keep), half_y.take(keep)
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


class Beams(AreaLamps):
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

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """No ray has just that direction."""
        return NO_HITS


class RoundBeams(Beams):
    """The same from an ellipse."""

    def _within(self, x: Float32, y: Float32) -> NDArray[np.bool_]:
        return np.asarray(x * x + y * y <= 1.0)
