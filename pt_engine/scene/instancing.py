"""Instances that share their mesh's records: what is stored once, however often a mesh is placed.

Three ways to place a mesh, each cheaper in memory and dearer in time than the one before (docs/instances.md):

- *plain*: its triangles have records of their own, in world space;
- *copied*: Embree has its triangles in world space; the records are the mesh's, in object space;
- *nested*: it is not placed at all: rays are taken to the mesh (see `nested`).

A *prototype* is a mesh under a choice of materials; its records hold for all who share it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .accel import Copy, corners
from .geometry import GAMMA6, Float32, Float64, Int32, near, transformed, world_boxes
from .snapshot import Snapshot
from .transforms import Transforms, inverses

PLAIN = -1
MANY = 500_000  # triangles that sharing must be about: below it would spare less than a wavefront takes
SQUEEZED = 1e-3  # smallest stretch over the largest; records of flatter instances would lose their digits
SIZES = 1e-6, 1e6  # of a matrix's stretch: the squares of its inverse stay within float32
GAMMA18 = 3 * GAMMA6  # bounds the roundings of a transformed plane and of a ray taken to object space


class Sharing(NamedTuple):
    """Who shares what.

    Attributes
    ----------
    prototype : (I,) int32
        Of each instance; `PLAIN` for those with records of their own.
    sample : (P,) int32
        An instance of each prototype, which tells its mesh and materials.
    nested : (P,) bool
        Whether a prototype's instances are not placed.
    """

    prototype: Int32
    sample: Int32
    nested: NDArray[np.bool_]

    def placed(self) -> Int32:
        """Numbers of the copied instances, those of one prototype after another."""
        return self._of(~self.nested)

    def left_out(self) -> Int32:
        """Numbers of the nested ones."""
        return self._of(self.nested)

    def _of(self, wanted: NDArray[np.bool_]) -> Int32:
        shared = np.flatnonzero(self.prototype != PLAIN)
        shared = shared[np.argsort(self.prototype[shared], kind="stable")]
        return shared[wanted[self.prototype[shared]]].astype(np.int32)


def candidates(snapshot: Snapshot, apart: NDArray[np.bool_]) -> Sharing | None:
    """All that may share; None where it would spare little. `apart` (I,) are instances that may not."""
    meshes, instances = snapshot.meshes, snapshot.instances
    count = np.array([len(mesh.triangles) for mesh in meshes], np.int64)[instances.mesh]
    if int(count.sum()) < MANY:
        return None
    sound = np.array([bool(near(mesh.vertices).all()) for mesh in meshes])
    free = sound[instances.mesh] & moderate(instances.matrix) & ~apart & (count > 0)
    key = np.concatenate([instances.mesh[:, None], instances.materials], axis=1)
    _, sample, kind, times = np.unique(
        key[free], axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    kind = kind.reshape(-1)
    several = times > 1
    number = np.where(several, np.cumsum(several) - 1, PLAIN)
    prototype = np.full(len(free), PLAIN, np.int32)
    prototype[free] = number[kind]
    if int(count[prototype != PLAIN].sum()) < MANY:
        return None
    chosen = np.flatnonzero(free)[sample[several]].astype(np.int32)
    return Sharing(prototype, chosen, np.zeros(len(chosen), np.bool_))


def moderate(matrix: Float64) -> NDArray[np.bool_]:
    """(I,) whether planes go through the matrices (I, 4, 4) and back without great loss."""
    finite = np.isfinite(matrix).all(axis=(1, 2))
    stretch = np.linalg.svd(np.where(finite[:, None, None], matrix, 0)[:, :3, :3], compute_uv=False)
    inside = (stretch[:, 2] >= SIZES[0]) & (stretch[:, 0] <= SIZES[1])
    return np.asarray(finite & inside & (stretch[:, 2] >= SQUEEZED * stretch[:, 0]))


class Shared:
    """Planes of shared records, in world space.

    Parameters
    ----------
    snapshot : Snapshot
    origin : (3,) float64
        World position of the recentred zero.
    """

    def __init__(self, snapshot: Snapshot, origin: Float64) -> None:
        instances = snapshot.instances
        self._transforms = Transforms(instances.matrix, origin)
        self._bound = error_bounds(snapshot, origin).astype(np.float32)

    def planes(self, record: Float32, instance: Int32) -> Float32:
        """(5, N) normals, offsets and bounds of object-space records (5 or more, N)."""
        normal, plane = self._transforms.plane_to_world(
            np.ascontiguousarray(record[:3]), np.ascontiguousarray(record[3]), instance
        )
        return np.concatenate([normal, plane[None], self._bound.take(instance)[None]])


def error_bounds(snapshot: Snapshot, origin: Float64) -> Float64:
    """(I,) how far along the normal rounding may take a point of each instance.

    Three things round: the point itself and the plane, by what the world's coordinates allow; the point's
    way to object space, M⁻¹(p − place), which comes back through M: |M||M⁻¹| |p − place|; and Embree's own
    arithmetic there, by the mesh's coordinates, which M stretches.
    """
    instances = snapshot.instances
    low, high = world_boxes(snapshot.meshes, instances)
    place, linear = instances.matrix[:, :3, 3], instances.matrix[:, :3, :3]
    inverse, _ = inverses(linear)
    with np.errstate(invalid="ignore", over="ignore"):
        reach = np.abs([low - origin, high - origin, place - origin]).max(axis=0)
        own = np.abs([low - place, high - place]).max(axis=0)
        there_and_back = np.einsum("kij,kjl,kl->ki", np.abs(linear), np.abs(inverse), own)
        bound = (reach + 2 * there_and_back).sum(axis=1) * GAMMA18
    return np.asarray(np.nan_to_num(bound, posinf=0.0))


def copies(snapshot: Snapshot, sharing: Sharing, first: NDArray[np.int64], origin: Float64) -> Iterator[Copy]:
    """What Embree is to hold of the copied instances, whose records begin at `first` (I + 1,)."""
    meshes, instances, last = snapshot.meshes, snapshot.instances, PLAIN
    index = corners(np.zeros((0, 3), np.int32))
    for k in sharing.placed():
        mesh, number = meshes[instances.mesh[k]], int(sharing.prototype[k])
        if number != last:
            index, last = corners(mesh.triangles), number
        matrix = instances.matrix[k].copy()
        matrix[:3, 3] -= origin
        yield Copy(transformed(mesh.vertices, matrix), index, int(k), int(first[k]))
