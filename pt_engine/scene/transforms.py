"""Object spaces: gathers each lane's instance matrix and applies it."""

from __future__ import annotations

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
        inverse = np.zeros_like(linear)
        for k, m in enumerate(linear):
            # a flattened object (zero scale) has no inverse; the pseudo-inverse keeps it finite
            inverse[k] = np.linalg.pinv(m) if abs(np.linalg.det(m)) < 1e-30 else np.linalg.inv(m)
        offset = -np.einsum("kij,kj->ki", inverse, matrix[:, :3, 3] - origin)
        self._linear = linear.reshape(-1, 9).astype(np.float32)
        self._inverse = inverse.reshape(-1, 9).astype(np.float32)
        self._offset = offset.astype(np.float32)
        self._location = matrix[:, :3, 3].astype(np.float32)

    def vector_to_world(self, w: Float32, instance: Int32) -> Float32:
        """(3, N) object-space vectors in world space."""
        return _apply(self._linear.take(instance, axis=0), w)

    def vector_to_object(self, w: Float32, instance: Int32) -> Float32:
        """(3, N) world vectors in object space."""
        return _apply(self._inverse.take(instance, axis=0), w)

    def point_to_object(self, p: Float32, instance: Int32) -> Float32:
        """(3, N) recentred world positions in object space."""
        return _apply(self._inverse.take(instance, axis=0), p) + self._offset.take(instance, axis=0).T

    def normal_to_world(self, n: Float32, instance: Int32) -> Float32:
        """(3, N) object-space normals in world space: the inverse's transpose (unnormalised)."""
        return _apply_transposed(self._inverse.take(instance, axis=0), n)

    def normal_to_object(self, n: Float32, instance: Int32) -> Float32:
        """(3, N) world normals in object space (unnormalised)."""
        return _apply_transposed(self._linear.take(instance, axis=0), n)

    def location(self, instance: Int32) -> Float32:
        """(3, N) world position of each lane's object."""
        return np.ascontiguousarray(self._location.take(instance, axis=0).T)


def _apply(m: Float32, w: Float32) -> Float32:
    x, y, z = w
    return np.stack([m[:, 3 * i] * x + m[:, 3 * i + 1] * y + m[:, 3 * i + 2] * z for i in range(3)])


def _apply_transposed(m: Float32, w: Float32) -> Float32:
    x, y, z = w
    return np.stack([m[:, i] * x + m[:, i + 3] * y + m[:, i + 6] * z for i in range(3)])
