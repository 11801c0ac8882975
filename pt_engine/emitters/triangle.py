"""Emissive triangles, uniform in area, bright on both sides.

pdf = chance / A · t² / |cosθ|          per solid angle, θ between the ray and the triangle's normal
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import dot
from .base import TINY, Draw, Float32, Float64, Index

FEW = 4096  # up to here a gather per column is faster than one of rows
ROUNDING = 4e-6  # of the distance: hit distance, reference point and direction are float32


@dataclass(frozen=True)
class TriangleEmitters:
    """All triangles that emit, in world space relative to the scene's recentring origin.

    Attributes
    ----------
    vertices : (T, 3, 3) float32
        Triangle, corner, coordinate: the very numbers that rays are intersected with.
    radiance : (T, 3) float32
        Le; an estimate where `varies`.
    varies : (T,) bool
        Le changes over the surface, so that the caller evaluates it.
    error : (T,) float32
        Bound of the error of a hit point along the normal, m.
    whose : (T,) int64 or None
        `Visibility` bits of its object, from bit 8 on its set of linked emitters, from bit 32 on its light
        group; None for all alike.
    """

    vertices: Float32
    radiance: Float32
    varies: NDArray[np.bool_]
    error: Float32
    whose: NDArray[np.int64] | None = None

    @property
    def count(self) -> int:
        """T."""
        return len(self.vertices)

    def areas(self) -> Float64:
        """(T,) m²."""
        corner = self.vertices.astype(np.float64)
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        return np.asarray(0.5 * np.sqrt((normal**2).sum(axis=1)), np.float64)


class Triangles:
    """The sampler of some of them: one packed column per triangle.

    Rows 0..2 first corner, 3..5 and 6..8 edges, 9..11 radiance / chance (1 / chance where it varies),
    12 chance, 13 error · area.
    """

    delta = False

    def __init__(self, emitters: TriangleEmitters, rows: Index, chance: Float64) -> None:
        """`rows` says which of `emitters`, `chance` how likely each of them is."""
        p0, p1, p2 = (emitters.vertices[rows, corner].T for corner in range(3))
        self._varies = emitters.varies[rows]
        radiance = emitters.radiance[rows].astype(np.float64)
        radiance[self._varies] = 1.0
        last = [chance[None], (emitters.error * emitters.areas())[rows][None]]
        table = np.concatenate([p0, p1 - p0, p2 - p0, over_chance(radiance, chance), *last])
        self.count = len(rows)
        self._by_column = self.count <= FEW
        self._table = np.ascontiguousarray(table if self._by_column else table.T, np.float32)
        self._rows = rows
        self._any_varies = bool(self._varies.any())

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform points x = p0 + b1·e1 + b2·e2 on triangles `row`; None if there is but one."""
        if row is None:
            row = np.zeros(u.shape, np.intp)
        if self._by_column:
            r = self._table.take(row, axis=1, mode="clip")
        else:
            r = np.ascontiguousarray(self._table.take(row, axis=0, mode="clip").T)
        root = np.sqrt(u)
        b1, b2 = 1.0 - root, v * root
        e1, e2 = r[3:6], r[6:9]
        to = r[0:3] - p
        to += b1 * e1
        to += b2 * e2
        twice = (
            to[0] * (e1[1] * e2[2] - e1[2] * e2[1])
            + to[1] * (e1[2] * e2[0] - e1[0] * e2[2])
            + to[2] * (e1[0] * e2[1] - e1[1] * e2[0])
        )
        draw = draw_toward(to, 0.5 * twice, r[9:12], r[12], r[13])
        if not self._any_varies:
            return draw
        lanes = np.flatnonzero(self._varies.take(row, mode="clip"))
        b = np.stack([b1.take(lanes), b2.take(lanes)])
        return draw._replace(varying=lanes, triangle=self._rows.take(row.take(lanes)), barycentric=b)


def over_chance(radiance: Float64, chance: Float64) -> Float64:
    """(3, K) radiance (K, 3) over the probability of the choice; 0 for what is never chosen."""
    return np.asarray(radiance.T / np.maximum(chance, np.finfo(np.float32).tiny) * (chance > 0.0))


def draw_toward(
    to: Float32, through: Float32, radiance: Float32, chance: Float32, error_area: Float32
) -> Draw:
    """The draw of points on flat emitters, uniform in area.

    Parameters
    ----------
    to : (3, N) float32
        From the reference points to the points drawn; overwritten by the direction.
    through : (N,) float32
        `to` times the emitter's normal, as long as its area.
    radiance : (3, N) or (3, 1) float32
        Le over the chance of the emitter.
    chance, error_area : (N,) or (1,) float32
        That chance; the bound of a hit point's error along the normal, times the area.
    """
    squared: Float32 = np.maximum(dot(to, to), np.float32(1e-24))
    distance: Float32 = np.sqrt(squared)
    to /= distance
    projected: Float32 = np.abs(through)
    projected /= distance  # area · |cos|
    solid = projected / squared
    np.maximum(projected, TINY, out=projected)
    behind = error_area / projected
    behind *= 2.0
    distance *= 1.0 - ROUNDING
    distance -= behind
    pdf = np.maximum(solid, TINY)
    return Draw(
        to, np.maximum(distance, 0.0, out=distance), radiance * solid, np.divide(chance, pdf, out=pdf)
    )
