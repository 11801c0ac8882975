"""The scene's triangles in one recentred world, each with one packed record.

A hit costs one gather of eight floats (32 bytes): unit normal, plane offset, error bound, and two
integers. What a triangle is made of (its surface number) has an array of its own, since it decides which
lanes go on, before anything else of the hit is needed. Shading attributes (normals, uv, colours) stay per
mesh and are shared by its instances; `lanes.Lanes` looks them up only for programs that ask.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from .accel import Hits
from .snapshot import Instances, MeshData, Snapshot

if TYPE_CHECKING:
    from .instancing import Shared, Sharing
    from .rounds import Rounds

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]

# Columns of a triangle's record; the last two are int32 bit patterns.
NORMAL, PLANE, BOUND, EMITTER, INSTANCE = slice(0, 3), 3, 4, 6, 7
FEW = 4096  # up to this many records, one gather per column beats one of rows that must be transposed
NO_EMITTER = -1
SKY = 0  # surface 0 belongs to no triangle: it is what a ray that leaves the scene "hits"

# γ(n) bounds n roundings (Higham); 6 measured free of self-intersection at every scale and place
GAMMA6 = np.float32(6 * 2.0**-24 / (1 - 6 * 2.0**-24))
FARTHEST = 1e18  # Embree takes none beyond 1.8e18; and one vertex there would cost all others their digits
CHUNK = 1 << 15  # triangles: their float64 temporaries are 8 MB


@dataclass
class Geometry:
    """Flattened triangles, ready for `Accel` and for lookups by primitive number.

    Attributes
    ----------
    origin : (3,) float64
        World position of this geometry's zero, so that float32 has its best precision where the scene is.
    radius : float
        Of a sphere around the zero that holds every vertex.
    vertices, triangles :
        For `Accel`; dropped by `release` once it is built.
    records : (T + 1, 8) float32
        One per triangle; the last is for rays that miss (index −1).
    surface : (T + 1,) uint8, uint16 or int32
        Each triangle's surface number.
    surface_material, surface_smooth : (S,) int32, bool
        By surface number: a surface is a material on flat or on smooth geometry.
    dropped : int
        Triangles with vertices that are not finite, or beyond 10¹⁸, made unhittable.
    first_triangle : (I + 1,) int64
        Where each instance's triangles begin; several that share them have the same place.
    shared : Shared or None
        Where some records are in object space, since several instances share them.
    rounds : Rounds or None
        What some triangles are only the hulls of: curves and points.
    """

    origin: Float64
    radius: float
    vertices: Float32
    triangles: Int32
    records: Float32
    surface: NDArray[np.integer]
    surface_material: Int32
    surface_smooth: NDArray[np.bool_]
    first_triangle: NDArray[np.int64]
    dropped: int
    shared: Shared | None = None
    rounds: Rounds | None = None

    def __post_init__(self) -> None:
        few = len(self.records) <= FEW
        self._columns = np.ascontiguousarray(self.records[:, : BOUND + 1].T) if few else None

    def planes(self, prim: Int32, instance: Int32 | None = None) -> Float32:
        """(5, N) normal, plane and bound of some triangles; the caller may change them.

        `instance` says for shared records which of the instances is meant; it is −1 for the others.
        """
        if self.shared is not None and instance is not None:
            record = self.records.take(prim, axis=0, mode="wrap")[:, : BOUND + 1].T.copy()
            lanes = np.flatnonzero(instance >= 0)
            record[:, lanes] = self.shared.planes(record.take(lanes, axis=1), instance.take(lanes))
            return record
        if self._columns is not None:
            return self._columns.take(prim, axis=1, mode="wrap")
        return self.records.take(prim, axis=0, mode="wrap")[:, : BOUND + 1].T.copy()

    def integer(self, column: int, prim: Int32) -> Int32:
        """(N,) one of the records' integers."""
        row = self.records.take(prim, axis=0, mode="wrap")
        return np.ascontiguousarray(row[:, column]).view(np.int32)

    def instance_of(self, hits: Hits, lanes: NDArray[np.intp]) -> Int32:
        """(K,) which placed mesh some rays have hit."""
        own = self.integer(INSTANCE, hits.prim.take(lanes))
        if hits.instance is None:
            return own
        shared = hits.instance.take(lanes)
        return np.where(shared < 0, own, shared)

    def set_emitters(self, prim: NDArray[np.int64]) -> None:
        """Give the triangles `prim` the emitter numbers 0, 1, …"""
        self.records.view(np.int32)[prim, EMITTER] = np.arange(len(prim), dtype=np.int32)

    def release(self) -> None:
        """Forget what only Embree's build and the emitters needed."""
        self.vertices = np.zeros((0, 3), np.float32)
        self.triangles = np.zeros((0, 3), np.int32)


class Placed(NamedTuple):
    """All triangles that are not shared, in one recentred world, for Embree's build.

    Attributes
    ----------
    origin : (3,) float64
    radius : float
    vertices : (V, 3) float32
    triangles : (T, 3) int32
    first_triangle : (I + 1,) int64
    first_record : (I,) int64
        Where each instance's records are to begin; shared ones come after the others.
    dropped : int
    """

    origin: Float64
    radius: float
    vertices: Float32
    triangles: Int32
    first_triangle: NDArray[np.int64]
    first_record: NDArray[np.int64]
    dropped: int


def place(
    snapshot: Snapshot, sharing: Sharing | None = None, frame: tuple[Float64, float] | None = None
) -> Placed:
    """Transform the vertices of instances that share nothing in float64, relative to the scene's centre.

    `frame` is the centre and radius to use in place of the instances' own.
    """
    meshes, instances = snapshot.meshes, snapshot.instances
    origin, radius = frame or bounds(meshes, instances)
    once = np.ones(len(instances.mesh), np.bool_) if sharing is None else sharing.prototype < 0
    vertex_counts = np.array([len(meshes[m].vertices) for m in instances.mesh], np.int64) * once
    triangle_counts = np.array([len(meshes[m].triangles) for m in instances.mesh], np.int64) * once
    first_vertex: NDArray[np.int64] = np.append(0, np.cumsum(vertex_counts))
    first_triangle: NDArray[np.int64] = np.append(0, np.cumsum(triangle_counts))
    if max(first_triangle[-1], first_vertex[-1]) > 2**31 - 2:
        raise MemoryError(f"{first_triangle[-1]:,} triangles are more than one scene can hold (2^31)")
    vertices = np.empty((first_vertex[-1], 3), np.float32)
    triangles = np.empty((first_triangle[-1], 3), np.int32)
    dropped = 0
    for k in np.flatnonzero(once).tolist():
        mesh, span = meshes[instances.mesh[k]], slice(first_triangle[k], first_triangle[k + 1])
        matrix = instances.matrix[k].copy()
        matrix[:3, 3] -= origin
        vertices[first_vertex[k] : first_vertex[k + 1]] = transformed(mesh.vertices, matrix)
        np.add(mesh.triangles, np.int32(first_vertex[k]), out=triangles[span])
        dropped += drop_invalid(vertices, triangles[span], first_vertex[k], first_vertex[k + 1])
    first_record = first_triangle[:-1].copy()
    if sharing is not None:
        sizes = [len(meshes[m].triangles) for m in instances.mesh[sharing.sample]]
        starts = first_triangle[-1] + np.cumsum([0, *sizes])
        first_record[~once] = starts[sharing.prototype[~once]]
    return Placed(origin, radius, vertices, triangles, first_triangle, first_record, dropped)


def pack(snapshot: Snapshot, placed: Placed, sharing: Sharing | None = None) -> Geometry:
    """The records; made after Embree's build, whose own needs then have the memory."""
    meshes, instances, first = snapshot.meshes, snapshot.instances, placed.first_triangle
    sample = np.zeros(0, np.int32) if sharing is None else sharing.sample
    shared = sum(len(meshes[m].triangles) for m in instances.mesh[sample])
    records = np.zeros((first[-1] + shared + 1, 8), np.float32)
    integers = records.view(np.int32)
    surfaces, numbers = SurfaceTable(), []
    every = np.arange(len(instances.mesh))
    for k in every if sharing is None else every[sharing.prototype < 0]:
        span = slice(first[k], first[k + 1])
        pack_planes(placed.vertices, placed.triangles[span], records[span], mirrors(instances.matrix[k]))
        numbers.append(surfaces.numbers(meshes[instances.mesh[k]], instances.materials[k]))
        integers[span, INSTANCE] = k
    for k in sample:
        mesh, start = meshes[instances.mesh[k]], placed.first_record[k]
        own = records[start : start + len(mesh.triangles)]
        pack_planes(mesh.vertices, mesh.triangles, own, flip=False)
        numbers.append(surfaces.numbers(mesh, instances.materials[k]))
    integers[:, EMITTER] = NO_EMITTER
    numbers.append(np.array([SKY], np.uint8))
    return Geometry(
        placed.origin,
        placed.radius,
        placed.vertices,
        placed.triangles,
        records,
        np.concatenate(numbers, dtype=np.min_scalar_type(len(surfaces.material)), casting="unsafe"),
        np.array(surfaces.material, np.int32),
        np.array(surfaces.smooth, bool),
        np.append(placed.first_record, first[-1]),
        placed.dropped,
    )


def flatten(snapshot: Snapshot) -> Geometry:
    """Place every instance's triangles in one recentred world, and pack the records."""
    return pack(snapshot, place(snapshot))


class SurfaceTable:
    """Numbers the (material, smooth) pairs that occur; number 0 is the sky."""

    def __init__(self) -> None:
        self.material: list[int] = [-1]
        self.smooth: list[bool] = [False]
        self._number: dict[tuple[int, bool], int] = {}

    def numbers(self, mesh: MeshData, materials: Int32) -> NDArray[np.integer]:
        """Surface number of each of the mesh's triangles under an instance's materials by slot."""
        smooth = mesh.normals is not None
        slot = np.clip(mesh.material_slot, 0, len(materials) - 1)
        table = np.zeros(len(materials), np.int32)
        for used in np.unique(slot):
            table[used] = self._of(int(materials[used]), smooth)
        return table.astype(np.min_scalar_type(len(self.material)))[slot]

    def _of(self, material: int, smooth: bool) -> int:
        key = (material, smooth)
        if key not in self._number:
            self._number[key] = len(self.material)
            self.material.append(material)
            self.smooth.append(smooth)
        return self._number[key]


class HasVertices(Protocol):
    """A mesh, or as much of one as `bounds` asks for."""

    @property
    def vertices(self) -> Float32: ...


def bounds(meshes: Sequence[HasVertices], instances: Instances) -> tuple[Float64, float]:
    """Centre of the instances' bounding box, and the radius around it (float64, usable vertices only)."""
    low, high = world_boxes(meshes, instances)
    usable = near(low) & near(high)
    if not usable.any():
        return np.zeros(3), 1.0
    lowest, highest = low[usable].min(axis=0), high[usable].max(axis=0)
    centre = (lowest + highest) / 2
    return centre, max(float(np.linalg.norm(highest - centre)), 1e-30)


def world_boxes(meshes: Sequence[HasVertices], instances: Instances) -> tuple[Float64, Float64]:
    """Corners low and high (I, 3) of boxes around the instances; NaN where a mesh has no usable vertex."""
    nothing = np.full((2, 3), np.nan)
    box = np.array([nothing if b is None else b for b in map(_box, (m.vertices for m in meshes))])
    corner = np.array([[i >> a & 1 for a in range(3)] for i in range(8)])
    corners = box.reshape(-1, 2, 3)[:, corner, [0, 1, 2]][instances.mesh]
    with np.errstate(invalid="ignore", over="ignore"):
        world = np.einsum("kij,knj->kni", instances.matrix[:, :3, :3], corners)
        world += instances.matrix[:, None, :3, 3]
    return world.min(axis=1), world.max(axis=1)


def _box(vertices: Float32) -> tuple[Float64, Float64] | None:
    if len(vertices) == 0:
        return None
    low, high = vertices.min(axis=0).astype(np.float64), vertices.max(axis=0).astype(np.float64)
    if not near(np.stack([low, high])).all():
        usable = vertices[near(vertices)].astype(np.float64)
        return None if len(usable) == 0 else (usable.min(axis=0), usable.max(axis=0))
    return low, high


def near(points: Float32 | Float64) -> NDArray[np.bool_]:
    """(V,) whether each of the points (V, 3) is finite and within Embree's reach."""
    return np.asarray((np.abs(points) < FARTHEST).all(axis=1))


def transformed(points: Float32, matrix: Float64) -> Float32:
    """(V, 3) points through a 4×4 matrix in float64, chunk by chunk."""
    out = np.empty(points.shape, np.float32)
    with np.errstate(invalid="ignore", over="ignore"):  # what is not finite is dropped afterwards
        for part in chunks(len(points)):
            p = points[part].astype(np.float64)
            out[part] = p @ matrix[:3, :3].T + matrix[:3, 3]
    return out


def mirrors(matrix: Float64) -> bool:
    """Whether a 4×4 matrix turns right hands into left ones."""
    with np.errstate(invalid="ignore"):
        return bool(np.linalg.det(matrix[:3, :3]) < 0)


def pack_planes(vertices: Float32, triangles: Int32, records: Float32, flip: bool) -> None:
    """Unit normal n, offset n·p of the plane, and the error bound γ(6)·|n|·max|vertex| of each triangle.

    Computed in float64 from the float32 vertices that Embree sees. A mirrored instance turns its
    triangles around; `flip` turns the normal back, as Blender does. A degenerate triangle gets n = 0.
    """
    for part in chunks(len(triangles)):
        a, b, c = (vertices[triangles[part, k]].astype(np.float64) for k in range(3))
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            normal = np.nan_to_num(normal / length, nan=0.0, posinf=0.0, neginf=0.0)
        if flip:
            normal = -normal
        reach = np.maximum(np.maximum(np.abs(a), np.abs(b)), np.abs(c))
        rows = records[part]
        rows[:, NORMAL] = normal
        rows[:, PLANE] = (normal * a).sum(axis=1)
        # in a coordinate plane nothing rounds, but t = 0 is a hit too: leave by more than nothing
        rows[:, BOUND] = (np.abs(normal) * reach).sum(axis=1) * GAMMA6 + reach.max(axis=1) * 2.0**-60


def drop_invalid(vertices: Float32, triangles: Int32, first: int, end: int) -> int:
    """Make triangles with an unusable vertex unhittable (one vertex thrice); returns their number."""
    valid = near(vertices[first:end])
    if valid.all():
        return 0
    bad = ~valid[triangles - first].all(axis=1)
    vertices[first:end][~valid] = 0
    triangles[bad] = first
    return int(bad.sum())


def chunks(n: int) -> Iterator[slice]:
    """Slices that cover range(n) in bounded steps, so that float64 temporaries stay small."""
    for start in range(0, n, CHUNK):
        yield slice(start, min(start + CHUNK, n))
