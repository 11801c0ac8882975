"""Suns: light from one direction, or from a uniformly bright disc of the sky.

With E the strength in the panel (irradiance on a plane that faces the sun, W·m⁻²) and α half the angle
(kernel/light/sun.h and SunLight::area of Cycles):

    α = 0      E·δ(ω)
    α > 0      L = E / (π sin²α), so that ∫ L cosθ dω over the disc is E;   pdf = 1 / 2π(1 − cosα)

With *normalize* off L = E.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from .base import FAR, NO_HITS, Draw, Float32, Float64, Hits, Index, Lamp, at, columns, of_met, scalars, unit

TWO_PI = float(2.0 * np.pi)


def half_angle(lamp: Lamp) -> float:
    """α in radians, at most a hemisphere's."""
    return min(max(0.5 * lamp.data.angle, 0.0), 0.5 * float(np.pi))


def strength_per_area(lamp: Lamp) -> Float64:
    """(3,) Radiance of a sun with size; irradiance of one without."""
    alpha = half_angle(lamp)
    return lamp.strength / (np.pi * np.sin(alpha) ** 2 if alpha > 0.0 and lamp.data.normalize else 1.0)


class DeltaSuns:
    """Suns without size."""

    delta: ClassVar[bool] = True

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        self._toward = columns([-lamp.direction for lamp in lamps])
        self._weight = columns([strength_per_area(lamp) / c for lamp, c in zip(lamps, chance, strict=True)])
        self._chance = scalars(chance)

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """The one direction there is."""
        wo, weight, pdf = np.empty_like(p), np.empty_like(p), np.empty_like(u)
        wo[:], weight[:], pdf[:] = at(self._toward, row), at(self._weight, row), at(self._chance, row)
        return Draw(wo, np.full(u.shape, FAR, np.float32), weight, pdf)

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """No ray meets a direction."""
        return NO_HITS


class DiscSuns:
    """Suns that fill a cone."""

    delta: ClassVar[bool] = False

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        toward = [-lamp.direction for lamp in lamps]
        side = [unit(np.cross(w, np.eye(3)[np.argmin(np.abs(w))])) for w in toward]
        self._toward, self._s = columns(toward), columns(side)
        self._t = columns([np.cross(w, s) for w, s in zip(toward, side, strict=True)])
        one_minus_cos = np.array([2.0 * np.sin(0.5 * half_angle(lamp)) ** 2 for lamp in lamps])
        self._one_minus_cos = scalars(one_minus_cos)
        radiance = [strength_per_area(lamp) for lamp in lamps]
        self._radiance = columns(radiance)
        cone = TWO_PI * one_minus_cos
        self._weight = columns([r * a / c for r, a, c in zip(radiance, cone, chance, strict=True)])
        self._pdf = scalars(chance / cone)

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform directions in the cone."""
        one_minus_cos = u * at(self._one_minus_cos, row)
        sin = np.sqrt(one_minus_cos * (2.0 - one_minus_cos))
        phi = TWO_PI * v
        wo = (sin * np.cos(phi)) * at(self._s, row)
        wo += (sin * np.sin(phi)) * at(self._t, row)
        wo += (1.0 - one_minus_cos) * at(self._toward, row)
        weight, pdf = np.empty_like(wo), np.empty_like(u)
        weight[:], pdf[:] = at(self._weight, row), at(self._pdf, row)
        return Draw(wo, np.full(u.shape, FAR, np.float32), weight, pdf)

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """Rays that leave the scene through the disc; 1 − cos = |d − w|² / 2 keeps its digits."""
        w = self._toward[:, row]
        x, y, z = d[0] - w[0], d[1] - w[1], d[2] - w[2]
        lanes = np.flatnonzero((x * x + y * y + z * z <= 2.0 * self._one_minus_cos[row]) & (t >= FAR))
        return Hits(lanes, of_met(self._radiance, row, lanes), of_met(self._pdf, row, lanes))
