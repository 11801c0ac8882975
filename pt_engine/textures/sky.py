"""The sky of a day: radiance in any direction, from a table of it and the sun's disc.

Rows of the table lie dense at the horizon: row coordinate v = ½ ± ½·√(|elevation|·2/π). Within the disc,
with ρ the distance from its centre as a share of its radius,

    L = mix(bottom, top, height in the disc) · intensity · (1 − 0.6·(1 − √(1 − ρ²)))

the last factor the darkening of the sun's limb.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from . import sky_multiple, sky_single
from .lookup import EXTEND, Grid
from .sky_multiple import Air
from .texels import Whole

Float32 = NDArray[np.float32]
F = np.float32
PI, TWO_PI = F(np.pi), F(2 * np.pi)
MODELS: Final = {"SINGLE_SCATTERING": sky_single, "MULTIPLE_SCATTERING": sky_multiple}
SMALLEST_SUN: Final = 0.0005  # diameter in radians
XYZ_TO_REC709: Final = np.array(
    [
        [3.2409699, -1.5373832, -0.4986108],
        [-0.9692436, 1.8759675, 0.0415551],
        [0.0556301, -0.2039770, 1.0569715],
    ],
    np.float32,
)


@dataclass(frozen=True)
class Settings:
    """Of one sky; angles in radians, altitude in metres."""

    model: str
    sun_elevation: float
    sun_rotation: float
    sun_size: float
    sun_intensity: float
    altitude: float
    air: Air


class Sky:
    """Radiance of the sky, with its sun (`sun_size` > 0) or without.

    Attributes
    ----------
    toward_sun : (3,) float32
        Unit.
    half_angle : float
        Of the sun's disc; 0 where there is none.
    """

    def __init__(self, settings: Settings) -> None:
        s = settings
        self.elevation, self.rotation = upright(s.sun_elevation, s.sun_rotation)
        texels = table(s.model, float(self.elevation), s.altitude, s.air)
        self._grid = Grid(Whole.of(texels), EXTEND)
        flat = np.cos(self.elevation)
        self.toward_sun = np.array(
            [-flat * np.sin(self.rotation), flat * np.cos(self.rotation), np.sin(self.elevation)], np.float32
        )
        self._diameter = F(max(s.sun_size, SMALLEST_SUN)) if s.sun_size > 0 else F(0)
        self.half_angle = float(self._diameter) / 2
        self._intensity = F(s.sun_intensity)
        if self.half_angle:
            of_model = MODELS[s.model].sun_disc
            self._bottom, self._top = of_model(
                float(self.elevation), float(self._diameter), s.altitude, s.air
            )
        height = sky_multiple.EARTH + F(s.altitude) / F(1000)
        self._horizon = np.arcsin(min(sky_multiple.EARTH / height, F(1))) - F(np.pi / 2)

    def radiance(self, d: Float32) -> Float32:
        """(3, n) Rec.709 in directions d (3, n)."""
        elevation = F(np.pi / 2) - np.arccos(np.clip(d[2], F(-1), F(1)))
        turn = (-np.arctan2(d[1], d[0]) - F(np.pi / 2) + self.rotation) * F(0.5 / np.pi)
        u = turn - np.floor(turn)
        v = np.copysign(np.sqrt(np.abs(elevation) * F(2 / np.pi)), elevation) * F(0.5) + F(0.5)
        texels = self._grid.linear(u, v)[0][:3]  # a black sky's has a single channel
        xyz = np.array(np.broadcast_to(texels, (3, d.shape[1])))
        if self.half_angle:
            self._add_sun(xyz, d, elevation)
        return rec709(xyz)

    def _add_sun(self, xyz: Float32, d: Float32, elevation: Float32) -> None:
        w = self.toward_sun[:, None]
        away = vectors.length(d - w), vectors.length(d + w)
        lanes = np.flatnonzero((away[0] < 2 * self.half_angle * away[1]) & (elevation > self._horizon))
        angle = 2 * np.arctan2(away[0].take(lanes), away[1].take(lanes))
        rho = angle / F(self.half_angle)
        inside = np.flatnonzero(rho < 1)
        lanes, rho = lanes.take(inside), rho.take(inside)
        height = (elevation.take(lanes) - self.elevation) / self._diameter + F(0.5)
        limb = 1 - F(0.6) * (1 - np.sqrt(1 - rho * rho))
        light = self._bottom[:, None] + height * (self._top - self._bottom)[:, None]
        xyz[:, lanes] += light * self._intensity * limb


def upright(elevation: float, rotation: float) -> tuple[np.float32, np.float32]:
    """The sun's place with an elevation within ±π/2 and its rotation clockwise in (0, 2π]."""
    e, r = np.fmod(F(elevation), TWO_PI), F(rotation)
    if abs(e) >= PI:
        e -= np.copysign(TWO_PI, e)
    if abs(e) >= PI / 2:
        e, r = np.copysign(PI, e) - e, r + PI
    r = np.fmod(r, TWO_PI)
    return F(e), F(TWO_PI - (r + TWO_PI if r < 0 else r))


def rec709(xyz: Float32) -> Float32:
    """Linear Rec.709, negative components 0."""
    rgb = np.empty_like(xyz)
    for k, row in enumerate(XYZ_TO_REC709):
        rgb[k] = np.maximum(row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2], 0)
    return rgb


@lru_cache(maxsize=16)
def table(model: str, sun_elevation: float, altitude: float, air: Air) -> Float32:
    """(HEIGHT, WIDTH, 4) XYZ1 texels of a model."""
    xyz = MODELS[model].sky(sun_elevation, altitude, air)
    texels = np.ones((*xyz.shape[:2], 4), np.float32)
    texels[..., :3] = xyz
    return texels


@lru_cache(maxsize=64)
def sky(settings: Settings) -> Sky:
    """The same object for the same settings."""
    return Sky(settings)
