"""Per-mesh shading attributes (normals, uv, colours, generated), shared by all instances of a mesh.

Triangles are numbered twice: globally, as Embree returns them, and within the tables here, where each
mesh is stored once. `shift[instance]` takes the first to the second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geometry import Geometry
from .packed_normals import packed
from .snapshot import MeshData, Snapshot
from .tangent_space import face_normals, tangent_space

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


@dataclass
class Layer:
    """Values of one attribute at triangle corners: `values[:, index[corner, triangle]]`.

    Attributes
    ----------
    values : (C, K) float32
    index : (3, T') int32
    shift : (I,) int32
        Add to a global triangle number to get a column of `index`; instances without the attribute
        point at the last one, which holds the default.
    has : (I,) bool
    """

    values: Float32
    index: Int32
    shift: Int32
    has: NDArray[np.bool_]

    def corners(self, prim: Int32, instance: Int32) -> tuple[Float32, Float32, Float32]:
        """(C, N) values at the three corners of each lane's triangle."""
        column = (prim + self.shift.take(instance)).astype(np.intp)
        if not self.has.all():
            column[~self.has.take(instance)] = self.index.shape[1] - 1
        found = np.empty((3, len(self.values), len(column)), self.values.dtype)
        for corner, index in zip(found, self.index, strict=True):
            place = index.take(column).astype(np.intp)
            for row, values in zip(corner, self.values, strict=True):  # quicker than rows, to be turned round
                values.take(place, out=row, mode="wrap")
        a, b, c = found
        return a, b, c

    def spans(self, prim: Int32, instance: Int32) -> tuple[Float32, Float32, Float32]:
        """(C, N) values at corner 0 of each lane's triangle, and what corners 1 and 2 have more."""
        a, b, c = self.corners(prim, instance)
        b -= a
        c -= a
        return a, b, c

    def at(self, prim: Int32, instance: Int32, u: Float32, v: Float32) -> Float32:
        """Interpolated (C, N) values at barycentrics u, v of corners 1 and 2."""
        return between(self.spans(prim, instance), u, v)


def between(spans: tuple[Float32, Float32, Float32], u: Float32, v: Float32) -> Float32:
    """(C, N) values at barycentrics u, v of `Layer.spans`."""
    a, b, c = spans
    blended: Float32 = u * b
    blended += a
    blended += v * c
    return blended


def build_layer(
    snapshot: Snapshot,
    geometry: Geometry,
    pick: dict[int, tuple[Float32, Int32]],
    default: tuple[float, ...],
) -> Layer:
    """Join the meshes' (values, index) pairs, keyed by mesh number in `pick`, into one table."""
    meshes = snapshot.instances.mesh
    start: dict[int, int] = {}
    values: list[Float32] = []
    index: list[Int32] = []
    rows = values_before = 0
    for m, (mesh_values, mesh_index) in pick.items():
        start[m] = rows
        values.append(mesh_values)
        index.append(mesh_index + np.int32(values_before) if values_before else mesh_index)
        rows += len(mesh_index)
        values_before += len(mesh_values)
    values.append(np.array([default], np.float32))
    index.append(np.full((1, 3), values_before, np.int32))
    first = geometry.first_triangle[:-1]
    shift = np.array([start.get(int(m), 0) for m in meshes], np.int64) - first
    has = np.array([int(m) in start for m in meshes], bool)
    return Layer(_columns(values), _columns(index), shift.astype(np.int32), has)


def _columns(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Rows (K, C) of some parts as (C, K), in memory too."""
    joined = np.empty((parts[0].shape[1], sum(map(len, parts))), parts[0].dtype)
    return np.concatenate([part.T for part in parts], axis=1, out=joined)


def appended(table: Layer, last: Layer, rows: NDArray[np.bool_]) -> Layer:
    """`table` with what `last` says of the instances `rows` (I,); both are of the same instances."""
    index = np.concatenate([table.index, last.index + np.int32(table.values.shape[1])], axis=1)
    shift = np.where(rows, last.shift + np.int32(table.index.shape[1]), table.shift)
    values = np.concatenate([table.values, last.values], axis=1)
    return Layer(values, index, shift, np.where(rows, last.has, table.has))


def normal_layer(snapshot: Snapshot, geometry: Geometry) -> Layer | None:
    """Object-space shading normals, or None where every mesh is flat."""
    pick = {
        m: (usable(mesh.normals), mesh.normal_index)
        for m, mesh in enumerate(snapshot.meshes)
        if mesh.normals is not None and mesh.normal_index is not None
    }
    return build_layer(snapshot, geometry, pick, (0.0, 0.0, 1.0)) if pick else None


def usable(normals: Float32) -> Float32:
    """Normals (K, 3) to interpolate and square: what is not finite is 0, what is huge is shortened."""
    largest = np.abs(normals).max(axis=1, keepdims=True)
    if np.max(largest, initial=0) < 1e6:
        return normals
    finite = np.isfinite(largest)
    scale = np.where(finite, np.maximum(largest, 1), np.float32(1)).astype(np.float32)
    shortened: Float32 = np.where(finite, normals, np.float32(0)).astype(np.float32) / scale
    return shortened


def uv_layer(snapshot: Snapshot, geometry: Geometry, name: str) -> Layer:
    """A uv map by name; "" means each mesh's active one. Meshes without it give (0, 0), as in Blender."""
    pick = {}
    for m, mesh in enumerate(snapshot.meshes):
        uv = mesh.uvs.get(name or mesh.active_uv)
        if uv is not None and mesh.corner_index is not None:
            pick[m] = (uv, mesh.corner_index)
    return build_layer(snapshot, geometry, pick, (0.0, 0.0))


def color_layer(snapshot: Snapshot, geometry: Geometry, name: str) -> Layer:
    """A colour attribute by name; "" means each mesh's active one. Missing ones are (0, 0, 0, 0)."""
    pick = {}
    for m, mesh in enumerate(snapshot.meshes):
        color = mesh.colors.get(name or mesh.active_color)
        if color is not None:
            pick[m] = (color, _color_index(mesh, color))
    return build_layer(snapshot, geometry, pick, (0.0, 0.0, 0.0, 0.0))


def attribute_layer(snapshot: Snapshot, geometry: Geometry, name: str) -> Layer:
    """What an Attribute node reads: x, y, z, alpha and the number, which of a pair is its x, else the mean.

    "uv" and "vertex_color" are Cycles' names of the active uv map and colour.
    """
    pick = {}
    for m, mesh in enumerate(snapshot.meshes):
        pair = mesh.uvs.get(mesh.active_uv if name == "uv" else name)
        color = mesh.colors.get(mesh.active_color if name == "vertex_color" else name)
        if pair is not None and mesh.corner_index is not None:
            zero = np.zeros(len(pair), np.float32)
            pick[m] = np.stack([*pair.T, zero, zero + 1, pair[:, 0]], axis=1), mesh.corner_index
        elif color is not None:
            number = (color[:, 0] + color[:, 1] + color[:, 2]) * np.float32(1 / 3)
            pick[m] = np.concatenate([color, number[:, None]], axis=1), _color_index(mesh, color)
    return build_layer(snapshot, geometry, pick, (0.0, 0.0, 0.0, 1.0, 0.0))


def _color_index(mesh: MeshData, color: Float32) -> Int32:
    corners = mesh.corner_index
    if corners is not None and (not corners.size or int(np.max(corners)) < len(color)):
        return corners  # also where there are as many corners as vertices: a single quad
    return mesh.triangles


def tangent_layer(snapshot: Snapshot, geometry: Geometry, name: str) -> Layer:
    """MikkTSpace tangents along a uv map and the sign of their bitangents; 0 where the map is missing.

    "" is each mesh's active map; a mesh without any has a sphere's around its origin, as in Cycles, which
    since Blender 5 knows no seam.
    """
    pick = {}
    for m, mesh in enumerate(snapshot.meshes):
        uv = corner_uv(mesh, name)
        if uv is None:
            continue
        points = mesh.vertices[mesh.triangles]
        normals = np.repeat(face_normals(points)[:, None], 3, axis=1)
        if mesh.normals is not None and mesh.normal_index is not None:
            smooth = packed(mesh.normals)[mesh.normal_index]
            normals = smooth if mesh.flat is None else np.where(mesh.flat[:, None, None], normals, smooth)
        tangent, sign = tangent_space(points, normals, uv, around=not (name or mesh.active_uv))
        values = np.concatenate([tangent, sign[..., None]], axis=2).reshape(-1, 4)
        pick[m] = values, np.arange(len(values), dtype=np.int32).reshape(-1, 3)
    return build_layer(snapshot, geometry, pick, (0.0, 0.0, 0.0, 0.0))


def corner_uv(mesh: MeshData, name: str) -> Float32 | None:
    """(T, 3, 2) of a uv map, of longitude and latitude where "" finds none."""
    uv = mesh.uvs.get(name or mesh.active_uv)
    if uv is not None and mesh.corner_index is not None:
        return uv[mesh.corner_index]
    if name or mesh.active_uv:
        return None
    x, y, z = mesh.vertices.T
    longitude = (0.5 - np.arctan2(x, y) / (2 * np.pi)) * ((x != 0) | (y != 0))
    length = np.sqrt(x * x + y * y + z * z)
    latitude = (1 - np.arccos(z / (length + (length == 0))) / np.pi) * (length > 0)
    return np.stack([longitude, latitude], axis=1).astype(np.float32)[mesh.triangles]


def generated_layer(snapshot: Snapshot, geometry: Geometry) -> Layer:
    """Generated coordinates: undeformed positions mapped from the texture space's box to [0, 1]³."""
    pick = {}
    for m, mesh in enumerate(snapshot.meshes):
        points = mesh.vertices if mesh.orco is None else mesh.orco
        centre, size = mesh.texture_space
        with np.errstate(divide="ignore", invalid="ignore"):
            unit = (points - centre) / np.where(size == 0, np.float32(1), size)
        pick[m] = ((unit * 0.5 + 0.5).astype(np.float32), mesh.triangles)
    return build_layer(snapshot, geometry, pick, (0.0, 0.0, 0.0))


def position_layer(snapshot: Snapshot, geometry: Geometry) -> Layer:
    """Object-space positions, for what needs a triangle's edges (tangents)."""
    pick = {m: (mesh.vertices, mesh.triangles) for m, mesh in enumerate(snapshot.meshes)}
    return build_layer(snapshot, geometry, pick, (0.0, 0.0, 0.0))
