"""The random gradients at the corners of Perlin noise's cells, for blocks of lanes.

What is wanted is where in a table each corner's gradients are, of two lanes at a time. Two ways lead there:
hashing every lane's corners, or, where many lanes share few cells, hashing the lattice around them once (see
`grids`). Both give the same, so the way never shows.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..core.memory import Memory
from .hashes import SEED, hash_uints

Float32 = NDArray[np.float32]
UInt32 = NDArray[np.uint32]
Index = NDArray[np.intp]  # what `take` takes without a copy
Step = tuple[np.ufunc, NDArray[Any], NDArray[Any], NDArray[Any]]  # of two numbers, and where the result goes
Turned = dict[tuple[int, ...], tuple[UInt32, UInt32]]  # by shape, room for the parts of rotated numbers

SIZES: Final = {1: 16, 2: 8, 3: 16, 4: 32}  # gradients to choose from, by dimension
NUMBER: Final = [np.array(k, np.uint32) for k in range(32)]  # ufuncs take arrays faster than numbers


def along(axis: int, axes: int) -> list[int]:
    """Shape of one axis' two corners; the first axis is the outermost."""
    return [2 if k == axis else 1 for k in range(axes)]


class Hashes:
    """`hashes.hash_uints` of the corners of a block's cells, cut down to the bits that choose a gradient.

    These are the last 5 of the last sum, to which bits 8 to 12 of the step before are added, and so the last
    13 of that. `work` is room for four numbers at each corner, the first axis the outermost, of each lane;
    `memory` has room for the rest.
    """

    def __init__(self, dimension: int, active: tuple[int, ...], work: UInt32, memory: Memory) -> None:
        self.dimension, axes = dimension, len(active)
        a, b, c, spare = work
        self.c: UInt32 = c
        n = work.shape[-1]
        self.start = np.array((SEED + 4 * dimension) & 0xFFFFFFFF, np.uint32)
        self.corners = memory.array((2, dimension, n), np.uint32)
        self.keys = [corner.reshape((1,) * axes + (n,)) for corner in self.corners[0]]
        for k, axis in enumerate(active):
            self.keys[axis] = self.corners[:, axis].reshape(*along(k, axes), n)
        x, y, z = [*self.keys, self.start, self.start][:3]
        first = memory.array(np.broadcast_shapes(y.shape, z.shape), np.uint32)
        turned = {shape: halves(spare, shape) for shape in (y.shape, first.shape, a.shape)}
        # with bytes one up the next 8 bits come to lie on the lowest ones, without a shift
        last, next_ = (bits.reshape(-1).view(np.uint8) for bits in (c, b))
        self.steps: list[Step] = [
            *mixed(z, y, 14, first, turned),
            *mixed(x, first, 11, a, turned),
            *mixed(y, a, 25, b, turned),
            *mixed(first, b, 16, c, turned),
            *mixed(a, c, 4, a, turned),
            (np.bitwise_xor, b, a, b),
            (np.right_shift, a, NUMBER[18], a),
            (np.subtract, b, a, b),
            (np.bitwise_xor, c, b, c),
            (np.subtract, last[:-1], next_[1:], last[:-1]),  # c −= b >> 8
        ]
        flat = spare.reshape(-1).view(np.uint8)[: spare.size]
        self.bytes, self.packed = flat.reshape(spare.shape), flat.view(np.uint32)
        self.mask = np.array(0x01010101 * (SIZES[dimension] - 1), np.uint32)

    def pairs(self, low: Float32, index: Index) -> None:
        """Where in `perlin.APART` the corners of the cells `low` are, lane after lane in pairs."""
        cell = self.corners[0]
        np.copyto(cell.view(np.int32), low, casting="unsafe")
        np.copyto(self.bytes, self.of_corners(cell), casting="unsafe")
        np.bitwise_and(self.packed, self.mask, self.packed)
        np.copyto(index, self.bytes.view(np.uint16))

    def of_corners(self, cell: UInt32) -> UInt32:
        """Right in the lowest 5 bits."""
        if self.dimension == 4:
            self.corners[0] = cell
            np.add(cell, NUMBER[1], self.corners[1])
            return hash_uints(*self.keys)
        near, far = self.corners
        np.add(cell, self.start, near)
        np.add(near, NUMBER[1], far)
        for ufunc, x, y, out in self.steps:
            ufunc(x, y, out)
        return self.c


def mixed(x: UInt32, y: UInt32, k: int, out: UInt32, turned: Turned) -> list[Step]:
    """(x ^ y) − (y rotated left by k), which is put together first where y has few corners."""
    left, right = turned[y.shape]
    steps: list[Step] = [(np.bitwise_xor, x, y, out), (np.left_shift, y, NUMBER[k], left)]
    if left is right:
        steps.append((np.subtract, out, left, out))
    steps.append((np.right_shift, y, NUMBER[32 - k], right))
    if left is not right:
        steps.append((np.bitwise_or, left, right, left))
    return [*steps, (np.subtract, out, left, out)]


def halves(room: UInt32, shape: tuple[int, ...]) -> tuple[UInt32, UInt32]:
    """Where the two parts of rotated numbers go: where these are few into two places, else into the same."""
    flat, size = room.reshape(-1), math.prod(shape)
    left = flat[:size].reshape(shape)
    return left, flat[size : 2 * size].reshape(shape) if 2 * size <= flat.size else left
