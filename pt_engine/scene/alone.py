"""Meshes that one object has for itself, whose shading normals blend in the world instead of in object space.

Between corners Cycles blends unit normals: a shared mesh's in object space, but those of a mesh with a single
user in the world, where it has moved them, n → M⁻ᵀn/|M⁻ᵀn|. Under a matrix that stretches one axis more than
another the two give different directions. Blending the object's normals with the lengths

    n' = n/|M⁻ᵀn|

and turning the result by M⁻ᵀ is the second. Meshes that Cycles does not move stay as they are: those that are
displaced, scatter light under their surface, or move while the shutter is open. (Cycles moves those that only
deform, too; they are left here.)
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .displace import triangle_materials
from .snapshot import Graph, Instances, Link, Snapshot
from .transforms import inverses

if TYPE_CHECKING:
    from ..nodes.compile import Materials

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]

EVEN = 1e-5  # relative difference of stretches that makes none of directions
UNDER_SURFACES = 1e-5  # weight of subsurface scattering that Cycles takes note of


def normals_in_world(snapshot: Snapshot, materials: Materials) -> tuple[Snapshot, NDArray[np.bool_]]:
    """The snapshot whose meshes of single users have their normals at such lengths, and these users (I,).

    Both only where it makes a difference: of smooth meshes under uneven matrices.
    """
    instances, meshes = snapshot.instances, list(snapshot.meshes)
    users = single(snapshot) & uneven(instances)
    for k in np.flatnonzero(users):
        mesh = meshes[instances.mesh[k]]
        used = np.unique(triangle_materials(mesh, instances.materials[k])).tolist()
        users[k] = mesh.normals is not None and not any(
            m in materials.displacement or scatters_below(snapshot.materials[m]) for m in used if m >= 0
        )
    if not users.any():
        return snapshot, users
    for k in np.flatnonzero(users):
        mesh = meshes[instances.mesh[k]]
        assert mesh.normals is not None
        longer = with_world_lengths(mesh.normals, instances.matrix[k])
        meshes[instances.mesh[k]] = replace(mesh, normals=longer)
    return replace(snapshot, meshes=tuple(meshes)), users


def single(snapshot: Snapshot) -> NDArray[np.bool_]:
    """(I,) who has a mesh of triangles for itself and neither moves nor deforms."""
    mesh, motion = snapshot.instances.mesh, snapshot.motion
    users: NDArray[np.bool_] = np.bincount(mesh, minlength=1)[mesh] == 1
    users &= mesh < len(snapshot.meshes)
    if motion is not None:
        users &= ~np.isin(mesh, [shape.mesh for shape in motion.meshes])
        for rows in motion.instances:
            users[rows.instance] = False
    return users


def uneven(instances: Instances) -> NDArray[np.bool_]:
    """(I,) whose matrices stretch one axis more than another."""
    linear = instances.matrix[:, :3, :3]
    finite = np.isfinite(linear).all(axis=(1, 2))
    stretch = np.linalg.svd(np.where(finite[:, None, None], linear, 0), compute_uv=False)
    return np.asarray(finite & (stretch[:, 0] - stretch[:, 2] > EVEN * stretch[:, 0]))


def scatters_below(graph: Graph) -> bool:
    """Whether Cycles sees subsurface scattering in a material."""
    for node in graph.nodes:
        weight = node.inputs.get("Subsurface Weight", 0.0) if node.kind == "BsdfPrincipled" else 0.0
        linked = isinstance(weight, Link)
        if node.kind == "SubsurfaceScattering" or linked or float(weight or 0) > UNDER_SURFACES:  # type: ignore[arg-type]
            return True
    return False


def with_world_lengths(normals: Float32, matrix: Float64) -> Float32:
    """Normals (N, 3) over the lengths that a 4×4 matrix gives them in the world."""
    _, turn = inverses(matrix[None, :3, :3])
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.linalg.norm(normals @ turn[0].T, axis=1, keepdims=True)
        longer: Float32 = (normals / np.where(length > 0, length, 1)).astype(np.float32)
    return longer
