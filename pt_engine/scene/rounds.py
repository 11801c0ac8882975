"""Curves' pieces and points' spheres in the recentred world, and what a ray sees where it meets them."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .geometry import GAMMA6, Geometry, transformed
from .hulls import Hulls, radius_scale
from .round_hits import BEGIN, COLUMNS, END, KIND, LINEAR, P0, P1, R0, R1, RIBBON, SPHERE, THICK, cross, dot
from .snapshot import Instances, PointsData, Snapshot
from .strands import Samples, bisectors, tangents

if TYPE_CHECKING:
    from .surface import Surface

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]

KINDS = {"RIBBON": RIBBON, "THICK": THICK, "LINEAR": LINEAR}
GRAZING = np.float32(1e-4)  # of a cosine: what is met from outside never looks away


class Points(NamedTuple):
    """What (N,) hits on round things are made of, in the world.

    Attributes
    ----------
    p, ng : (3, N) float32
        Position, and normal on the viewer's side: of a ribbon the round one that Cycles gives it.
    """

    p: Float32
    ng: Float32


class Rounds:
    """All pieces of curves and all points of a scene.

    Attributes
    ----------
    first, end : int
        The triangles that are hulls, of what moves the last; other moving ones come behind them, and records
        that instances share.
    piece : (H,) int32
        What the hulls' triangles are around: row of `rows`.
    strand : (K,) int32
        Number of the curve that each row is a piece of, −1 for points.
    rows : (K, 16) float32
        The pieces, as `round_hits` has them.
    kinds : tuple of int
        Those that occur.
    scale : (I,) float32
        What each instance makes of radii.
    by_position : (I,) bool
        Instances without Generated coordinates of their own.
    """

    def __init__(self, snapshot: Snapshot, geometry: Geometry, hulls: Hulls) -> None:
        instances, own = snapshot.instances, rounds_among(snapshot)
        sizes = [len(mesh.triangles) for mesh in snapshot.meshes]
        self.first = int(geometry.first_triangle[own[0]])
        self.scale = np.ones(len(instances.mesh), np.float32)
        self.by_position = np.zeros(len(instances.mesh), np.bool_)
        self._own, self._origin, self._hulls = own, geometry.origin, hulls
        rows, pieces, strands, self._begin = [], [], [], [0]
        curves = 0
        for k in own.tolist():
            number = int(instances.mesh[k])
            source = hulls.sources[number - hulls.first]
            part = self._rows(number, source, instances.matrix[k])
            if isinstance(source, Samples):
                strands.append(curves + source.curve[source.start])
                curves += 1 + int(np.max(source.curve, initial=-1))
            else:
                strands.append(np.full(len(part), -1, np.int32))
            self.scale[k] = radius_scale(instances.matrix[k])
            self.by_position[k] = not hulls.has_generated(number)
            count, each = self._begin[-1], sizes[number] // max(len(part), 1)
            pieces.append(np.repeat(np.arange(count, count + len(part), dtype=np.int32), each))
            rows.append(part)
            self._begin.append(count + len(part))
        self.rows = np.concatenate(rows)
        self.piece = np.concatenate(pieces)
        self.strand = np.concatenate(strands).astype(np.int32)
        self.end = self.first + len(self.piece)
        self.kinds = tuple(int(kind) for kind in np.unique(self.rows[:, KIND])) or (SPHERE,)

    def _rows(self, number: int, source: Samples | PointsData, matrix: Float64) -> Float32:
        """The pieces of one instance."""
        matrix = matrix.copy()
        matrix[:3, 3] -= self._origin
        if isinstance(source, Samples):
            return curve_rows(source, KINDS[self._hulls.kind(number)], matrix)
        return point_rows(source.points, source.radius, matrix)

    def at(self, instances: Instances, sources: Mapping[int, Samples | PointsData]) -> Rounds:
        """These with the last `instances` elsewhere, and other `sources` in some numbers' hulls."""
        there, first = copy.copy(self), len(self.scale) - len(instances.mesh)
        there.rows, there.scale = self.rows.copy(), self.scale.copy()
        for j in np.flatnonzero(self._own >= first).tolist():
            k = int(self._own[j]) - first
            number, matrix = int(instances.mesh[k]), instances.matrix[k]
            source = sources.get(number) or self._hulls.sources[number - self._hulls.first]
            there.rows[self._begin[j] : self._begin[j + 1]] = self._rows(number, source, matrix)
            there.scale[k + first] = radius_scale(matrix)
        return there

    def held(self, prim: NDArray[np.integer]) -> NDArray[np.bool_]:
        """(N,) which triangles are hulls."""
        return np.asarray((prim >= self.first) & (prim < self.end))

    def rows_of(self, prim: Int32) -> Float32:
        """(N, 16) the pieces that some hull triangles are around."""
        return self.rows.take(self.piece.take(prim - np.int32(self.first)), axis=0)

    def strand_of(self, prim: Int32) -> Int32:
        """(N,) numbers of the curves that triangles are around, −1 for others."""
        strand = np.full(len(prim), -1, np.int32)
        lanes = np.flatnonzero(self.held(prim))
        strand[lanes] = self.strand.take(self.piece.take(prim.take(lanes) - np.int32(self.first)))
        return strand

    def settle(self, si: Surface, o: Float32) -> None:
        """Put hits on hulls to what they are the hulls of. `o` (3, N) is where the rays began."""
        lanes = np.flatnonzero(self.held(si.prim))
        if len(lanes) == 0:
            return
        rows = self.rows_of(si.prim.take(lanes))
        v = si.v.take(lanes)
        wi = si.wi.take(lanes, axis=1)
        p, ng = seen(rows, o.take(lanes, axis=1), wi, si.t.take(lanes), si.u.take(lanes), v)
        bound = vectors.dot(np.abs(ng), np.abs(p)) * GAMMA6 + vectors.max3(np.abs(p)) * np.float32(2.0**-60)
        facing = vectors.dot(ng, wi)
        inside = (rows[:, KIND] == THICK) & (facing < -GRAZING)
        facing = np.where(inside, facing, np.maximum(facing, GRAZING))
        vectors.flipped(ng, facing)
        si.p[:, lanes], si.ng[:, lanes] = p, ng
        si.bound[lanes], si.facing[lanes] = bound, facing


def triangle_meshes(snapshot: Snapshot) -> int:
    """How many meshes of a snapshot are before the hulls with which they end."""
    return len(snapshot.meshes) - len(snapshot.curves) - len(snapshot.points)


def rounds_among(snapshot: Snapshot) -> NDArray[np.intp]:
    """The instances of hulls."""
    return np.flatnonzero(snapshot.instances.mesh >= triangle_meshes(snapshot))


def rounds_of(snapshot: Snapshot, geometry: Geometry, hulls: Hulls) -> Rounds | None:
    """Those of a snapshot whose meshes end with the hulls; None where none is placed."""
    return Rounds(snapshot, geometry, hulls) if len(rounds_among(snapshot)) else None


def curve_rows(samples: Samples, kind: int, matrix: Float64) -> Float32:
    """(K, 16) the pieces of one instance's curves."""
    start = samples.start
    points = transformed(samples.points, matrix)
    radius = samples.radius * np.float32(radius_scale(matrix))
    rows = np.zeros((len(start), COLUMNS), np.float32)
    rows[:, P0], rows[:, P1] = points[start], points[start + 1]
    rows[:, R0], rows[:, R1] = radius[start], radius[start + 1]
    if kind == LINEAR:
        rows[:, BEGIN], rows[:, END] = bisectors(points, start)
    else:
        with np.errstate(invalid="ignore", over="ignore"):
            moved = replace(samples, tangent=(samples.tangent @ matrix[:3, :3].T).astype(np.float32))
            rows[:, BEGIN], rows[:, END] = tangents(points, moved)
    rows[:, KIND] = kind
    return rows


def point_rows(points: Float32, radius: Float32, matrix: Float64) -> Float32:
    """(P, 16) one instance's spheres."""
    rows = np.zeros((len(points), COLUMNS), np.float32)
    rows[:, P0] = rows[:, P1] = transformed(points, matrix)
    rows[:, R0] = rows[:, R1] = radius * np.float32(radius_scale(matrix))
    rows[:, KIND] = SPHERE
    return rows


def seen(rows: Float32, o: Float32, wi: Float32, t: Float32, s: Float32, v: Float32) -> Points:
    """Where rays have met pieces, put back onto them from where rounding has left it, and normals."""
    row = np.ascontiguousarray(rows.T).astype(np.float64)
    kind = row[KIND]
    x = o - t.astype(np.float64) * wi
    centre = row[P0] + s.astype(np.float64) * (row[P1] - row[P0])
    radius = row[R0] + s * (row[R1] - row[R0])
    away = unit(x - centre)
    p = centre + radius * away
    normal = away
    curved = np.flatnonzero((kind == RIBBON) | (kind == THICK))
    if len(curved):
        tangent = along(row[:, curved], s.take(curved))
        out = away[:, curved]
        normal[:, curved] = unit(out - dot(out, tangent) * tangent)
    tubes = np.flatnonzero(kind == THICK)
    if len(tubes):
        p[:, tubes] = on_cones(row[:, tubes], x[:, tubes])
    flat = np.flatnonzero(kind == RIBBON)
    if len(flat):
        tangent, across = along(row[:, flat], s.take(flat)), v.take(flat).astype(np.float64)
        beside = unit(cross(tangent, wi.take(flat, axis=1).astype(np.float64)))
        up = unit(cross(beside, tangent))
        normal[:, flat] = across * beside + np.sqrt(np.maximum(1 - across * across, 0)) * up
        p[:, flat] = x[:, flat]
    return Points(p.astype(np.float32), normal.astype(np.float32))


def on_cones(row: Float64, x: Float64) -> Float64:
    """(3, N) points moved across pieces' axes onto them."""
    chord = row[P1] - row[P0]
    y = dot(x - row[P0], chord) / dot(chord, chord)
    foot = row[P0] + y * chord
    return np.asarray(foot + (row[R0] + y * (row[R1] - row[R0])) * unit(x - foot))


def along(row: Float64, s: Float32) -> Float64:
    """(3, N) unit tangents toward the tip, of pieces in (16, N): of the cubic with these ends and slopes."""
    x = s.astype(np.float64)
    chord = row[P1] - row[P0]
    tangent = 6 * x * (1 - x) * chord + (1 - x) * (1 - 3 * x) * row[BEGIN] + x * (3 * x - 2) * row[END]
    tangent = unit(tangent)
    straight = np.flatnonzero(row[KIND] == LINEAR)
    if len(straight):
        tangent[:, straight] = unit(chord[:, straight])
    return tangent


def unit(a: Float64) -> Float64:
    """(3, N) at unit length; what has none stays 0."""
    size = np.sqrt(dot(a, a))
    return np.asarray(a / (size + (size == 0)))
