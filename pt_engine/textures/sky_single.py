"""The sky by single scattering: radiance of the upper half and of the sun, in CIE XYZ.

Nishita et al., *Display of the Earth Taking into Account Atmospheric Scattering* (1993), at 21 wavelengths:
a march along the view ray,

    L(λ) = Σ Tr(A→B) · Tr(B→sun) · Σ_kind σₛ · phase · E_sun · Δs

with the depth toward the sun by Gauss–Laguerre quadrature. Metres. Below the horizon the horizon fades out.
As in Blender, the sky is tabulated once and looked up between; steps and order of operations are its own.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from .sky_multiple import HEIGHT, WIDTH, Air, Number, cosine_of, length, sine

Float32 = NDArray[np.float32]
F = np.float32

EARTH: Final = F(6360e3)  # radius
TOP: Final = F(6420e3)  # of the atmosphere
STEPS: Final = 32
ROWS_AT_ONCE: Final = 4
PI: Final = F(np.pi)
MIE: Final = F(2e-5)  # scattering at sea level, m⁻¹
MIE_EXTINCTION: Final = F(1.11) * MIE
G: Final = F(0.76)
WAVELENGTH_STEP: Final = F(20)  # nm, from 380 to 780

# sun above the atmosphere, W·m⁻²·nm⁻¹
SUN: Final = np.array(
    [
        1.45756830, 1.56596306, 1.65148449, 1.71496242, 1.75797984, 1.78256408, 1.79095108,
        1.78541550, 1.76815555, 1.74122070, 1.70647127, 1.66556087, 1.61993437, 1.57083597,
        1.51932335, 1.46628495, 1.41245853, 1.35844962, 1.30474914, 1.25174963, 1.19975999,
    ],
    np.float32,
)  # fmt: skip
# scattering by air at sea level, 10⁻⁶ m⁻¹
RAYLEIGH: Final = np.array(
    [
        54.24820088, 44.18549867, 36.35151910, 30.17929012, 25.26320227, 21.30859311, 18.09838025,
        15.47057129, 13.30284977, 11.50184784, 9.99557430, 8.72799973, 7.65513701, 6.74217204,
        5.96134126, 5.29034600, 4.71115688, 4.20910481, 3.77218381, 3.39051255, 3.05591532,
    ],
    np.float32,
) * F(1e-6)  # fmt: skip
# absorption by ozone where it is densest, 10⁻⁶ m⁻¹
OZONE: Final = np.array(
    [
        0.00325126850, 0.00585395365, 0.01977191155, 0.07309568763, 0.20084561514, 0.40383958096,
        0.63551335912, 0.96707041181, 1.54797400424, 2.09038647223, 2.46128056165, 2.73551299462,
        2.15125863129, 1.59051840792, 1.12356197980, 0.73527551487, 0.46450130358, 0.33096079921,
        0.22512612293, 0.14879129266, 0.16828623364,
    ],
    np.float32,
) * F(1e-6)  # fmt: skip
# CIE 1931 colour matching functions
MATCHING: Final = np.array(
    [
        0.001368, 0.000039, 0.006450001, 0.01431, 0.000396, 0.06785001, 0.13438, 0.004, 0.6456,
        0.34828, 0.023, 1.74706, 0.2908, 0.06, 1.6692, 0.09564, 0.13902, 0.8129501,
        0.0049, 0.323, 0.272, 0.06327, 0.71, 0.07824999, 0.2904, 0.954, 0.0203,
        0.5945, 0.995, 0.0039, 0.9163, 0.87, 0.001650001, 1.0622, 0.631, 0.0008,
        0.8544499, 0.381, 0.00019, 0.4479, 0.175, 0.00002, 0.1649, 0.061, 0,
        0.04677, 0.017, 0, 0.01135916, 0.004102, 0, 0.002899327, 0.001047, 0,
        0.0006900786, 0.0002492, 0, 0.0001661505, 0.00006, 0, 0.00004150994, 0.00001499, 0,
    ],
    np.float32,
).reshape(21, 3)  # fmt: skip
# Gauss–Laguerre for 8 points, scaled so that the last lies just inside the atmosphere
NODES: Final = np.array(
    [
        0.006811185292, 0.03614807107, 0.09004346519, 0.1706680068,
        0.2818362161, 0.4303406404, 0.6296271457, 0.9145252695,
    ],
    np.float32,
)  # fmt: skip
WEIGHTS: Final = np.array(
    [
        0.01750893642, 0.04135477391, 0.06678839063, 0.09507698807,
        0.1283416365, 0.1707430204, 0.2327233347, 0.3562490486,
    ],
    np.float32,
)  # fmt: skip


def densities(height: Float32) -> tuple[Float32, Float32, Float32]:
    """Of air, aerosols and ozone at heights above sea level, 1 where they are densest.

    Far below ground, where rays to a sun that is not seen may pass, they stay finite.
    """
    height = np.maximum(height, F(-5e4))
    ozone = np.maximum(F(0), 1 - np.abs(height - F(25000)) / F(15000))
    return np.exp(-height / F(8e3)), np.exp(-height / F(1.2e3)), ozone


def to_top(p: tuple[Float32, ...], d: tuple[Float32, ...]) -> Float32:
    """Distance to the top of the atmosphere from points inside."""
    b = 2 * (d[0] * p[0] + d[1] * p[1] + d[2] * p[2])
    c = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - TOP * TOP
    t = (-b + np.sqrt(b * b - 4 * c)) / 2
    x, y, z = ((a + b * t) - a for a, b in zip(p, d, strict=True))  # rounded as the end point is
    return length(x, y, z)


def depth_to_top(p: tuple[Float32, ...], d: tuple[Float32, ...]) -> tuple[Float32, ...]:
    """Optical depths of air, aerosols and ozone, before their coefficients, to the top of the atmosphere."""
    far = to_top(p, d)
    total: list[Float32] = [np.zeros_like(far) for _ in range(3)]
    for node, weight in zip(NODES, WEIGHTS, strict=True):
        height = length(*(a + node * (far * b) for a, b in zip(p, d, strict=True))) - EARTH
        for sum_, density in zip(total, densities(height), strict=True):
            sum_ += density * weight
    return tuple(sum_ * far for sum_ in total)


def meets_earth(p: tuple[Float32, ...], d: tuple[Float32, ...]) -> NDArray[np.bool_]:
    """Whether rays go into the ground."""
    b = 2 * (d[0] * p[0] + d[1] * p[1] + d[2] * p[2])
    c = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - EARTH * EARTH
    meets: NDArray[np.bool_] = (d[2] < 0) & (b * b - 4 * c >= 0)
    return meets


def spectrum(d: Float32, sun: tuple[Float32, ...], height: np.float32, air: Air) -> Float32:
    """(21, n) radiance along unit directions d (3, n), seen from a height over Earth's centre."""
    scale = F(air.molecules), F(air.aerosols), F(air.ozone)
    zero = np.zeros_like(d[0])
    step = to_top((zero, zero, zero + height), (d[0], d[1], d[2])) / F(STEPS)
    mu = d[0] * sun[0] + d[1] * sun[1] + d[2] * sun[2]
    rayleigh_phase = F(0.1875) / PI * (1 + mu * mu)
    mie_phase = (3 * (1 - G * G) * (1 + mu * mu)) / (
        8 * PI * (2 + G * G) * (1 + G * G - 2 * G * mu) ** F(1.5)
    )
    segment = [a * step for a in d]
    p = [F(0.5) * s for s in segment]
    p[2] += height
    depth = [np.zeros_like(zero) for _ in range(3)]
    out = np.zeros((21, d.shape[1]), np.float32)
    for _ in range(STEPS):
        at = (p[0], p[1], p[2])
        density = [k * x for k, x in zip(scale, densities(length(*at) - EARTH), strict=True)]
        for sum_, x in zip(depth, density, strict=True):
            sum_ += step * x
        lit = ~meets_earth(at, sun)
        through = [a + k * b for a, k, b in zip(depth, scale, depth_to_top(at, sun), strict=True)]
        for k in range(21):
            extinction = through[0] * RAYLEIGH[k]
            extinction += through[1] * MIE_EXTINCTION
            extinction += through[2] * OZONE[k]
            scattered = rayleigh_phase * (density[0] * RAYLEIGH[k]) + mie_phase * (density[1] * MIE)
            scattered *= np.exp(-extinction)
            scattered *= SUN[k]
            scattered *= step
            scattered *= lit
            out[k] += scattered
        for a, s in zip(p, segment, strict=True):
            a += s
    return out


def xyz(light: Float32) -> Float32:
    """(3, ...) of (21, ...)."""
    out = np.zeros((3, *light.shape[1:]), np.float32)
    for k in range(21):
        for axis in range(3):
            out[axis] += MATCHING[k, axis] * light[k]
    out *= WAVELENGTH_STEP
    return out


def direction(elevation: Number, azimuth: Number) -> tuple[Float32, ...]:
    """Unit vectors."""
    cos = cosine_of(elevation)
    return cos * cosine_of(azimuth), cos * sine(azimuth), sine(elevation)


def sky(sun_elevation: float, altitude: float, air: Air) -> Float32:
    """(HEIGHT, WIDTH, 3) XYZ radiance; rows and columns as in `sky_multiple.sky`, but texel j, i is the
    direction at its own corner: elevation (j / 128 − 1)²·π/2."""
    half = HEIGHT // 2
    height = EARTH + F(min(max(altitude, 1.0), 59999.0))
    sun = direction(F(sun_elevation), F(0))
    elevation = F(np.pi / 2) * np.square(np.arange(HEIGHT, dtype=np.float32) / F(half) - 1)
    azimuth = F(2 * np.pi) / F(WIDTH) * np.arange(WIDTH // 2, dtype=np.float32) - PI
    out = np.empty((HEIGHT, WIDTH, 3), np.float32)
    for first in range(half, HEIGHT, ROWS_AT_ONCE):
        rows = slice(first, first + ROWS_AT_ONCE)
        e, a = np.broadcast_arrays(elevation[rows, None], azimuth)
        d = np.stack(direction(e, a)).reshape(3, -1)
        light = xyz(spectrum(d, sun, height, air)).reshape(3, *e.shape).transpose(1, 2, 0)
        out[rows, : WIDTH // 2], out[rows, WIDTH // 2 :] = light, light[:, ::-1]
    fade = np.maximum(1 - np.sin(elevation[:half]) * F(2.5), F(0)) ** 3
    out[:half] = out[half] * fade[:, None, None]
    return out


def sun_disc(elevation: float, diameter: float, altitude: float, air: Air) -> tuple[Float32, Float32]:
    """(3,) XYZ radiance at the bottom and at the top of the sun's disc; black below the horizon."""
    half = F(diameter) / 2
    ends = np.maximum(F(elevation) + np.array([-half, half], np.float32), F(0))
    if ends[1] <= 0:
        return np.zeros(3, np.float32), np.zeros(3, np.float32)
    d = direction(ends, np.zeros(2, np.float32))
    zero = np.zeros(2, np.float32)
    height = zero + EARTH + F(min(max(altitude, 1.0), 59999.0))
    depth = depth_to_top((zero, zero, height), d)
    light = np.empty((21, 2), np.float32)
    solid_angle = 2 * PI * (1 - cosine_of(half))
    for k in range(21):
        extinction = RAYLEIGH[k] * depth[0] * F(air.molecules)
        extinction += MIE_EXTINCTION * depth[1] * F(air.aerosols)
        light[k] = SUN[k] * np.exp(-extinction) / solid_angle
    bottom, top = xyz(light).T
    return bottom, top
