"""True displacement: vertices moved by their materials' programs, before anything is built from them.

Each vertex takes the step that the program of the first displaced triangle around it gives there, with the
smooth normal as its normal, even where faces are shaded flat. Instances share the displaced mesh, whose
program sees the first of them.

Afterwards the normals are made anew, as Cycles has it: at vertices the mean of the faces' unit normals; at
corners of meshes with sharp edges the old normal plus what the vertex's normal has changed by.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..cameras import make_camera
from ..core import vectors
from ..emitters.lights import Lights
from ..nodes.world import compile_world
from .accel import Accel, Hits
from .arrivals import Arrivals
from .attributes import Layer
from .geometry import Geometry, chunks, flatten
from .lanes import Lanes
from .scene import Scene
from .snapshot import Instances, MeshData, Snapshot
from .surface import Surface
from .vertex_normals import angle_weighted, face_normals, mean_of_faces, unit_rows

if TYPE_CHECKING:
    from ..nodes.compile import Materials

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]
Layers = Callable[[Snapshot, Geometry, frozenset[str]], dict[tuple[str, str], Layer]]


def displaced(snapshot: Snapshot, materials: Materials, layers: Layers) -> Snapshot:
    """The snapshot with its meshes displaced; itself where no material moves vertices.

    `layers` makes the attribute tables that programs read (`prepare.shading_layers`).
    """
    meshes = list(snapshot.meshes)
    numbers, first = np.unique(snapshot.instances.mesh, return_index=True)
    for m, k in zip(numbers, first, strict=True):
        if m >= len(meshes):
            continue  # curves and points don't move, as in Cycles
        material = triangle_materials(meshes[m], snapshot.instances.materials[k])
        moving = [int(x) for x in np.unique(material) if int(x) in materials.displacement]
        if moving:
            meshes[m] = displaced_mesh(only(snapshot, int(m), int(k)), material, moving, materials, layers)
    if all(a is b for a, b in zip(meshes, snapshot.meshes, strict=True)):
        return snapshot
    return replace(snapshot, meshes=tuple(meshes))


def triangle_materials(mesh: MeshData, slots: Int32) -> Int32:
    """(T,) material of each triangle."""
    return slots[np.clip(mesh.material_slot, 0, len(slots) - 1)]


def only(snapshot: Snapshot, mesh: int, instance: int) -> Snapshot:
    """A snapshot of one instance."""
    row = slice(instance, instance + 1)
    every = snapshot.instances
    one = Instances(
        np.zeros(1, np.int32),
        every.matrix[row],
        every.materials[row],
        every.random[row],
        every.color[row],
        every.pass_index[row],
        every.visibility[row],
        every.names[row],
    )
    return replace(snapshot, meshes=(snapshot.meshes[mesh],), instances=one, lights=(), world=None)


def displaced_mesh(
    snapshot: Snapshot, material: Int32, moving: list[int], materials: Materials, layers: Layers
) -> MeshData:
    """The only mesh of `snapshot`, displaced; `material` is that of each triangle."""
    mesh = snapshot.meshes[0]
    triangle, corner = where_evaluated(mesh, np.isin(material, moving))
    needs = frozenset(name for m in moving for name in materials.displacement[m].reads())
    scene = stage(snapshot, materials, needs, layers)
    step = np.zeros((len(mesh.vertices), 3), np.float32)
    for m in moving:
        own = np.flatnonzero(material[triangle] == m)
        for part in chunks(len(own)):
            rows = own[part]
            lanes = vertex_lanes(scene, triangle[rows], corner[rows])
            world = np.broadcast_to(evaluated(materials, m, lanes), (3, lanes.n))
            local = lanes.to_object_vector(np.ascontiguousarray(world))
            step[mesh.triangles[triangle[rows], corner[rows]]] = local.T
    moved = replace(
        mesh,
        vertices=mesh.vertices + np.nan_to_num(step, nan=0.0, posinf=0.0, neginf=0.0),
        orco=mesh.vertices if mesh.orco is None else mesh.orco,
    )
    renewed = np.isin(material, [m for m in moving if m not in materials.keeps_normals])
    return with_normals(mesh, moved, renewed)


def where_evaluated(mesh: MeshData, displaced: NDArray[np.bool_]) -> tuple[Int32, Int32]:
    """Triangle and corner at which each moving vertex is evaluated: the first that is displaced."""
    which = np.flatnonzero(displaced).astype(np.int32)
    _, first = np.unique(mesh.triangles[which].ravel(), return_index=True)
    return which[first // 3], (first % 3).astype(np.int32)


def stage(snapshot: Snapshot, materials: Materials, needs: frozenset[str], layers: Layers) -> Scene:
    """A scene for looking up attributes at vertices; there is nothing in it to trace, as in Cycles.

    Normals of flat meshes are smooth here, as Cycles displaces them, but tangents are those of flat faces.
    """
    mesh, given = snapshot.meshes[0], snapshot
    if mesh.normals is None:
        smooth = angle_weighted(mesh.vertices, mesh.triangles)
        snapshot = replace(snapshot, meshes=(replace(mesh, normals=smooth, normal_index=mesh.triangles),))
    geometry = flatten(snapshot)
    nothing = Accel(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    dark = Lights((), np.zeros((0, 3)), geometry.origin, None, None, geometry.radius)
    tangents = frozenset(name for name in needs if name.startswith("tangent:"))
    tables = layers(given, geometry, tangents) | layers(snapshot, geometry, needs - tangents)
    scene = Scene(geometry, nothing, snapshot.instances, tables, materials, compile_world(None), dark)
    scene.camera = make_camera(snapshot.camera, geometry.origin)
    return scene


def vertex_lanes(scene: Scene, triangle: Int32, corner: Int32) -> Lanes:
    """Lanes at corners of triangles, seen along their normals."""
    u, v = (corner == 1).astype(np.float32), (corner == 2).astype(np.float32)
    geometry = scene.geometry
    index = geometry.triangles[triangle, corner]
    at = np.ascontiguousarray(geometry.vertices[index].T)
    normal = np.ascontiguousarray(geometry.planes(triangle)[:3])
    everywhere = np.arange(len(triangle))
    si = Surface(geometry, Hits(np.zeros_like(u), u, v, triangle), everywhere, at, -normal)
    a, b, c = (geometry.vertices[geometry.triangles[triangle, k]].T for k in range(3))
    size = 0.5 * (vectors.length(b - a) + vectors.length(c - a))  # how far Bump's steps go here
    came = Arrivals.by(0, si.size)._replace(radius=size, spread=np.zeros_like(size))
    lanes = Lanes(scene, si, came, smooth=True)
    si.wi = lanes.wi = lanes.ns
    return lanes


def evaluated(materials: Materials, material: int, lanes: Lanes) -> Float32:
    """(3, n) or (3, 1) world-space steps."""
    with np.errstate(all="ignore"):
        return materials.displacement[material].run(lanes)[0]


def with_normals(before: MeshData, after: MeshData, renewed: NDArray[np.bool_]) -> MeshData:
    """`after` with the shading normals of its new shape on the triangles `renewed`.

    Where a displacement is shaded too (BOTH), vertices keep their normals and the shading bends them; corner
    normals always follow.
    """
    if before.normals is None or before.normal_index is None:
        return after
    if np.array_equal(before.normal_index, before.triangles):
        if not renewed.any():
            return after
        normals = before.normals.copy()
        new = mean_of_faces(after.vertices, after.triangles[renewed])
        touched = np.unique(after.triangles[renewed])
        normals[touched] = new[touched]
        return replace(after, normals=normals)
    pre = mean_of_faces(before.vertices, before.triangles)
    post = mean_of_faces(after.vertices, after.triangles)
    corner = before.normals[before.normal_index].astype(np.float64)
    bent = unit_rows(corner + (post - pre)[before.triangles])
    if before.flat is not None:
        flat = np.flatnonzero(before.flat)
        bent[flat] = face_normals(after.vertices, after.triangles[flat])[:, None]
    index = np.arange(3 * len(bent), dtype=np.int32).reshape(-1, 3)
    return replace(after, normals=bent.reshape(-1, 3).astype(np.float32), normal_index=index)
