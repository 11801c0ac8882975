"""Emissive parallelograms: two triangles of one lamp's quad, drawn as one.

    x = c + u·e1 + v·e2          pdf = chance / A · t² / |cosθ|, as for the two triangles apart

A quad is what most lamps made of meshes are. As one emitter it needs no root, keeps the stratification of
(u, v), and a scene with no other has nothing to choose.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import dot
from .base import Draw, Float32, Float64, Index, at
from .triangle import TriangleEmitters, draw_toward, over_chance

CLOSED = 2.0**-21  # of the largest coordinate: how far placing a quad in the world may bend it


class Parallelograms:
    """The sampler: one packed column per parallelogram.

    Rows 0..2 corner, 3..5 and 6..8 edges, 9..11 their cross product, 12..14 radiance / chance, 15 chance,
    16 error · area.
    """

    delta = False

    def __init__(self, emitters: TriangleEmitters, pairs: NDArray[np.intp], chance: Float64) -> None:
        """`pairs` (P, 2) from `paired`; `chance` of each pair."""
        corner, e1, e2 = spans(emitters.vertices[pairs].astype(np.float64))
        normal = np.cross(e1, e2)
        area = np.sqrt((normal**2).sum(axis=1))
        radiance = emitters.radiance[pairs[:, 0]].astype(np.float64)
        error = emitters.error[pairs].max(axis=1) * area
        rows = [corner.T, e1.T, e2.T, normal.T, over_chance(radiance, chance), chance[None], error[None]]
        self._table = np.ascontiguousarray(np.concatenate(rows), np.float32)
        self.count = len(pairs)

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform points on parallelograms `row`; None if there is but one."""
        r = at(self._table, row)
        to = r[0:3] - p
        to += u * r[3:6]
        to += v * r[6:9]
        return draw_toward(to, dot(to, r[9:12]), r[12:15], r[15], r[16])


def paired(emitters: TriangleEmitters) -> NDArray[np.intp]:
    """(P, 2) rows of neighbouring triangles that make a parallelogram and shine alike, each in one pair.

    Neighbours in the list: a quad's triangles follow each other. Emission that varies stays with triangles,
    whose barycentrics say where on them a point is.
    """
    vertices, radiance = emitters.vertices, emitters.radiance
    same = (radiance[:-1] == radiance[1:]).all(axis=1) & ~emitters.varies[:-1] & ~emitters.varies[1:]
    if emitters.whose is not None:
        same &= emitters.whose[:-1] == emitters.whose[1:]
    first = np.flatnonzero(same)
    candidates = np.stack([first, first + 1], axis=1)
    first = first[_closing(vertices[candidates])[0]]
    # of a run of neighbours that all fit, every other one begins a pair
    starts = np.flatnonzero(np.diff(first, prepend=-2) > 1)
    run = np.repeat(starts, np.diff(starts, append=len(first)))
    first = first[(np.arange(len(first)) - run) % 2 == 0]
    return np.stack([first, first + 1], axis=1)


def _closing(quads: Float32 | Float64) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
    """Which pairs of triangles (P, 2, 3, 3) make a parallelogram, and which corner of the first is a tip.

    They share the other two corners, a and b, and their tips c and d close it: c + d = a + b.
    """
    found, tip = np.zeros(len(quads), np.bool_), np.zeros(len(quads), np.intp)
    size = np.abs(quads).max(axis=(1, 2, 3)) if len(quads) else np.zeros(0)
    for k in range(3):
        a, b, c = (quads[:, 0, (k + turn) % 3] for turn in (1, 2, 0))
        for j in range(3):
            d, e, f = (quads[:, 1, (j + turn) % 3] for turn in (0, 1, 2))
            shared = ((a == f) & (b == e)).all(axis=1) | ((a == e) & (b == f)).all(axis=1)
            gap = np.abs(a.astype(np.float64) + b - c - d).max(axis=1)
            closed = shared & (gap <= CLOSED * size)
            tip[closed], found = k, found | closed
    return found, tip


def spans(quads: Float64) -> tuple[Float64, Float64, Float64]:
    """Corner and the two edges from it, (P, 3) each, of pairs of triangles (P, 2, 3, 3)."""
    tip = _closing(quads)[1]
    corner, a, b = (
        np.take_along_axis(quads[:, 0], ((tip + turn) % 3)[:, None, None], axis=1)[:, 0] for turn in range(3)
    )
    return corner, a - corner, b - corner
