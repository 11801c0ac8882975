"""Curves as straight pieces: Catmull-Rom splines sampled where they are bent.

With the neighbours a, d of the points b, c (themselves at a curve's ends) a segment is

    2 P(u) = −u(1−u)² a + (2 + u²(3u − 5)) b + (2 + v²(3v − 5)) c − u²(1−u) d,        v = 1 − u

for positions and radii alike. n chords stay within max|P''|/8n² of it; P'' is linear in u, so its ends
bound it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .geometry import near
from .snapshot import CurvesData
from .vertex_normals import unit_rows

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]

FLAT = 0.05  # of the radius is how far chords may stray from the spline
FINEST = 8  # pieces of a round segment; of a ribbon's the file says how many
SHARP = 0.25  # cosine of half the angle between pieces, below which its own direction counts


@dataclass(frozen=True)
class Samples:
    """Points along curves, in object space, and the straight pieces between them.

    Attributes
    ----------
    points : (S, 3) float32
    radius : (S,) float32
    curve, key : (S,) int32
        The curve, and the point at or before the sample.
    fraction : (S,) float32
        How far it is to the next point.
    tangent : (S, 3) float32
        P' by u.
    step : (S,) float32
        How much u grows until the next sample.
    start : (K,) int32
        Sample at which each piece begins; it ends at the next.
    """

    points: Float32
    radius: Float32
    curve: Int32
    key: Int32
    fraction: Float32
    tangent: Float32
    step: Float32
    start: Int32

    def by_point(self, values: Float32) -> Float32:
        """(S, ...) values of points, linear in between as in Cycles."""
        after = np.minimum(self.key + 1, len(values) - 1)
        f = self.fraction.reshape(-1, *[1] * (values.ndim - 1))
        blended: Float32 = values[self.key] * (1 - f) + values[after] * f
        return np.where(f == 0, values[self.key], blended)


def sampled(curves: CurvesData) -> Samples:
    """Sample every curve; pieces without length, without radius or with NaN do not exist."""
    of_curve = curve_of_points(curves)
    ends = curves.first[1:][of_curve] - 1
    here = np.arange(len(curves.points))
    pieces = np.ones(len(here), np.int64)
    if curves.shape != "LINEAR":
        limit = curves.subdivisions + 1 if curves.shape == "RIBBON" else FINEST
        pieces = needed(*controls(curves), limit)
    pieces[here == ends] = 1
    at = np.repeat(here, pieces)
    step = np.arange(len(at)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    u = step / pieces[at]
    points, tangent = along_splines(curves, at, u)
    new = distinct(points[:, :3], of_curve[at])
    points, at, u, tangent = points[new], at[new], u[new], tangent[new]
    with np.errstate(invalid="ignore", over="ignore"):
        good = near(points) & np.isfinite(points[:, 3])
    together = (of_curve[at[1:]] == of_curve[at[:-1]]) & good[1:] & good[:-1]
    together &= np.maximum(points[1:, 3], points[:-1, 3]) > 0
    return Samples(
        np.ascontiguousarray(points[:, :3]),
        np.ascontiguousarray(points[:, 3]),
        of_curve[at].astype(np.int32),
        at.astype(np.int32),
        u.astype(np.float32),
        np.ascontiguousarray(tangent[:, :3]),
        (1 / pieces[at]).astype(np.float32),
        np.flatnonzero(together).astype(np.int32),
    )


def resampled(curves: CurvesData, samples: Samples) -> Samples:
    """The same samples of curves whose points are elsewhere now, whatever pieces these would call for."""
    points, tangent = along_splines(curves, samples.key, samples.fraction.astype(np.float64))
    place, radius = np.ascontiguousarray(points[:, :3]), np.ascontiguousarray(points[:, 3])
    return replace(samples, points=place, radius=radius, tangent=np.ascontiguousarray(tangent[:, :3]))


def curve_of_points(curves: CurvesData) -> NDArray[np.intp]:
    """(P,) which curve each point is of."""
    return np.repeat(np.arange(len(curves.first) - 1), np.diff(curves.first))


def controls(curves: CurvesData) -> tuple[Float64, Float64, Float64, Float64]:
    """a, b, c, d (P, 4) of the segment that begins at each point, with radii."""
    of_curve, here = curve_of_points(curves), np.arange(len(curves.points))
    begin, end = curves.first[of_curve], curves.first[1:][of_curve] - 1
    key = np.concatenate([curves.points, np.maximum(curves.radius, 0)[:, None]], axis=1).astype(np.float64)
    before, after = np.maximum(here - 1, begin), np.minimum(here + 1, end)
    return key[before], key, key[after], key[np.minimum(here + 2, end)]


def along_splines(curves: CurvesData, at: NDArray[np.integer], u: Float64) -> tuple[Float32, Float32]:
    """(S, 4) points with radii at u of the segments from points `at`, and derivatives (S, 4)."""
    a, b, c, d = controls(curves)
    of_curve = curve_of_points(curves)[at]
    begin, end = curves.first[of_curve], curves.first[1:][of_curve] - 1
    points = in_float32(spline(a[at], b[at], c[at], d[at], u[:, None]))
    points[:, 3] = np.maximum(points[:, 3], 0)
    last = at == end
    back = np.where(last, np.maximum(at - 1, begin), at)  # a curve's end ends a segment
    return points, in_float32(slope(a[back], b[back], c[back], d[back], np.where(last, 1.0, u)[:, None]))


def in_float32(values: Float64) -> Float32:
    """Infinite beyond its range; points there are left out."""
    with np.errstate(over="ignore"):
        return values.astype(np.float32)


def spline(a: Float64, b: Float64, c: Float64, d: Float64, u: Float64) -> Float64:
    """P(u)."""
    v = 1 - u
    with np.errstate(invalid="ignore", over="ignore"):
        sides = -u * v * v * a - u * u * v * d
        middle = (2 + u * u * (3 * u - 5)) * b + (2 + v * v * (3 * v - 5)) * c
        return np.asarray(0.5 * (sides + middle))


def slope(a: Float64, b: Float64, c: Float64, d: Float64, u: Float64) -> Float64:
    """P'(u)."""
    v = 1 - u
    with np.errstate(invalid="ignore", over="ignore"):
        sides = (2 * u * v - v * v) * a + (u * u - 2 * u * v) * d
        middle = (9 * u * u - 10 * u) * b + (10 * v - 9 * v * v) * c
        return np.asarray(0.5 * (sides + middle))


def needed(a: Float64, b: Float64, c: Float64, d: Float64, limit: int) -> NDArray[np.int64]:
    """(P,) pieces of the segments from b to c."""
    with np.errstate(invalid="ignore", over="ignore", divide="ignore"):
        bends = [2 * a - 5 * b + 4 * c - d, 2 * d - 5 * c + 4 * b - a]
        bend = np.maximum(*(np.sqrt((x[:, :3] ** 2).sum(axis=1)) for x in bends))
        stray = FLAT * np.maximum(b[:, 3], c[:, 3])
        pieces = np.ceil(np.sqrt(bend / (8 * stray)))
    return np.clip(np.nan_to_num(pieces, nan=1, posinf=limit), 1, limit).astype(np.int64)


def distinct(points: Float32, curve: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Which points are not where their curve's last one was."""
    new = np.ones(len(points), np.bool_)
    with np.errstate(invalid="ignore", over="ignore"):
        step = np.abs(points[1:] - points[:-1]).max(axis=1)
        size = np.abs(points[1:]).max(axis=1)
        new[1:] = (curve[1:] != curve[:-1]) | ~(step <= size * np.float32(2.0**-22))
    return new


def tangents(points: Float32, samples: Samples) -> tuple[Float64, Float64]:
    """(K, 3) the spline's derivatives where each piece begins and ends, by the way along the piece.

    Where there is none, or one that leads elsewhere than the piece, the piece's own direction. `points` (S,
    3) and `samples.tangent` may both have been moved by a matrix.
    """
    start = samples.start
    along = points[start + 1].astype(np.float64) - points[start]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    both = []
    for sample in (start, start + 1):
        slope = samples.tangent[sample] * samples.step[start][:, None].astype(np.float64)
        size = np.linalg.norm(slope, axis=1, keepdims=True)
        lost = ~((slope * along).sum(axis=1, keepdims=True) >= SHARP * size * length) | ~(size > 0)
        both.append(np.where(lost, along, slope))
    return both[0], both[1]


def bisectors(points: Float32, start: Int32) -> tuple[Float64, Float64]:
    """(K, 3) unit normals of planes that halve the angles to each piece's neighbours; 0 without."""
    along = unit_rows(points[start + 1].astype(np.float64) - points[start])
    begins, ends = np.zeros((len(points), 3)), np.zeros((len(points), 3))
    begins[start], ends[start + 1] = along, along
    joint = (begins.any(axis=1) & ends.any(axis=1))[:, None]
    halves = unit_rows(begins + ends) * joint
    return halves[start], halves[start + 1]
