"""Preetham's daylight: the sky of a turbid day in closed form, without a sun.

Preetham, Shirley and Smits, *A Practical Analytic Model for Daylight* (1999), appendix A.2. With γ the angle
to the sun, θ that to the zenith, and Perez' function

    F(θ, γ) = (1 + A·exp(B / cosθ)) · (1 + C·exp(D·γ) + E·cos²γ)

chromaticity and luminance are those of the zenith times F(θ, γ) / F(0, θ_sun). The luminance is scaled by
0.06, as in Blender.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .sky import rec709

Float32 = NDArray[np.float32]
F = np.float32
PI = F(np.pi)

# A to E as slope·turbidity + offset, of x, y, Y
PEREZ: Final = np.array(
    [
        [(-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)],
        [(-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)],
        [(0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)],
    ],
    np.float32,
)
# chromaticity of the zenith: rows by powers 2, 1, 0 of turbidity, columns by powers 3, 2, 1, 0 of θ_sun
ZENITH_X: Final = np.array(
    [
        (0.00166, -0.00375, 0.00209, 0),
        (-0.02903, 0.06377, -0.03202, 0.00394),
        (0.11693, -0.21196, 0.06052, 0.25886),
    ],
    np.float32,
)
ZENITH_Y: Final = np.array(
    [
        (0.00275, -0.00610, 0.00317, 0),
        (-0.04214, 0.08970, -0.04153, 0.00516),
        (0.15346, -0.26756, 0.06670, 0.26688),
    ],
    np.float32,
)
LOWEST: Final = PI / 2 - F(0.001)  # angle to the zenith


def perez(k: Float32, theta: Float32 | np.float32, gamma: Float32 | np.float32) -> Float32:
    """F(θ, γ) for coefficients k = A, B, C, D, E."""
    cosine = np.cos(gamma)
    out: Float32 = (1 + k[0] * np.exp(k[1] / np.cos(theta))) * (
        1 + k[2] * np.exp(k[3] * gamma) + k[4] * cosine * cosine
    )
    return out


class Daylight:
    """The sky for a unit direction toward the sun and a turbidity."""

    def __init__(self, sun: tuple[float, ...], turbidity: float) -> None:
        t = F(turbidity)
        self.theta, self.phi = np.arccos(F(sun[2])), np.arctan2(F(sun[0]), F(sun[1]))
        self._perez = PEREZ[..., 0] * t + PEREZ[..., 1]
        powers = np.array([self.theta**3, self.theta**2, self.theta, 1], np.float32)
        of_turbidity = np.array([t * t, t, 1], np.float32)
        chi = (F(4 / 9) - t / 120) * (PI - 2 * self.theta)
        bright = (F(4.0453) * t - F(4.9710)) * np.tan(chi) - F(0.2155) * t + F(2.4192)
        zenith = [
            ((ZENITH_X * powers).sum(axis=1) * of_turbidity).sum(),
            ((ZENITH_Y * powers).sum(axis=1) * of_turbidity).sum(),
            bright * F(0.06),
        ]
        self._zenith = [z / perez(k, F(0), self.theta) for z, k in zip(zenith, self._perez, strict=True)]

    def radiance(self, d: Float32) -> Float32:
        """(3, n) Rec.709 in directions d (3, n)."""
        theta = np.arccos(np.clip(d[2], F(-1), F(1)))
        turn = PI / 2 - np.arctan2(d[1], d[0]) - self.phi
        cosine = np.sin(theta) * np.sin(self.theta) * np.cos(turn) + np.cos(theta) * np.cos(self.theta)
        gamma = np.arccos(np.clip(cosine, F(-1), F(1)))
        theta = np.minimum(theta, LOWEST)
        x, y, bright = (z * perez(k, theta, gamma) for z, k in zip(self._zenith, self._perez, strict=True))
        scale = bright / (y + (y == 0)) * (y != 0)
        return rec709(np.stack([x * scale, bright, (1 - x - y) * scale]))


@lru_cache(maxsize=64)
def daylight(sun: tuple[float, ...], turbidity: float) -> Daylight:
    """The same object for the same settings."""
    return Daylight(sun, turbidity)
