"""Triangles around what is round, for Embree to find: prisms around curves, octahedra around points.

Embree's Python binding knows triangles only. So each piece of a curve is wrapped in a prism of four sides,
cut where the piece is, and each point in an octahedron; a ray that meets one of their triangles is then
tried on the piece or the sphere itself (`round_accel`). The hulls are ordinary meshes of the snapshot: they
are placed, instanced and given attributes like all others. Corners 0 and 2 of a prism's triangle have the
values of the piece's beginning, corner 1 those of its end, so that barycentric u is the way along it and v
does not matter.

A ray that passes through a convex cell crosses its surface twice; so one face may be left out, and the prism
stays open at its end, where the next one begins.

Of the rays that meet a convex hull, those that miss what is in it are one less the ratio of perimeters (for
points, of surfaces), by Cauchy: 21 % for four sides around a circle, 40 % for three. More sides cost memory.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core import frames
from .geometry import FARTHEST, bounds, chunks, near
from .snapshot import CurvesData, MeshData, PointsData, Snapshot
from .strands import Samples, resampled, sampled, tangents

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]

SIDES = 4
STAGGER, NEIGHBOURS = 0.01, 8  # by how much overlapping hulls differ in width, and how many do
SLACK = 1.002  # a hull is larger than what it holds, by more than rounding
ROUNDING = 2.0**-20  # of the largest coordinate
OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], np.float64)
FACES = np.array(
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]], np.int64
)
AS_IT_IS = np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 0.5]], np.float32)  # the texture space that changes nothing


def radius_scale(matrix: Float64) -> float:
    """What a 4×4 matrix makes of radii: the cube root of what it makes of volumes, as in Cycles."""
    with np.errstate(invalid="ignore", over="ignore"):
        return float(np.cbrt(np.abs(np.linalg.det(matrix[:3, :3]))))


class Room(NamedTuple):
    """How much larger than their radius hulls must be, to be large enough in every instance.

    Attributes
    ----------
    factor : float
        More than 1 only where a matrix scales one axis more than another: radii stay round, hulls don't.
    least : float
        What the coarsest rounding of world positions is in object space.
    """

    factor: float
    least: float


def room(matrices: Float64, scene_radius: float) -> Room:
    """For (I, 4, 4) matrices."""
    factor, least = 1.0, 0.0
    for matrix in matrices:
        if np.isfinite(matrix).all():
            shortest = float(np.linalg.svd(matrix[:3, :3], compute_uv=False)[2])
            if shortest > 0:
                factor = max(factor, radius_scale(matrix) / shortest)
                least = max(least, scene_radius / shortest)
    return Room(min(factor, 1e3), least * ROUNDING)


def margin(points: Float32, radius: Float32, room: Room) -> Float64:
    """(N,) inner radius of hulls around radii at points (N, 3)."""
    reach = np.abs(points).max(axis=1) if len(points) else np.zeros(0)
    return radius.astype(np.float64) * (SLACK * room.factor) + reach * ROUNDING + room.least


def curves_hull(curves: CurvesData, samples: Samples, room: Room) -> MeshData:
    """Prisms around all pieces, 10 triangles each, or 12 of LINEAR ones."""
    start = samples.start
    closed = curves.shape == "LINEAR"
    radius = margin(samples.points, samples.radius, room)
    corners = np.empty((len(start), 2, SIDES, 3), np.float32)
    for part in chunks(len(start)):
        corners[part] = prisms(replace(samples, start=start[part]), radius, closed)
    triangles, ends = prism_triangles(len(start), closed)
    row = None
    if curves.uvs or curves.colors:
        row = (start[:, None, None] + ends.astype(np.int32)).reshape(-1, 3)
    by_curve = {name: uv[samples.curve] for name, uv in curves.uvs.items()}
    colors = {
        name: samples.by_point(color) if len(color) == len(curves.points) else color[samples.curve]
        for name, color in curves.colors.items()
    }
    orco = None
    if curves.generated is not None:
        orco = np.repeat(curves.generated[samples.curve[start]], 2 * SIDES, axis=0)
    return MeshData(
        name=curves.name,
        vertices=corners.reshape(-1, 3),
        triangles=triangles,
        material_slot=np.repeat(curves.material_slot[samples.curve[start]], len(ends)),
        corner_index=row,
        uvs=by_curve,
        colors=colors,
        active_uv=curves.active_uv,
        active_color=curves.active_color,
        texture_space=AS_IT_IS,
        orco=orco,
    )


def prisms(samples: Samples, radius: Float64, closed: bool) -> Float64:
    """(K, 2, 4, 3) corners of prisms whose sides touch cones of `radius` (S,), cut as these are.

    `closed` ones are not cut, but long enough for the spheres at their ends. Where they overlap along a
    straight line their sides must not lie in one plane: of triangles at one place Embree finds but one.
    """
    start = samples.start
    p0, p1 = (samples.points[k].astype(np.float64) for k in (start, start + 1))
    along = p1 - p0
    length = np.linalg.norm(along, axis=1, keepdims=True)
    axis = along / (length + (length == 0))
    s, t = (x.T for x in frames.frame(axis.T))
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    around = np.cos(angle)[:, None] * s[:, None] + np.sin(angle)[:, None] * t[:, None]
    # the slope of a cone brings its sides closer to the axis
    slope = np.abs(radius[start + 1] - radius[start])[:, None] / (length + (length == 0))
    wider = np.sqrt(1 + np.minimum(slope, 4) ** 2) / np.cos(np.pi / SIDES)
    r0, r1 = radius[start][:, None] * wider, radius[start + 1][:, None] * wider
    if closed:
        most = np.maximum(r0, r1) * (1 + STAGGER * (start % NEIGHBOURS))[:, None]
        p0, p1, r0, r1 = p0 - axis * most, p1 + axis * most, most, most
    low, high = p0[:, None] + around * r0[:, None], p1[:, None] + around * r1[:, None]
    if closed:
        return np.stack([low, high], axis=1)
    edge = high - low
    begin, end = tangents(samples.points, samples)
    cuts = []
    for plane, point, base in ((begin, p0, r0), (end, p1, r1)):
        down = (edge * plane[:, None]).sum(axis=2)
        off = ((point[:, None] - low) * plane[:, None]).sum(axis=2)
        usable = np.abs(down) > 1e-12 * length
        cut = np.where(usable, off / np.where(usable, down, 1), 0.0 if point is p0 else 1.0)
        reach = 4 * base / (length + (length == 0))  # a cut does not go further than that
        whole = 0.0 if point is p0 else 1.0
        cuts.append(np.clip(cut, whole - reach, whole + reach))
    middle = 0.5 * (cuts[0] + cuts[1])
    first, last = np.minimum(cuts[0], middle), np.maximum(cuts[1], middle)
    return np.stack([low + first[..., None] * edge, low + last[..., None] * edge], axis=1)


def prism_triangles(count: int, closed: bool) -> tuple[Int32, NDArray[np.bool_]]:
    """(T, 3) corners of `count` prisms, and which corners (of one prism) count as a piece's end.

    Corner k of the beginning is vertex k, of the end 4 + k.
    """
    faces = []
    for k in range(SIDES):
        after = (k + 1) % SIDES
        faces += [[k, after, SIDES + k], [SIDES + after, SIDES + k, after]]
    faces += [[0, 2, 1], [0, 3, 2]]
    if closed:
        faces += [[4, 5, 6], [4, 6, 7]]
    one = np.array(faces, np.int32)
    ends = np.zeros(one.shape, np.bool_)
    ends[:, 1] = True
    every = one[None] + np.int32(2 * SIDES) * np.arange(count, dtype=np.int32)[:, None, None]
    return every.reshape(-1, 3), ends


def points_hull(points: PointsData, room: Room) -> MeshData:
    """Octahedra around all points; of those without a place or a radius none that can be hit."""
    usable = near(points.points) & (points.radius > 0) & (points.radius < FARTHEST)
    size = np.sqrt(3) * margin(points.points, points.radius, room)
    with np.errstate(invalid="ignore", over="ignore"):
        corners = points.points[:, None].astype(np.float64) + size[:, None, None] * OCTAHEDRON
    corners[~usable] = 0
    count = len(points.points)
    triangles = (FACES[None] + 6 * np.arange(count)[:, None, None]).reshape(-1, 3).astype(np.int32)
    triangles[~np.repeat(usable, len(FACES))] = 0
    row = np.repeat(np.arange(count, dtype=np.int32), len(FACES))
    return MeshData(
        name=points.name,
        vertices=corners.reshape(-1, 3).astype(np.float32),
        triangles=triangles,
        material_slot=np.zeros(len(triangles), np.int32),
        corner_index=np.stack([row, row, row], axis=1) if points.uvs or points.colors else None,
        uvs=points.uvs,
        colors=points.colors,
    )


class Extent(NamedTuple):
    """All that `geometry.bounds` asks of a mesh."""

    vertices: Float32


def outline(name: str, count: int, vertices: int, triangles: int, mapped: bool) -> MeshData:
    """A mesh of `count` hulls, each of so many vertices and triangles, whose arrays take no memory."""
    rows = np.broadcast_to(np.int32(0), (count * triangles, 3))
    places = np.broadcast_to(np.float32(0), (count * vertices, 3))
    return MeshData(name, places, rows, rows[:, 0], corner_index=rows if mapped else None)


class Hulls:
    """The hulls of all curves, then of all points, of a snapshot.

    Attributes
    ----------
    first : int
        The number of the first: that of the snapshot's meshes, which they are to follow.
    meshes : tuple of MeshData
        Made when first asked for.
    sources : list of Samples or PointsData
        What is in each.
    """

    def __init__(self, snapshot: Snapshot) -> None:
        rows, self.first = snapshot.instances, len(snapshot.meshes)
        self._things: tuple[CurvesData | PointsData, ...] = (*snapshot.curves, *snapshot.points)
        _, radius = bounds((*snapshot.meshes, *(Extent(thing.points) for thing in self._things)), rows)
        self._rooms = []
        for number in range(self.first, self.first + len(self._things)):
            among = rows.mesh == number
            matrices = [rows.matrix[among]]
            for motion in () if snapshot.motion is None else snapshot.motion.instances:
                matrices.append(motion.matrix[among[motion.instance]].reshape(-1, 4, 4))
            self._rooms.append(room(np.concatenate(matrices), radius))
        self.sources: list[Samples | PointsData] = [
            sampled(thing) if isinstance(thing, CurvesData) else thing for thing in self._things
        ]

    @cached_property
    def meshes(self) -> tuple[MeshData, ...]:
        return tuple(map(self._mesh, self._things, self.sources, self._rooms))

    def outlines(self) -> tuple[MeshData, ...]:
        """Meshes of the same sizes that take no memory: so it is known before whether these fit."""
        found: list[MeshData] = []
        for thing, source in zip(self._things, self.sources, strict=True):
            mapped = bool(thing.uvs or thing.colors)
            if isinstance(source, Samples):
                each, _ = prism_triangles(1, self.kind(self.first + len(found)) == "LINEAR")
                found.append(outline(thing.name, len(source.start), 2 * SIDES, len(each), mapped))
            else:
                found.append(outline(thing.name, len(source.points), len(OCTAHEDRON), len(FACES), mapped))
        return tuple(found)

    @staticmethod
    def _mesh(thing: CurvesData | PointsData, source: Samples | PointsData, room: Room) -> MeshData:
        if isinstance(thing, CurvesData):
            assert isinstance(source, Samples)
            return curves_hull(thing, source, room)
        return points_hull(thing, room)

    @property
    def samples(self) -> list[Samples]:
        """Those of all curves."""
        return [source for source in self.sources if isinstance(source, Samples)]

    def bent(self, number: int, points: Float32, radius: Float32) -> tuple[MeshData, Samples | PointsData]:
        """The hull of those of a number, and what is in it, where their points (P, 3) and radii are these."""
        row = number - self.first
        thing = replace(self._things[row], points=points, radius=radius)
        source = self.sources[row]
        if isinstance(thing, CurvesData):
            assert isinstance(source, Samples)
            there: Samples | PointsData = resampled(thing, source)
        else:
            there = thing
        return self._mesh(thing, there, self._rooms[row]), there

    def kind(self, number: int) -> str:
        """The shape of curves; that of points is a sphere."""
        thing = self._things[number - self.first]
        return thing.shape if isinstance(thing, CurvesData) else "SPHERE"

    def has_generated(self, number: int) -> bool:
        """Whether they have Generated coordinates of their own."""
        return getattr(self._things[number - self.first], "generated", None) is not None
