"""Object spaces: gathers each lane's instance matrix and applies it."""

from __future__ import annotations

import copy

import numpy as np
from numpy.typing import NDArray

from ..core import vectors

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]

REGULAR = 1e-6  # smallest stretch over the largest: below it an inverse takes care


class Transforms:
    """Matrices of all instances, about the recentred world.

    Parameters
    ----------
    matrix : (I, 4, 4) float64
        Object to world.
    origin : (3,) float64
        World position of the recentred zero.
    """

    def __init__(self, matrix: Float64, origin: Float64) -> None:
        linear = matrix[:, :3, :3]
        inverse, normal = inverses(linear)
        with np.errstate(over="ignore", invalid="ignore"):  # of objects beyond float32, which nothing hits
            offset = -np.einsum("kij,kj->ki", inverse, matrix[:, :3, 3] - origin)
            self._linear = linear.reshape(-1, 9).astype(np.float32)
            self._inverse = inverse.reshape(-1, 9).astype(np.float32)
            self._normal = normal.reshape(-1, 9).astype(np.float32)
            self._offset = offset.astype(np.float32)
            self._place = (matrix[:, :3, 3] - origin).astype(np.float32)
            self._location = matrix[:, :3, 3].astype(np.float32)

    def ray_to_object(self, o: Float32, d: Float32, instance: Int32) -> tuple[Float32, Float32]:
        """Origins and directions (3, N), not made unit ones, so that distances stay what they are.

        An origin near its object loses no digits, wherever that stands.
        """
        inverse = self._inverse.take(instance, axis=0)
        return _apply(inverse, o - self._place.take(instance, axis=0).T), _apply(inverse, d)

    def plane_to_world(self, n: Float32, plane: Float32, instance: Int32) -> tuple[Float32, Float32]:
        """Unit normals (3, N) and offsets (N,) of planes n·x = plane of object space; 0 of none."""
        turned = self.normal_to_world(n, instance)
        offset = plane + vectors.dot(turned, np.ascontiguousarray(self._place.take(instance, axis=0).T))
        length = vectors.length(turned)
        scale = (length > 0) / (length + (length == 0))
        return turned * scale, offset * scale

    def with_last(self, matrix: Float64, origin: Float64) -> Transforms:
        """The same with other matrices (M, 4, 4) for the last M instances."""
        moved, joined = Transforms(matrix, origin), copy.copy(self)
        for name, last in vars(moved).items():
            rows = vars(self)[name]
            setattr(joined, name, np.concatenate([rows[: len(rows) - len(last)], last]))
        return joined

    def vector_to_world(self, w: Float32, instance: Int32) -> Float32:
        """(3, N) object-space vectors in world space."""
        return _apply(_of(self._linear, instance), w)

    def vector_to_object(self, w: Float32, instance: Int32) -> Float32:
        """(3, N) world vectors in object space."""
        return _apply(_of(self._inverse, instance), w)

    def point_to_object(self, p: Float32, instance: Int32) -> Float32:
        """(3, N) recentred world positions in object space."""
        rotated = _apply(_of(self._inverse, instance), p)
        rotated += _of(self._offset, instance).T
        return rotated

    def point_to_world(self, p: Float32, instance: Int32) -> Float32:
        """(3, N) object-space positions in the recentred world."""
        moved = self.vector_to_world(p, instance)
        moved += _of(self._place, instance).T
        return moved

    def normal_to_world(self, n: Float32, instance: Int32) -> Float32:
        """(3, N) object-space normals in world space: along the inverse's transpose (unnormalised)."""
        return _apply(_of(self._normal, instance), n)

    def normal_to_object(self, n: Float32, instance: Int32) -> Float32:
        """(3, N) world normals in object space (unnormalised)."""
        return _apply_transposed(_of(self._linear, instance), n)

    def location(self, instance: Int32) -> Float32:
        """(3, N) world position of each lane's object."""
        return np.ascontiguousarray(self._location.take(instance, axis=0).T)


def inverses(linear: Float64) -> tuple[Float64, Float64]:
    """Inverses and inverse transposes of (I, 3, 3) matrices, all regular ones at once."""
    inverse = np.tile(np.eye(3), (len(linear), 1, 1))
    normal = inverse.copy()
    finite = np.isfinite(linear).all(axis=(1, 2))
    safe = np.where(finite[:, None, None], linear, 0.0)
    stretch = np.linalg.svd(safe, compute_uv=False) if len(linear) else np.zeros((0, 3))
    regular = np.flatnonzero(stretch[:, 2] > REGULAR * stretch[:, 0])
    inverse[regular] = np.linalg.inv(linear[regular])
    normal[regular] = inverse[regular].transpose(0, 2, 1)
    for k in np.flatnonzero(finite & ~(stretch[:, 2] > REGULAR * stretch[:, 0])):
        inverse[k], normal[k] = inverted(linear[k]), inverse_transposed(linear[k])
    return inverse, normal


def inverse_transposed(m: Float64) -> Float64:
    """M⁻ᵀ = cof(M) / det M; of a flattened object, which has no inverse, the cofactors: same directions.

    Cofactors and determinants are of second and third degree: they are made of M over its largest element.
    """
    size = float(np.abs(m).max())
    if not 0 < size < np.inf:
        return np.eye(3)
    own = m / size
    a, b, c = own.T
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    largest = float(np.abs(cofactors).max())
    if largest == 0.0:
        return np.eye(3)
    determinant = float(np.linalg.det(own))
    if abs(determinant) < 1e-12 * largest**1.5:
        return np.asarray(cofactors / np.copysign(largest, determinant))
    return np.asarray(cofactors / determinant / size)


def inverted(m: Float64) -> Float64:
    """Inverse of a 3×3 matrix; of a flattened object, the one that undoes it within its plane."""
    if not np.isfinite(m).all():
        return np.eye(3)
    stretch = np.linalg.svd(m, compute_uv=False)
    # a determinant that is only rounding would give an inverse of the size of its reciprocal
    return np.linalg.pinv(m, rcond=1e-8) if stretch[2] <= 1e-8 * stretch[0] else np.linalg.inv(m)


def _of(rows: Float32, instance: Int32) -> Float32:
    """The rows of some lanes' instances, or the one that all of them have."""
    alike = len(instance) and (instance == instance[0]).all()
    return rows.take(instance[:1] if alike else instance, axis=0)


def _apply(m: Float32, w: Float32) -> Float32:
    x, y, z = w
    return np.stack([m[:, 3 * i] * x + m[:, 3 * i + 1] * y + m[:, 3 * i + 2] * z for i in range(3)])


def _apply_transposed(m: Float32, w: Float32) -> Float32:
    x, y, z = w
    return np.stack([m[:, i] * x + m[:, i + 3] * y + m[:, i + 6] * z for i in range(3)])
