"""The random gradients at the corners of Perlin noise's cells, for blocks of lanes.

What is wanted is where in a table each corner's gradients are, of two lanes at a time. Two ways lead there:
hashing every lane's corners, or, where many lanes share few cells, hashing the lattice around them once (see
`grids`). Both give the same, so the way never shows.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..core.memory import Memory
from .hashes import SEED, hash_uints

Float32 = NDArray[np.float32]
UInt32 = NDArray[np.uint32]
Index = NDArray[np.intp]  # what `take` takes without a copy

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
        self.a, self.b, self.c, spare = work
        n = work.shape[-1]
        self.start = np.array((SEED + 4 * dimension) & 0xFFFFFFFF, np.uint32)
        self.corners = memory.array((2, dimension, n), np.uint32)
        self.keys = [corner.reshape((1,) * axes + (n,)) for corner in self.corners[0]]
        for k, axis in enumerate(active):
            self.keys[axis] = self.corners[:, axis].reshape(*along(k, axes), n)
        self.three = [*self.keys, self.start, self.start][:3]
        _, y, z = self.three
        self.first = memory.array(np.broadcast_shapes(y.shape, z.shape), np.uint32)
        self.turned = {y.shape: halves(spare, y.shape) for y in (y, self.first, self.a)}
        # with bytes one up the next 8 bits come to lie on the lowest ones, without a shift
        self.last, self.next = (bits.reshape(-1).view(np.uint8) for bits in (self.c, self.b))
        self.last, self.next = self.last[:-1], self.next[1:]
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
        x, y, z = self.three
        first, a, b = self.first, self.a, self.b
        c: UInt32 = self.c
        self._step(z, y, 14, first)
        self._step(x, first, 11, a)
        self._step(y, a, 25, b)
        self._step(first, b, 16, c)
        self._step(a, c, 4, a)
        b ^= a
        a >>= NUMBER[18]
        b -= a
        c ^= b
        np.subtract(self.last, self.next, self.last)  # c −= b >> 8
        return c

    def _step(self, x: UInt32, y: UInt32, k: int, out: UInt32) -> None:
        """(x ^ y) − (y rotated left by k), which is put together first where y has few corners."""
        left, right = self.turned[y.shape]
        np.bitwise_xor(x, y, out)
        np.left_shift(y, NUMBER[k], left)
        if left is right:
            out -= left
        np.right_shift(y, NUMBER[32 - k], right)
        if left is not right:
            left |= right
        out -= left


def halves(room: UInt32, shape: tuple[int, ...]) -> tuple[UInt32, UInt32]:
    """Where the two parts of rotated numbers go: where these are few into two places, else into the same."""
    flat, size = room.reshape(-1), math.prod(shape)
    left = flat[:size].reshape(shape)
    return left, flat[size : 2 * size].reshape(shape) if 2 * size <= flat.size else left
