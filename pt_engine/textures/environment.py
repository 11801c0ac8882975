"""Directions to uv of environment maps, as Blender lays them out.

Equirectangular: the image's centre is −Y… seen from inside, u = (π − φ)/2π with φ = atan2(y, x), and
v = 1 − θ/π with θ from +Z. Mirror ball: a chrome sphere photographed along +Y.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
PI = np.float32(np.pi)


def equirectangular_uv(d: Float32) -> tuple[Float32, Float32]:
    """uv of unit directions (3, n)."""
    u = (PI - np.arctan2(d[1], d[0])) * np.float32(0.5 / np.pi)
    v = 1 - np.arccos(np.minimum(np.maximum(d[2], -1), 1)) * np.float32(1 / np.pi)
    return u, v


def equirectangular_direction(u: Float32, v: Float32) -> Float32:
    """(3, n) unit directions; the inverse of `equirectangular_uv`."""
    phi, theta = PI - u * np.float32(2 * np.pi), PI * (1 - v)
    sin = np.sin(theta)
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), np.cos(theta)])


def mirror_ball_uv(d: Float32) -> tuple[Float32, Float32]:
    """uv of unit directions (3, n): where on the ball they are reflected toward −Y… its viewer."""
    y = d[1] - 1
    scale = 2 * np.sqrt(np.maximum(-0.5 * y, 0))
    scale = 1 / (scale + (scale == 0))
    return 0.5 * (d[0] * scale + 1), 0.5 * (d[2] * scale + 1)


def mirror_ball_direction(u: Float32, v: Float32) -> Float32:
    """(3, n) unit directions; the inverse of `mirror_ball_uv`. Zero outside the ball's disc."""
    x, z = 2 * u - 1, 2 * v - 1
    r2 = x * x + z * z
    y = -np.sqrt(np.maximum(1 - r2, 0))
    inside = r2 <= 1
    return np.stack([-2 * y * x, 1 - 2 * y * y, -2 * y * z]) * inside
