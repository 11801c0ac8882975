"""Warps of the unit square, in triads: square_to_X, X_to_square, X_pdf.

Each maps independent uniforms u, v (N,) in [0, 1) onto X with the density X_pdf, smoothly and without
overlap, so that stratified numbers give stratified points; X_to_square inverts it. Directions are (3, N)
with the pole along +Z, planar points (2, N). Densities are per solid angle, or per area in the plane.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]

PI = float(np.pi)
INV_PI = 1.0 / PI
INV_2PI = 0.5 / PI
INV_4PI = 0.25 / PI


# ------------------------------------------------------------------------- disk of radius 1


def square_to_disk(u: Float32, v: Float32) -> Float32:
    """Concentric map (Shirley and Chiu 1997): squares about the centre become circles."""
    _, along, across, mask = _concentric(u, v)
    return np.stack([mask * along + (1.0 - mask) * across, mask * across + (1.0 - mask) * along])


def disk_to_square(p: Float32) -> tuple[Float32, Float32]:
    x, y = p
    mask = (np.abs(x) > np.abs(y)).astype(np.float32)
    major = mask * x + (1.0 - mask) * y
    minor = mask * y + (1.0 - mask) * x
    a = np.copysign(np.sqrt(x * x + y * y), major)
    b = a * (4.0 * INV_PI) * np.arctan(minor / (major + (major == 0)))
    return 0.5 * (mask * a + (1.0 - mask) * b) + 0.5, 0.5 * (mask * b + (1.0 - mask) * a) + 0.5


def disk_pdf(p: Float32) -> Float32:
    inside: Float32 = (p[0] * p[0] + p[1] * p[1] <= 1.0).astype(np.float32)
    return inside * np.float32(INV_PI)


def _concentric(u: Float32, v: Float32) -> tuple[Float32, Float32, Float32, Float32]:
    """Signed radius, coordinates along and across the nearer axis, and 1 where that axis is x."""
    a, b = 2.0 * u - 1.0, 2.0 * v - 1.0
    mask = (np.abs(a) > np.abs(b)).astype(np.float32)
    radius: Float32 = mask * a + (1.0 - mask) * b
    other = mask * b + (1.0 - mask) * a
    angle = (0.25 * PI) * other / (radius + (radius == 0))
    return radius, radius * np.cos(angle), radius * np.sin(angle), mask


# ------------------------------------------------------------------------- cosine-weighted hemisphere


def square_to_cosine_hemisphere(u: Float32, v: Float32) -> Float32:
    """Malley's method: the disk, lifted. z is never 0, so that value / pdf stays finite."""
    radius, along, across, mask = _concentric(u, v)
    # (1 − r)(1 + r) keeps the digits near the horizon, where the least z above 0 is 2⁻¹¹.
    z = np.maximum(np.sqrt((1.0 - radius) * (1.0 + radius)), 2.0**-12)
    return np.stack([mask * along + (1.0 - mask) * across, mask * across + (1.0 - mask) * along, z])


def cosine_hemisphere_to_square(w: Float32) -> tuple[Float32, Float32]:
    return disk_to_square(w[:2])


def cosine_hemisphere_pdf(w: Float32) -> Float32:
    """cosθ / π above the horizon."""
    pdf: Float32 = np.maximum(w[2], 0.0) * np.float32(INV_PI)
    return pdf


# ------------------------------------------------------------------------- uniform hemisphere


def square_to_hemisphere(u: Float32, v: Float32) -> Float32:
    """z = 1 − u, φ = 2π v: equal areas (Archimedes)."""
    return _at(u, v)


def hemisphere_to_square(w: Float32) -> tuple[Float32, Float32]:
    return _one_minus_z(w), _azimuth(w)


def hemisphere_pdf(w: Float32) -> Float32:
    above: Float32 = (w[2] >= 0).astype(np.float32)
    return above * np.float32(INV_2PI)


# ------------------------------------------------------------------------- uniform sphere


def square_to_sphere(u: Float32, v: Float32) -> Float32:
    """z = 1 − 2u, φ = 2π v."""
    return _at(2.0 * u, v)


def sphere_to_square(w: Float32) -> tuple[Float32, Float32]:
    return 0.5 * _one_minus_z(w), _azimuth(w)


def sphere_pdf(w: Float32) -> Float32:
    return np.full(w.shape[1:], INV_4PI, np.float32)


# ------------------------------------------------------------------------- uniform cone about +Z


def square_to_cone(u: Float32, v: Float32, one_minus_cos: Float32 | float) -> Float32:
    """Directions within the angle whose 1 − cosθ is given.

    1 − cosθ, not cosθ: for θ = 0.001 the cosine has one correct digit left in float32, this has them all.
    Take it as sin²θ / (1 + cosθ) or 2 sin²(θ/2).
    """
    return _at(u * one_minus_cos, v)


def cone_to_square(w: Float32, one_minus_cos: Float32 | float) -> tuple[Float32, Float32]:
    return _one_minus_z(w) / one_minus_cos, _azimuth(w)


def cone_pdf(w: Float32, one_minus_cos: Float32 | float) -> Float32:
    inside: Float32 = (_one_minus_z(w) <= one_minus_cos).astype(np.float32)
    return inside * np.float32(INV_2PI) / one_minus_cos


# ------------------------------------------------------------------------- triangle


def square_to_triangle(u: Float32, v: Float32) -> Float32:
    """Barycentric coordinates (b₁, b₂) ≥ 0 with b₁ + b₂ ≤ 1: s = √u, b = (1 − s, v s)."""
    s = np.sqrt(u)
    return np.stack([1.0 - s, v * s])


def triangle_to_square(b: Float32) -> tuple[Float32, Float32]:
    s = 1.0 - b[0]
    return s * s, b[1] / (s + (s == 0))


def triangle_pdf(b: Float32) -> Float32:
    """2, per area in (b₁, b₂); divide by twice the triangle's area for a density on it."""
    inside: Float32 = ((b[0] >= 0) & (b[1] >= 0) & (b[0] + b[1] <= 1)).astype(np.float32)
    return inside * np.float32(2.0)


# ------------------------------------------------------------------------- regular polygon, circumradius 1


def square_to_polygon(u: Float32, v: Float32, corners: int, rotation: float = 0.0) -> Float32:
    """Aperture with straight blades: u picks one of the triangles about the centre, and is used again.

    Sector k is centred on rotation + 2πk / corners, so the rotation points at the middle of an edge,
    as in Cycles.
    """
    half = PI / corners
    scaled = u * np.float32(corners)
    sector = np.minimum(np.floor(scaled), corners - 1.0)
    s = np.sqrt(scaled - sector)
    b = v * s
    x, y = (1.0 - s + b) * float(np.cos(half)), (1.0 - s - b) * float(np.sin(half))
    turn = sector * (2.0 * half) + rotation
    c, d = np.cos(turn), np.sin(turn)
    return np.stack([c * x - d * y, d * x + c * y])


def polygon_to_square(p: Float32, corners: int, rotation: float = 0.0) -> tuple[Float32, Float32]:
    half = PI / corners
    angle = (np.arctan2(p[1], p[0]) - (rotation - half)) * (0.5 * INV_PI)
    sector = np.minimum(np.floor((angle - np.floor(angle)) * corners), corners - 1.0)
    x, y = _unrotate(p, sector * (2.0 * half) + rotation)
    x, y = x * (0.5 / float(np.cos(half))), y * (0.5 / float(np.sin(half)))
    s = np.clip(1.0 - (x + y), 0.0, 1.0)
    return (sector + s * s) * (1.0 / corners), np.clip((x - y) / (s + (s == 0)), 0.0, 1.0)


def polygon_pdf(p: Float32, corners: int, rotation: float = 0.0) -> Float32:
    """1 / area = 2 / (n sin(2π/n)) within the apothem of the sector's edge."""
    half = PI / corners
    angle = (np.arctan2(p[1], p[0]) - (rotation - half)) * (0.5 * INV_PI)
    sector = np.floor((angle - np.floor(angle)) * corners)
    x, _ = _unrotate(p, sector * (2.0 * half) + rotation)
    inside: Float32 = (x <= float(np.cos(half))).astype(np.float32)
    return inside * np.float32(2.0 / (corners * np.sin(2.0 * half)))


def _unrotate(p: Float32, turn: Float32) -> tuple[Float32, Float32]:
    c, d = np.cos(turn), np.sin(turn)
    return c * p[0] + d * p[1], c * p[1] - d * p[0]


# ------------------------------------------------------------------------- shared


def _at(h: Float32, v: Float32) -> Float32:
    """Direction with 1 − cosθ = h and φ = 2π v; sinθ = √(h (2 − h)) does not cancel."""
    sin_theta = np.sqrt(h * (2.0 - h))
    phi = v * np.float32(2.0 * PI)
    w = np.empty((3, *phi.shape), phi.dtype)
    np.multiply(sin_theta, np.cos(phi), out=w[0])
    np.multiply(sin_theta, np.sin(phi), out=w[1])
    np.subtract(1.0, h, out=w[2])
    return w


def _one_minus_z(w: Float32) -> Float32:
    """1 − cosθ of a unit vector, by sin²θ / (1 + |cosθ|), which does not cancel near the poles."""
    h: Float32 = (w[0] * w[0] + w[1] * w[1]) / (1.0 + np.abs(w[2]))
    below: Float32 = (w[2] < 0).astype(np.float32)
    return h + below * (2.0 - 2.0 * h)


def _azimuth(w: Float32) -> Float32:
    """φ / 2π in [0, 1)."""
    turns: Float32 = np.arctan2(w[1], w[0]) * np.float32(INV_2PI)
    return turns - np.floor(turns)
