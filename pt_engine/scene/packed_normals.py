"""Normals as Cycles 5 keeps them: a point of the octahedron |x| + |y| + |z| = 1, unfolded, in 2 × 16 bits.

Two that lie within 3e-5 of each other may become the same, and what points along an axis comes out beside
it, as a flat face's own normal does not: MikkTSpace takes corners with equal normals for one vertex.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]

HALF = np.float32(65535 / 2)


def packed(normals: Float32) -> Float32:
    """(N, 3) unit normals as they come out again."""
    n = np.ascontiguousarray(normals, np.float32)
    x, y = (n[:, :2] / (np.abs(n).sum(axis=1, keepdims=True) + np.float32(1e-6))).T
    below = n[:, 2] < 0
    stored = [np.clip(v * HALF + (HALF + np.float32(0.5)), 0, 65535) for v in folded(x, y, below)]
    x, y = (np.floor(v) * (1 / HALF) - 1 for v in stored)
    z = 1 - np.abs(x) - np.abs(y)
    x, y = folded(x, y, z < 0)
    out = np.stack([x, y, z], axis=1)
    unit: Float32 = out / np.sqrt((out * out).sum(axis=1, keepdims=True))
    return unit


def folded(x: Float32, y: Float32, below: NDArray[np.bool_]) -> tuple[Float32, Float32]:
    """The octahedron's lower half, folded out or in about the edges of the upper one."""
    return (
        np.where(below, (1 - np.abs(y)) * np.copysign(np.float32(1), x), x),
        np.where(below, (1 - np.abs(x)) * np.copysign(np.float32(1), y), y),
    )
