"""Where rays meet ribbons, tubes, cones with spheres, and spheres: closed forms, in float64.

A piece of a curve runs from P0 to P1, its radius from r0 to r1, its axis is a. A ray X = w + t d starts at
w from P0. Surfaces are met from outside, tubes from within too, where a ray has come in through an open
end. Rays never meet the curve again that they start on (`round_accel`).

**Tube** (THICK). With y = X·a and ρ(y) = r0 + k y, k = (r1 − r0)/L, the cone |X − y a|² = ρ² is a quadratic
in t,

    A = d⊥² − k² d_a²,    B = w⊥·d⊥ − k d_a ρ(w_a),    C = w⊥² − ρ(w_a)²,    t = (−B ∓ √(B² − AC))/A

for the ways in and out, cut by the planes across the curve through P0 and P1, which neighbouring pieces
share (normals of any length). With f0 and f1 the distances from them, in those of the other end, s =
f0/(f0 + f1) is how far along the piece X is.

**Ribbon** (RIBBON). Flat and turned to the ray: in the plane across d these planes' traces are lines, and
f0, f1 and s the same for them. There the ribbon reaches from the axis by h = (1 − s) r0 h0 + s r1 h1 to
both sides, h0 and h1 along the traces; v = X·h/h², and the ray hits where |v| ≤ 1, at the axis' depth. As
in Embree, a ribbon within 2r of a ray's origin is not there: else all rays would end at once where they
begin.

**Cone and spheres** (LINEAR). The spheres around P0 and P1 and the cone that touches both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]

RIBBON, THICK, LINEAR, SPHERE = range(4)
# Columns of a piece's row
P0, R0, P1, R1, BEGIN, END, KIND = slice(0, 3), 3, slice(4, 7), 7, slice(8, 11), slice(11, 14), 14
COLUMNS = 16
AVOIDED = 2.0  # radii from a ray's origin within which ribbons are not there
NEVER = np.inf
ENOUGH = 1 + 1e-6  # of a square, for rounding


class Met(NamedTuple):
    """Where rays meet their pieces.

    Attributes
    ----------
    t : (N,) float64
        Infinite for those that don't.
    s, v : (N,) float32
        How far along the piece, in [0, 1]; where across a ribbon, in [−1, 1].
    """

    t: Float64
    s: Float32
    v: Float32


def meet(rows: Float32, kinds: tuple[int, ...], o: Float32, d: Float32, near: Float32) -> Met:
    """Rays (3, N), each against the piece in its row (N, 16).

    Parameters
    ----------
    kinds : tuple of int
        Which occur at all.
    near : (N,) float32
        A t near the piece; the ray is looked at from there, which costs fewer digits.
    """
    if len(kinds) == 1:
        return MEETS[kinds[0]](rows, o, d, near)
    zero = np.zeros(len(rows), np.float32)
    found = Met(np.full(len(rows), NEVER), zero, zero.copy())
    for kind in kinds:
        lanes = np.flatnonzero(rows[:, KIND] == kind)
        if len(lanes):
            part = MEETS[kind](rows[lanes], o.take(lanes, axis=1), d.take(lanes, axis=1), near.take(lanes))
            found.t[lanes], found.s[lanes], found.v[lanes] = part
    return found


class Relative(NamedTuple):
    """A ray from where it is near a piece, about P0: w = o + near·d − P0, P1 − P0."""

    w: Float64
    d: Float64
    along: Float64
    near: Float64
    r0: Float64
    r1: Float64


def relative(rows: Float32, o: Float32, d: Float32, near: Float32) -> Relative:
    """In float64, and (3, N)."""
    row = np.ascontiguousarray(rows.T).astype(np.float64)
    direction, t = d.astype(np.float64), near.astype(np.float64)
    w = o + t * direction - row[P0]
    return Relative(w, direction, row[P1] - row[P0], t, row[R0], row[R1])


def dot(a: Float64, b: Float64) -> Float64:
    """(N,)."""
    total: Float64 = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return total


def cross(a: Float64, b: Float64) -> Float64:
    """(3, N)."""
    return np.stack([a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)])


def plane(rows: Float32, columns: slice) -> Float64:
    """(3, N) normals of the planes where pieces begin or end."""
    return np.ascontiguousarray(rows[:, columns].T).astype(np.float64)


def entry(a: Float64, b: Float64, c: Float64) -> Float64:
    """The root at which a t² + 2 b t + c falls below 0, NaN where it never does.

    That is (−b − √)/a for any a: the smaller root for a > 0; a ray along a cone, nearer to its axis than its
    side is, has a < 0 and enters it at the larger one.
    """
    inside = b * b - a * c
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(inside)
        # −b − √ cancels where b < 0: then c over the other numerator, −b + √, as their product is a c
        t = np.where(b > 0, -(b + root) / a, c / (root - b))
    return np.asarray(np.where((inside >= 0) & ((a != 0) | (b < 0)), t, np.nan))


def leaving(a: Float64, b: Float64, c: Float64) -> Float64:
    """The other root of `entry`: (−b + √)/a."""
    inside = b * b - a * c
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(inside)
        t = np.where(b > 0, -c / (b + root), (root - b) / a)
    return np.asarray(np.where((inside >= 0) & ((a != 0) | (b > 0)), t, np.nan))


def meet_thick(rows: Float32, o: Float32, d: Float32, near: Float32) -> Met:
    """Tubes, open at their ends: the outer wall, or the inner one where there is none before it."""
    ray = relative(rows, o, d, near)
    length = np.sqrt(dot(ray.along, ray.along))
    axis = ray.along / length
    k = (ray.r1 - ray.r0) / length
    w_a, d_a = dot(ray.w, axis), dot(ray.d, axis)
    w, across = ray.w - w_a * axis, ray.d - d_a * axis
    rho = ray.r0 + k * w_a
    a = dot(across, across) - (k * d_a) ** 2
    b = dot(w, across) - k * d_a * rho
    c = dot(w, w) - rho * rho
    begin, end = plane(rows, BEGIN), plane(rows, END)
    best, best_s = np.full(len(rows), NEVER), np.zeros(len(rows))
    with np.errstate(invalid="ignore"):
        for wall in (entry, leaving):
            t = wall(a, b, c)
            x = ray.w + t * ray.d
            f0, f1 = dot(x, begin) / dot(ray.along, begin), dot(ray.along - x, end) / dot(ray.along, end)
            hit = (f0 >= 0) & (f1 >= 0) & (ray.r0 + k * (w_a + t * d_a) > 0) & (t + ray.near > 0)
            hit &= best == NEVER
            best, best_s = np.where(hit, t + ray.near, best), np.where(hit, f0 / (f0 + f1), best_s)
    return Met(best, best_s.astype(np.float32), np.zeros(len(t), np.float32))


def meet_ribbon(rows: Float32, o: Float32, d: Float32, near: Float32) -> Met:
    """Ribbons that face their ray."""
    ray = relative(rows, o, d, near)
    begin, end = plane(rows, BEGIN), plane(rows, END)
    with np.errstate(invalid="ignore", divide="ignore"):
        # a plane's trace across d; the part of its normal along d moves the ray, which has no place there
        for normal in (begin, end):
            normal -= dot(normal, ray.d) * ray.d
            normal /= np.sqrt(dot(normal, normal))
        f0 = dot(ray.w, begin) / dot(ray.along, begin)
        f1 = dot(ray.along - ray.w, end) / dot(ray.along, end)
        s = f0 / (f0 + f1)
        edge = cross(ray.d, (1 - s) * ray.r0 * begin + s * ray.r1 * end)
        off = ray.w - s * ray.along
        depth = dot(off, ray.d)
        v = dot(off, edge) / dot(edge, edge)
        t = ray.near - depth
        r = ray.r0 + s * (ray.r1 - ray.r0)
        aside = dot(off, off) - depth * depth
        hit = (f0 >= 0) & (f1 >= 0) & (np.abs(v) <= 1) & (t > AVOIDED * r)
        # else the ray sees it end on, and the traces meet within the ribbon
        hit &= (dot(ray.along, begin) > 0) & (dot(ray.along, end) > 0) & (aside <= ENOUGH * r * r)
    zero = np.float32(0)
    return Met(
        np.where(hit, t, NEVER),
        np.where(hit, s, zero).astype(np.float32),
        np.where(hit, v, zero).astype(np.float32),
    )


def meet_sphere(rows: Float32, o: Float32, d: Float32, near: Float32) -> Met:
    """Spheres about P0."""
    ray = relative(rows, o, d, near)
    t = sphere_root(ray.w, ray.d, ray.r0) + ray.near
    zero = np.zeros(len(t), np.float32)
    with np.errstate(invalid="ignore"):
        return Met(np.where(t > 0, t, NEVER), zero, zero.copy())


def sphere_root(w: Float64, d: Float64, r: Float64) -> Float64:
    """t at which w + t d enters a sphere about 0, NaN for never."""
    return entry(dot(d, d), dot(w, d), dot(w, w) - r * r)


def meet_linear(rows: Float32, o: Float32, d: Float32, near: Float32) -> Met:
    """Cones that touch the spheres at both ends, and these; a sphere between pieces where it shows.

    With g = L² − (r1 − r0)² and y = X·(P1 − P0) + r0 (r1 − r0), the cone is g (X² − r0²) = y² for 0 ≤ y ≤
    g, and the foot of its normal is y/g along the axis. Between pieces the planes halve the angles; at
    curves' own ends there is none.
    """
    ray = relative(rows, o, d, near)
    dr = ray.r1 - ray.r0
    g = dot(ray.along, ray.along) - dr * dr
    w_y, d_y = dot(ray.w, ray.along) + ray.r0 * dr, dot(ray.d, ray.along)
    a = g * dot(ray.d, ray.d) - d_y * d_y
    b = g * dot(ray.w, ray.d) - w_y * d_y
    c = g * (dot(ray.w, ray.w) - ray.r0**2) - w_y * w_y
    with np.errstate(invalid="ignore", divide="ignore"):
        t = entry(a, b, c)
        y = w_y + t * d_y
        cone = (g > 0) & (y >= 0) & (y <= g)
        best, s = np.where(cone, t, NEVER), np.where(cone, y / g, 0.0)
        length = np.sqrt(dot(ray.along, ray.along))
        for at, r, beyond, columns in (
            (np.zeros_like(ray.along), ray.r0, -1.0, BEGIN),
            (ray.along, ray.r1, 1.0, END),
        ):
            t = sphere_root(ray.w - at, ray.d, r)
            y = w_y + t * d_y
            x = ray.w + t * ray.d - at
            halving = plane(rows, columns)
            other = 2 * dot(halving, ray.along) * halving - ray.along  # the neighbour's direction
            shows = (y > g) if beyond > 0 else (y < 0)
            shows &= (beyond * dot(x, other) <= length * r * 1e-9) | ~halving.any(axis=0)
            closer = shows & (t + ray.near > 0) & ((t < best) | (best + ray.near <= 0))
            best, s = np.where(closer, t, best), np.where(closer, float(beyond > 0), s)
        t = best + ray.near
        hit = t > 0
    return Met(np.where(hit, t, NEVER), np.where(hit, s, 0).astype(np.float32), np.zeros(len(t), np.float32))


MEETS = {RIBBON: meet_ribbon, THICK: meet_thick, LINEAR: meet_linear, SPHERE: meet_sphere}
