"""Object spaces: gathers each lane's instance matrix and applies it."""

from __future__ import annotations

import copy

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]


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
        inverse = np.array([inverted(m) for m in linear]).reshape(-1, 3, 3)
        normal = np.array([inverse_transposed(m) for m in linear])
        with np.errstate(over="ignore", invalid="ignore"):  # of objects beyond float32, which nothing hits
            offset = -np.einsum("kij,kj->ki", inverse, matrix[:, :3, 3] - origin)
            self._linear = linear.reshape(-1, 9).astype(np.float32)
            self._inverse = inverse.reshape(-1, 9).astype(np.float32)
            self._normal = normal.reshape(-1, 9).astype(np.float32)
            self._offset = offset.astype(np.float32)
            self._place = (matrix[:, :3, 3] - origin).astype(np.float32)
            self._location = matrix[:, :3, 3].astype(np.float32)

    def with_last(self, matrix: Float64, origin: Float64) -> Transforms:
        """The same with other matrices (M, 4, 4) for the last M instances."""
        moved, joined = Transforms(matrix, origin), copy.copy(self)
        for name, last in vars(moved).items():
            rows = vars(self)[name]
            setattr(joined, name, np.concatenate([rows[: len(rows) - len(last)], last]))
        return joined

    def vector_to_world(self, w: Float32, instance: Int32) -> Float32:
        """(3, N) object-space vectors in world space."""
        return _apply(self._linear.take(instance, axis=0), w)

    def vector_to_object(self, w: Float32, instance: Int32) -> Float32:
        """(3, N) world vectors in object space."""
        return _apply(self._inverse.take(instance, axis=0), w)

    def point_to_object(self, p: Float32, instance: Int32) -> Float32:
        """(3, N) recentred world positions in object space."""
        rotated = _apply(self._inverse.take(instance, axis=0), p)
        rotated += self._offset.take(instance, axis=0).T
        return rotated

    def point_to_world(self, p: Float32, instance: Int32) -> Float32:
        """(3, N) object-space positions in the recentred world."""
        moved = self.vector_to_world(p, instance)
        moved += self._place.take(instance, axis=0).T
        return moved

    def normal_to_world(self, n: Float32, instance: Int32) -> Float32:
        """(3, N) object-space normals in world space: along the inverse's transpose (unnormalised)."""
        return _apply(self._normal.take(instance, axis=0), n)

    def normal_to_object(self, n: Float32, instance: Int32) -> Float32:
        """(3, N) world normals in object space (unnormalised)."""
        return _apply_transposed(self._linear.take(instance, axis=0), n)

    def location(self, instance: Int32) -> Float32:
        """(3, N) world position of each lane's object."""
        return np.ascontiguousarray(self._location.take(instance, axis=0).T)


def inverse_transposed(m: Float64) -> Float64:
    """M⁻ᵀ = cof(M) / det M; of a flattened object, which has no inverse, the cofactors: same directions."""
    if not np.isfinite(m).all():
        return np.eye(3)
    a, b, c = m.T
    with np.errstate(over="ignore", invalid="ignore"):  # of objects beyond float32, which nothing hits
        cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    largest = float(np.abs(cofactors).max()) if np.isfinite(cofactors).all() else 0.0
    if largest == 0.0:
        return np.eye(3)
    determinant = float(np.linalg.det(m))
    flat = abs(determinant) < 1e-12 * largest**1.5
    return np.asarray(cofactors / (np.copysign(largest, determinant) if flat else determinant))


def inverted(m: Float64) -> Float64:
    """Inverse of a 3×3 matrix; of a flattened object, the one that undoes it within its plane."""
    if not np.isfinite(m).all():
        return np.eye(3)
    stretch = np.linalg.svd(m, compute_uv=False)
    # a determinant that is only rounding would give an inverse of the size of its reciprocal
    return np.linalg.pinv(m, rcond=1e-8) if stretch[2] <= 1e-8 * stretch[0] else np.linalg.inv(m)


def _apply(m: Float32, w: Float32) -> Float32:
    x, y, z = w
    return np.stack([m[:, 3 * i] * x + m[:, 3 * i + 1] * y + m[:, 3 * i + 2] * z for i in range(3)])


def _apply_transposed(m: Float32, w: Float32) -> Float32:
    x, y, z = w
    return np.stack([m[:, i] * x + m[:, i + 3] * y + m[:, i + 6] * z for i in range(3)])
