"""A sky with suns: small bright discs are drawn on their own, the rest from the sky's map.

A disc half a degree wide is a texel of the map, far too coarse. So the map is made of the sky without suns,
and directions come from a mixture,

    pdf(ω) = (1 − Σ qᵢ) · pdf_map(ω) + Σ qᵢ · [ω in disc i] / Ωᵢ

which is evaluated whole for every direction, however it was drawn: what the suns shine with, and whether
discs overlap or are cut by the horizon, is for the radiance alone to know.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .base import Float32, Float64, columns, scalars, unit
from .environment import EnvironmentMap, Radiance

TWO_PI = float(2.0 * np.pi)
RIM = 1.002  # cones reach past their discs: rounding must not put a sun's direction outside of its cone
MOST = 0.8  # of all samples go to the suns, at least
LEAST = 0.1


class Disc(NamedTuple):
    """A cone of directions: its axis (3,), half angle in radians, and irradiance ∫ L dω from inside it."""

    toward: Float64
    half_angle: float
    irradiance: float


def cone_directions(toward: Float64, half_angle: float, u: Float32, v: Float32) -> Float32:
    """(3, n) uniform directions in a cone; the float32 difference to its axis keeps its digits."""
    toward = unit(np.asarray(toward, np.float64))
    side = unit(np.cross(toward, np.eye(3)[np.argmin(np.abs(toward))]))
    up = np.cross(toward, side)
    one_minus_cos = u * np.float32(2.0 * np.sin(0.5 * half_angle) ** 2)
    sin = np.sqrt(one_minus_cos * (2.0 - one_minus_cos))
    phi = np.float32(TWO_PI) * v
    x, y = sin * np.cos(phi), sin * np.sin(phi)
    d = np.empty((3, u.size), np.float32)
    for axis in range(3):
        a, b, c = (np.float32(w[axis]) for w in (side, up, toward))
        d[axis] = x * a + y * b + (1.0 - one_minus_cos) * c
    return d


class SunnyEnvironment:
    """An `EnvironmentMap` without suns, and suns.

    Parameters
    ----------
    sky : EnvironmentMap
        Of the sky without them.
    discs : sequence of Disc
        With irradiance > 0.
    radiance : callable
        Le of directions (3, N), suns included.
    """

    constant: Float64 | None = None

    def __init__(self, sky: EnvironmentMap, discs: Sequence[Disc], radiance: Radiance) -> None:
        self._sky, self._radiance, self._given = sky, radiance, discs
        self._discs = [d._replace(half_angle=min(RIM * d.half_angle, float(np.pi))) for d in discs]
        of_suns = np.array([d.irradiance for d in discs], np.float64)
        self.irradiance = sky.irradiance + float(of_suns.sum())
        share = float(np.clip(of_suns.sum() / self.irradiance, LEAST, MOST))
        chance = share * of_suns / float(of_suns.sum())
        self._edges = np.concatenate([[0.0], np.cumsum(chance)])
        self._left = np.float32(1.0 - self._edges[-1])
        one_minus_cos = np.array([2.0 * np.sin(0.5 * d.half_angle) ** 2 for d in self._discs])
        self._toward = columns([unit(np.asarray(d.toward, np.float64)) for d in discs])
        self._chord = scalars(2.0 * one_minus_cos)
        self._density = scalars(chance / (TWO_PI * one_minus_cos))

    @cached_property
    def compensated(self) -> SunnyEnvironment:
        """With a sky drawn for estimators that combine it with BSDF sampling."""
        return SunnyEnvironment(self._sky.compensated, self._given, self._radiance)

    def radiance(self, d: Float32) -> Float32:
        """(3, N)."""
        return self._radiance(d)

    def sample(self, u: Float32, v: Float32) -> tuple[Float32, Float32]:
        """Directions (3, n) and their density (n,)."""
        d = np.empty((3, u.size), np.float32)
        pdf = np.empty(u.size, np.float32)
        last = len(self._discs)
        for number in range(last + 1):
            low = self._edges[number]
            high = self._edges[number + 1] if number < last else 1.0
            lanes = np.flatnonzero((u >= low) & (u < high))
            if not lanes.size:
                continue
            rest = np.minimum((u.take(lanes) - low) / (high - low), 1.0 - 2.0**-24).astype(np.float32)
            other = v.take(lanes)
            if number == last:
                wo, of_sky = self._sky.sample(rest, other)
            else:
                disc = self._discs[number]
                wo = cone_directions(disc.toward, disc.half_angle, rest, other)
                of_sky = self._sky.pdf(wo)
            for axis in range(3):
                d[axis][lanes] = wo[axis]
            pdf[lanes] = self._left * of_sky + self._of_suns(wo, number)
        return d, pdf

    def pdf(self, d: Float32) -> Float32:
        """(n,) density of `sample`."""
        return self._left * self._sky.pdf(d) + self._of_suns(d)

    def _of_suns(self, d: Float32, drawn: int = -1) -> Float32:
        """(n,) the discs' part of the density; all of `d` count as inside of disc number `drawn`."""
        out = np.zeros(d.shape[1], np.float32)
        for number, density in enumerate(self._density):
            if number == drawn:
                out += density
                continue
            w = self._toward[:, number]
            x, y, z = d[0] - w[0], d[1] - w[1], d[2] - w[2]
            out += density * (x * x + y * y + z * z <= self._chord[number])
        return out
