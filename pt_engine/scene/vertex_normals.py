"""Normals of faces and vertices of triangle meshes, rows of (n, 3) arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]


def unit_rows(a: Float64) -> Float64:
    """Rows at unit length; zero rows stay zero."""
    size = np.linalg.norm(a, axis=1 if a.ndim == 2 else 2, keepdims=True)
    unit: Float64 = a / (size + (size == 0))
    return unit


def face_normals(vertices: Float32, triangles: Int32) -> Float64:
    """(T, 3) unit normals; zero for a degenerate triangle."""
    a, b, c = (vertices[triangles[:, k]].astype(np.float64) for k in range(3))
    return unit_rows(np.cross(b - a, c - a))


def mean_of_faces(vertices: Float32, triangles: Int32) -> Float32:
    """(V, 3) unit mean of the unit normals of the triangles around each vertex, all alike."""
    return _summed(face_normals(vertices, triangles), np.ones((len(triangles), 3)), len(vertices), triangles)


def angle_weighted(vertices: Float32, triangles: Int32) -> Float32:
    """(V, 3) unit mean weighted by each triangle's angle at the vertex, as in Blender."""
    corner = vertices[triangles].astype(np.float64)
    angle = np.empty((len(triangles), 3))
    for k in range(3):
        one = unit_rows(corner[:, (k + 1) % 3] - corner[:, k])
        other = unit_rows(corner[:, (k + 2) % 3] - corner[:, k])
        angle[:, k] = np.arccos(np.clip((one * other).sum(axis=1), -1, 1))
    return _summed(face_normals(vertices, triangles), angle, len(vertices), triangles)


def _summed(normal: Float64, weight: Float64, count: int, triangles: Int32) -> Float32:
    vertex = triangles.ravel()
    total = np.stack(
        [np.bincount(vertex, (normal[:, None, axis] * weight).ravel(), count) for axis in range(3)], axis=1
    )
    return unit_rows(total).astype(np.float32)
