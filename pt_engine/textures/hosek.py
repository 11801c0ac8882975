"""Hosek's and Wilkie's skylight: a turbid day over a ground of some albedo, without a sun.

Hosek and Wilkie, *An Analytic Model for Full Spectral Sky-Dome Radiance* (2012). With γ the angle to the sun,
θ that to the zenith, for each of X, Y and Z

    L(θ, γ) = M · (1 + A·exp(B / (cosθ + 0.01))) · (C + D·exp(E·γ) + F·cos²γ + G·χ(H, γ) + I·√cosθ)
    χ(H, γ) = (1 + cos²γ) / (1 + H² − 2H·cosγ)^(3/2)

A to I and M are quintic Bézier curves of ∛(elevation / 90°), linear between whole turbidities and in albedo.
Their control points are in hosek.npz, which tools/measure_hosek.py has found from Blender's pictures of
such skies: to 4·10⁻⁵ at all turbidities, albedos and elevations that were looked at.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .sky import rec709

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
F = np.float32
PI = F(np.pi)
LOWEST: Final = PI / 2 - F(0.001)  # angle to the zenith
STRENGTH: Final = F(2 * np.pi / 683)  # as in Blender


@lru_cache(maxsize=1)
def control_points() -> Float64:
    """(3, 10, 2, 10, 6): X, Y, Z; turbidities 1 to 10; albedos 0 and 1; A to G, I, H, M; along the curve."""
    with np.load(Path(__file__).with_name("hosek.npz")) as file:
        points: Float64 = file["control_points"]
    return points


def bezier(x: float) -> Float64:
    """(6,) weights of the control points of a quintic."""
    return np.array([comb(5, k) * (1 - x) ** (5 - k) * x**k for k in range(6)])


class Hosek:
    """The sky for a unit direction toward the sun, a turbidity in [1, 10] and the ground's albedo."""

    def __init__(self, sun: tuple[float, ...], turbidity: float, albedo: float) -> None:
        self.theta = np.minimum(np.arccos(F(sun[2])), PI / 2)
        self.phi = np.arctan2(F(sun[0]), F(sun[1]))
        x = float(np.cbrt(max(np.pi / 2 - float(self.theta), 0.0) / (np.pi / 2)))
        points = control_points()
        turbidity = min(max(turbidity, 1.0), 10.0)
        low = min(int(turbidity), 9)
        share = turbidity - low
        between = (1 - share) * points[:, low - 1] + share * points[:, low]
        curves = (1 - albedo) * between[:, 0] + albedo * between[:, 1]
        self._coefficients: Float32 = (curves * bezier(x)).sum(axis=-1).astype(np.float32)  # (3, 10)

    def radiance(self, d: Float32) -> Float32:
        """(3, n) Rec.709 in directions d (3, n)."""
        theta = np.arccos(np.clip(d[2], F(-1), F(1)))
        turn = PI / 2 - np.arctan2(d[1], d[0]) - self.phi
        cosine = np.sin(theta) * np.sin(self.theta) * np.cos(turn) + np.cos(theta) * np.cos(self.theta)
        gamma = np.arccos(np.clip(cosine, F(-1), F(1)))
        up, toward = np.cos(np.minimum(theta, LOWEST)), np.cos(gamma)
        xyz = np.empty((3, d.shape[1]), np.float32)
        for row, (a, b, c, dd, e, f, g, i, h, m) in zip(xyz, self._coefficients, strict=True):
            chi = (1 + toward * toward) / (1 + h * h - 2 * h * toward) ** F(1.5)
            glow = c + dd * np.exp(e * gamma) + f * toward * toward + g * chi + i * np.sqrt(up)
            row[:] = m * (1 + a * np.exp(b / (up + F(0.01)))) * glow
        return rec709(xyz) * STRENGTH


@lru_cache(maxsize=64)
def hosek(sun: tuple[float, ...], turbidity: float, albedo: float) -> Hosek:
    """The same object for the same settings."""
    return Hosek(sun, turbidity, albedo)
