"""Edge attributes as Blender hands them to vertices, since Cycles has no edges.

A vertex gets the mean of its edges' values; of flags whether any is set, of whole numbers the nearest one, of
byte colours the mean of the bytes, of rotations that of their axes times angles.
"""

from __future__ import annotations

import numpy as np


def mean_at_vertices(values, edges, count: int, data_type: str):
    """(V, ...) of (E, ...) values.

    Parameters
    ----------
    values : (E,) or (E, C)
        Byte colours sRGB in [0, 1], as they are stored.
    edges : (E, 2) int32
    count : int
        Vertices.
    """
    if data_type == "QUATERNION":
        turns = mean_at_vertices(rotation_vectors(values), edges, count, "FLOAT_VECTOR")
        return quaternions(turns)
    total = np.zeros((count, *values.shape[1:]))
    for end in (0, 1):
        np.add.at(total, edges[:, end], values)
    if data_type == "BOOLEAN":
        return total > 0
    used = np.bincount(edges.ravel(), minlength=count).reshape(-1, *[1] * (values.ndim - 1))
    mean = total / np.maximum(used, 1)
    if data_type in ("INT", "INT8"):
        return np.copysign(np.floor(np.abs(mean) + 0.5), mean)  # halves away from zero
    if data_type == "BYTE_COLOR":
        mean = decoded(np.floor(mean * 255) / 255)
    return mean.astype(np.float32)


def decoded(srgb):
    """Linear values of sRGB colours; alpha is linear already."""
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    linear[:, 3] = srgb[:, 3]
    return linear


def rotation_vectors(q):
    """(E, 3) axis times angle of quaternions (w, x, y, z)."""
    size = np.linalg.norm(q.astype(np.float64), axis=1, keepdims=True)
    q = q / (size + (size == 0))
    half = np.arccos(np.clip(q[:, :1], -1, 1))
    sine = np.sin(half)  # Blender, too, does not divide by less than 0.0005
    return q[:, 1:] / np.where(np.abs(sine) < 0.0005, 1, sine) * 2 * half


def quaternions(turns):
    """(V, 4) unit quaternions of rotation vectors, w not negative."""
    angle = np.linalg.norm(turns, axis=1, keepdims=True)
    axis = turns / (angle + (angle == 0))
    q = np.concatenate([np.cos(angle / 2), axis * np.sin(angle / 2)], axis=1)
    return np.where(q[:, :1] < 0, -q, q).astype(np.float32)
