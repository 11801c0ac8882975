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
    """

    vertices: Float32
    radiance: Float32
    varies: NDArray[np.bool_]
    error: Float32

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
    """The sampler: one packed column per triangle.

    Rows 0..2 first corner, 3..5 and 6..8 edges, 9..11 radiance / chance (1 / chance where it varies),
    12 chance, 13 error · area.
    """

    delta = False

    def __init__(self, emitters: TriangleEmitters, chance: Float64) -> None:
        p0, p1, p2 = (emitters.vertices[:, corner].T for corner in range(3))
        area = emitters.areas()
        safe = np.maximum(chance, np.finfo(np.float32).tiny)
        radiance = emitters.radiance.astype(np.float64)
        radiance[emitters.varies] = 1.0
        last = [chance[None], emitters.error[None] * area[None]]
        table = np.concatenate([p0, p1 - p0, p2 - p0, radiance.T / safe, *last])
        table[9:12, chance == 0.0] = 0.0
        self._table = np.ascontiguousarray(table if emitters.count <= FEW else table.T, np.float32)
        self._by_column = emitters.count <= FEW
        self._chance_over_area = (chance / np.maximum(area, TINY)).astype(np.float32)
        self.count = emitters.count
        self._varies = emitters.varies
        self._any_varies = bool(emitters.varies.any())

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
        wo = r[0:3] - p
        wo += b1 * e1
        wo += b2 * e2
        squared = np.maximum(dot(wo, wo), 1e-24)
        distance = np.sqrt(squared)
        wo /= distance
        twice = (
            wo[0] * (e1[1] * e2[2] - e1[2] * e2[1])
            + wo[1] * (e1[2] * e2[0] - e1[0] * e2[2])
            + wo[2] * (e1[0] * e2[1] - e1[1] * e2[0])
        )
        projected = 0.5 * np.abs(twice)  # area · |cos|
        solid = projected / squared
        projected = np.maximum(projected, TINY)
        clear = distance - ROUNDING * distance - 2.0 * (r[13] / projected)
        pdf = r[12] / np.maximum(solid, TINY)
        draw = Draw(wo, np.maximum(clear, 0.0), r[9:12] * solid, pdf)
        if not self._any_varies:
            return draw
        lanes = np.flatnonzero(self._varies.take(row, mode="clip"))
        b = np.stack([b1.take(lanes), b2.take(lanes)])
        return draw._replace(varying=lanes, triangle=row.take(lanes), barycentric=b)

    def pdf(self, triangle: NDArray[np.integer], t: Float32, cos_light: Float32) -> Float32:
        """(n,) density of `sample` for a ray that meets `triangle` after `t` at |cos| `cos_light`."""
        density = self._chance_over_area.take(triangle, mode="clip")
        density *= t * t
        density /= np.maximum(cos_light, 1e-12)
        return density
