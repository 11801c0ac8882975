"""Dicing: triangles cut until their edges are short enough for the camera, without cracks.

Edges that are too long are halved, and with each the longest edge of every triangle it belongs to (Rivara
1984), so that both sides of an edge always agree and no triangle gets thinner than half its angles. Right
triangles, such as halves of quads, stay right: cutting what is longer than √2 times a length leaves cells
of a grid of that length.

A curved surface is carried on by its vertices' normals: the new vertex of an edge lies on the cubic of a
PN triangle (Vlachos et al. 2001), m = (a + b)/2 − (w_ab n_a + w_ba n_b)/8 with w_ab = (b − a)·n_a, and its
normal is the quadratic's, (n_a + 2 n_ab + n_b)/4, n_ab = n_a + n_b mirrored about the edge's bisector plane.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .snapshot import MeshData
from .vertex_normals import angle_weighted, face_normals, unit_rows

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]
Int64 = NDArray[np.int64]
Length = Callable[[Float64], Float64]

ROUNDS = 40
SLACK = 2  # at most so many triangles come out per triangle of a grid of the full length


@dataclass
class Cut:
    """A mesh being refined.

    Attributes
    ----------
    position : (V, 3) float64
    vertex : (V, A) float32
        What else vertices carry, blended in a straight line.
    normal : (V, 3) float64 or None
        Of a curved surface.
    triangles : (T, 3) int64
    corner : (T, 3, B) float32
        What corners carry.
    parent : (T,) int32
        The triangle that each was cut from.
    """

    position: Float64
    vertex: Float32
    normal: Float64 | None
    triangles: Int64
    corner: Float32
    parent: Int32


def refined(
    mesh: MeshData, matrix: Float64, length: Length, curved: bool, limit: int
) -> tuple[MeshData, float]:
    """A mesh whose grid cells are at most `length(p)` wide, p world positions (n, 3).

    Parameters
    ----------
    matrix : (4, 4) float64
        To the world in which `length` measures.
    curved : bool
        Whether new vertices follow the normals, or lie on the old triangles.
    limit : int
        Of triangles, about.

    Returns
    -------
    mesh : MeshData
    coarser : float
        By what factor all lengths had to grow to keep to `limit`; 1 where they had not.
    """
    cut = start(mesh, curved)
    coarser = 1.0
    for _ in range(ROUNDS):
        world = cut.position @ matrix[:3, :3].T + matrix[:3, 3]
        coarser *= max(1.0, np.sqrt(expected(world, cut.triangles, length, coarser) / limit))
        edges, edge_of = unique_edges(cut.triangles, len(cut.position))
        a, b = world[edges[:, 0]], world[edges[:, 1]]
        size = np.linalg.norm(b - a, axis=1)
        long = size > np.sqrt(2) * coarser * length((a + b) / 2)
        if not long.any():
            break
        cut = halved(cut, edges, edge_of, size, long)
    return finished(mesh, cut, curved), coarser


def start(mesh: MeshData, curved: bool) -> Cut:
    """The uncut mesh, with all that its vertices and corners carry in one array each."""
    by_vertex, by_corner = layers_of(mesh)
    count = len(mesh.triangles)
    corner = [values[index] for values, index in by_corner]
    return Cut(
        mesh.vertices.astype(np.float64),
        np.concatenate([*by_vertex, np.zeros((len(mesh.vertices), 0), np.float32)], axis=1),
        vertex_normals(mesh).astype(np.float64) if curved else None,
        mesh.triangles.astype(np.int64),
        np.concatenate([*corner, np.zeros((count, 3, 0), np.float32)], axis=2),
        np.arange(count, dtype=np.int32),
    )


def vertex_normals(mesh: MeshData) -> Float32:
    """(V, 3) normals that span the patches: the shading normals where there is one per vertex."""
    if mesh.normals is not None and np.array_equal(mesh.normal_index, mesh.triangles):
        return mesh.normals
    return angle_weighted(mesh.vertices, mesh.triangles)


def layers_of(mesh: MeshData) -> tuple[list[Float32], list[tuple[Float32, Int32]]]:
    """What vertices carry, and what corners carry: (values, index) each."""
    by_vertex = [] if mesh.orco is None else [mesh.orco]
    by_corner = []
    for layer in (*mesh.uvs.values(), *mesh.colors.values()):
        corners = mesh.corner_index
        by_corner.append((layer, mesh.triangles if corners is None else corners))
    return by_vertex, by_corner


def expected(world: Float64, triangles: Int64, length: Length, coarser: float) -> float:
    """About how many triangles there will be: each becomes halves of squares of its length."""
    a, b, c = (world[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    cell = coarser * length((a + b + c) / 3)
    return float(np.maximum(SLACK * area / (cell * cell / 2), 1).sum())


def unique_edges(triangles: Int64, count: int) -> tuple[Int64, Int64]:
    """(E, 2) vertices of each edge, and (T, 3) the edge from each corner to the next."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)])
    key = ends.min(axis=0) * count + ends.max(axis=0)
    known, number = np.unique(key.ravel(), return_inverse=True)
    return np.stack(np.divmod(known, count), axis=1), number.reshape(-1, 3)


def halved(cut: Cut, edges: Int64, edge_of: Int64, size: Float64, long: NDArray[np.bool_]) -> Cut:
    """Cut every edge marked `long`, and what that calls for."""
    longest = size[edge_of].argmax(axis=1)
    first = np.take_along_axis(edge_of, longest[:, None], axis=1)[:, 0]
    while True:
        missing = long[edge_of].any(axis=1) & ~long[first]
        if not missing.any():
            break
        long[first[missing]] = True
    which = np.flatnonzero(long)
    middle = np.full(len(edges), -1, np.int64)
    middle[which] = len(cut.position) + np.arange(len(which))
    turn = (longest[:, None] + np.arange(3)) % 3  # corner 0 to 1 is the longest edge
    edge = np.take_along_axis(edge_of, turn, axis=1)
    triangles = np.take_along_axis(cut.triangles, turn, axis=1)
    corner = np.take_along_axis(cut.corner, turn[:, :, None], axis=1)
    six = np.concatenate([triangles, middle[edge]], axis=1)  # three corners, three middles
    carried = np.concatenate([corner, (corner + np.roll(corner, -1, axis=1)) / 2], axis=1)
    code = long[edge] @ np.array([1, 2, 4])
    rows, picks = [], []
    for number, pattern in PATTERNS.items():
        alike = np.flatnonzero(code == number)
        for three in pattern:
            rows.append(alike)
            picks.append(np.broadcast_to(np.array(three), (len(alike), 3)))
    row, pick = np.concatenate(rows), np.concatenate(picks)
    a, b = edges[which].T
    position, normal = between(cut, a, b)
    return Cut(
        np.concatenate([cut.position, position]),
        np.concatenate([cut.vertex, (cut.vertex[a] + cut.vertex[b]) / 2]),
        None if cut.normal is None else np.concatenate([cut.normal, normal]),
        six[row[:, None], pick],
        carried[row[:, None], pick],
        cut.parent[row],
    )


# Corners 0 to 2 and middles 3 (of 0–1, the longest), 4 (of 1–2), 5 (of 2–0), by which edges are cut.
PATTERNS = {
    0: [(0, 1, 2)],
    1: [(0, 3, 2), (3, 1, 2)],
    3: [(0, 3, 2), (3, 1, 4), (3, 4, 2)],
    5: [(0, 3, 5), (3, 2, 5), (3, 1, 2)],
    7: [(0, 3, 5), (3, 1, 4), (3, 4, 2), (3, 2, 5)],
}


def between(cut: Cut, a: Int64, b: Int64) -> tuple[Float64, Float64]:
    """Position and normal of the middles of edges a–b."""
    p, q = cut.position[a], cut.position[b]
    middle = (p + q) / 2
    if cut.normal is None:
        return middle, middle
    n, m = cut.normal[a], cut.normal[b]
    along = q - p
    rise_p, rise_q = ((along * x).sum(axis=1, keepdims=True) for x in (n, m))
    squared = (along * along).sum(axis=1, keepdims=True)
    tilt = unit_rows(n + m - 2 * along * (rise_p + rise_q) / (squared + (squared == 0)))
    return middle - (rise_p * n - rise_q * m) / 8, unit_rows(n + 2 * tilt + m)


def finished(mesh: MeshData, cut: Cut, curved: bool) -> MeshData:
    """The cut mesh with its layers in place."""
    vertices, triangles = cut.position.astype(np.float32), cut.triangles.astype(np.int32)
    widths = [layer.shape[1] for layer in (*mesh.uvs.values(), *mesh.colors.values())]
    flat_corner = cut.corner.reshape(3 * len(triangles), cut.corner.shape[2])
    parts = [np.ascontiguousarray(p) for p in np.split(flat_corner, np.cumsum(widths)[:-1], axis=1)]
    names = [*mesh.uvs, *mesh.colors]
    layers = list(zip(names, parts, strict=True)) if names else []
    index = np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3)
    flat = None if mesh.flat is None else mesh.flat[cut.parent]
    made = replace(
        mesh,
        vertices=vertices,
        triangles=triangles,
        material_slot=mesh.material_slot[cut.parent],
        flat=flat,
        corner_index=index if layers else None,
        uvs=dict(layers[: len(mesh.uvs)]),
        colors=dict(layers[len(mesh.uvs) :]),
        orco=None if mesh.orco is None else np.ascontiguousarray(cut.vertex[:, :3]),
    )
    if mesh.normals is None:
        return made
    normal = angle_weighted(vertices, triangles) if cut.normal is None else cut.normal.astype(np.float32)
    if flat is None or not flat.any():
        return replace(made, normals=normal, normal_index=triangles, flat=None)
    corner = normal[triangles]
    which = np.flatnonzero(flat)
    corner[which] = face_normals(vertices, triangles[which])[:, None]
    return replace(made, normals=corner.reshape(-1, 3), normal_index=index)
