"""Tables read between their nodes, linearly along each axis.

In one order for constants and for lanes, so that a lane's result has the same bits whether its parameters
come as an array or as one number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .base import Float32

Int32 = NDArray[np.int32]


def cell(x: Float32, size: int) -> tuple[Int32, Float32]:
    """The node below x in [0, 1] on an axis of `size` nodes, and how far x is beyond it."""
    at = np.minimum(np.maximum(x, 0.0), 1.0) * np.float32(size - 1)
    index = np.minimum(at.astype(np.int32), size - 2)
    fraction: Float32 = (at - index).astype(np.float32)
    return index, fraction


def lerp(table: Float32, first: Int32, second: Int32, t: Float32) -> Float32:
    """Between two entries of a flat table."""
    low = table.take(first, mode="clip")
    blended: Float32 = low + t * (table.take(second, mode="clip") - low)
    return blended


def line(table: Float32, x: Float32) -> Float32:
    """Table [X]."""
    i, t = cell(x, len(table))
    return lerp(table, i, i + 1, t)


def plane(table: Float32, x: Float32, y: Float32) -> Float32:
    """Table [X, Y]: first along x, then along y."""
    columns = table.shape[1]
    i, t = cell(x, table.shape[0])
    j, u = cell(y, columns)
    table = table.ravel()
    if i.size == 1:  # one x: blend two rows once
        nodes = np.arange(columns, dtype=np.int32)
        blended = lerp(table, i * columns + nodes, (i + 1) * columns + nodes, t)
        return lerp(blended, j, j + 1, u)
    base = i * columns + j
    low = lerp(table, base, base + columns, t)
    high = lerp(table, base + 1, base + columns + 1, t)
    value: Float32 = low + u * (high - low)
    return value
