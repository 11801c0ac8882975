"""The random gradients at the corners of Perlin noise's cells, for blocks of lanes.

What is wanted is where in `perlin.PAIRS` each corner's gradients are, of two lanes at a time. Two ways lead
there: hashing every lane's corners, or, where many lanes share few cells, hashing the lattice around them
once. Both give the same, so the way never shows.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .hashes import SEED, hash_uints

Float32 = NDArray[np.float32]
UInt32 = NDArray[np.uint32]
Index = NDArray[np.intp]  # what `take` takes without a copy

SIZES: Final = {1: 16, 2: 8, 3: 16, 4: 32}  # gradients to choose from, by dimension
SHIFT: Final = [np.array(k, np.uint32) for k in range(32)]  # ufuncs take arrays faster than numbers
FEW: Final = 2048  # lanes beside which a grid's calls cost more than it spares
DEAR: Final = 2.5  # times as much as a point of a grid a lane's corners cost


def along(axis: int, axes: int) -> list[int]:
    """Shape of one axis' two corners; the first axis is the innermost."""
    return [2 if k == axes - 1 - axis else 1 for k in range(axes)]


class Hashes:
    """`hashes.hash_uints` of the corners of a block's cells, cut down to the bits that choose a gradient.

    These are the last 5 of the last sum, to which bits 8 to 12 of the step before are added, and so the last
    13 of that. `work` is room for four numbers at each corner, the first axis the innermost, of each lane.
    """

    def __init__(self, dimension: int, active: tuple[int, ...], work: UInt32) -> None:
        self.dimension, axes = dimension, len(active)
        self.a, self.b, self.c, spare = work
        self.spare, n = spare.reshape(-1), work.shape[-1]
        self.start = np.array((SEED + 4 * dimension) & 0xFFFFFFFF, np.uint32)
        self.corners = np.empty((dimension, 2, n), np.uint32)
        self.keys = [corner[0].reshape((1,) * axes + (n,)) for corner in self.corners]
        for k, axis in enumerate(active):
            self.keys[axis] = self.corners[axis].reshape(*along(k, axes), n)
        keys = [*self.keys, self.start, self.start][:3]
        self.first = np.empty(np.broadcast_shapes(keys[1].shape, keys[2].shape), np.uint32)
        bits = SIZES[dimension].bit_length() - 1
        self.side_by_side = np.tile(np.array([32 - bits, 0], np.uint32), n // 2)
        self.rest, self.both = np.array(32 - bits, np.uint64), np.array((1 << 2 * bits) - 1, np.uint64)

    def pairs(self, low: Float32, index: Index) -> None:
        """Where in `PAIRS` the corners of the cells `low` are, lane after lane in pairs."""
        found = self.of_corners(low.astype(np.int32).view(np.uint32))
        # of the two in 64 bits the first one's last bits come to lie below those of the second
        np.left_shift(found, self.side_by_side, out=found)
        wide, out = found.view(np.uint64), index.view(np.uint64)  # may be the same memory
        np.right_shift(wide, self.rest, out=out)
        out &= self.both

    def of_corners(self, cell: UInt32) -> UInt32:
        """Right in the lowest 5 bits."""
        if self.dimension == 4:
            self.corners[:, 0] = cell
            np.add(cell, np.uint32(1), out=self.corners[:, 1])
            return hash_uints(*self.keys)
        near = np.add(cell, self.start, out=self.corners[:, 0])
        np.add(near, np.uint32(1), out=self.corners[:, 1])
        x, y, z = [*self.keys, self.start, self.start][:3]
        first, a, b = self.first, self.a, self.b
        c: UInt32 = self.c
        self._step(z, y, 14, first)
        self._step(x, first, 11, a)
        self._step(y, a, 25, b)
        self._step(first, b, 16, c)
        self._step(a, c, 4, a)
        b ^= a
        a >>= SHIFT[18]
        b -= a
        c ^= b
        b >>= SHIFT[8]
        c -= b
        return c

    def _step(self, x: UInt32, y: UInt32, k: int, out: UInt32) -> None:
        """(x ^ y) − (y rotated left by k)."""
        spare = self.spare[: y.size].reshape(y.shape)
        np.bitwise_xor(x, y, out=out)
        np.left_shift(y, SHIFT[k], out=spare)
        if 2 * y.size <= self.spare.size:  # y has fewer corners than the rest: put it together there
            right = self.spare[y.size : 2 * y.size].reshape(y.shape)
            spare |= np.right_shift(y, SHIFT[32 - k], out=right)
        else:
            out -= spare
            np.right_shift(y, SHIFT[32 - k], out=spare)
        out -= spare


class Grid:
    """The hashes of all lattice points around some lanes, where those are fewer than the lanes."""

    def __init__(self, first: list[float], count: list[int]) -> None:
        self.dimension = len(count)
        keys = []
        for axis, (low, n) in enumerate(zip(first, count, strict=True)):
            shape = [n if k == self.dimension - 1 - axis else 1 for k in range(self.dimension)]
            keys.append((np.int32(low) + np.arange(n, dtype=np.int32)).view(np.uint32).reshape(shape))
        size = SIZES[self.dimension]
        kind: Any = np.uint8 if size <= 16 else np.uint16  # two of them have room in it
        self._hash = (hash_uints(*keys) & np.uint32(size - 1)).ravel().astype(kind)
        self._stride = [math.prod(count[:axis]) for axis in range(self.dimension)]
        self._first = np.array(first, np.float32)[:, None]
        self._cells: dict[tuple[int, ...], NDArray[Any]] = {}

    @classmethod
    def between(cls, first: list[float], last: list[float], lanes: int) -> Grid | None:
        """The grid of some cells' corners, or None where hashing lane by lane is less work."""
        count = [int(b - a) + 2 for a, b in zip(first, last, strict=True)]
        return cls(first, count) if math.prod(count) < DEAR * lanes else None

    def cells(self, active: tuple[int, ...]) -> NDArray[Any]:
        """(points, corners) hashes of the corners of the cell that begins at each point."""
        if active not in self._cells:
            corners = range(1 << len(active))
            table = np.zeros((len(self._hash), len(corners)), self._hash.dtype)
            for corner in corners:
                step = sum(self._stride[axis] for k, axis in enumerate(active) if corner >> k & 1)
                table[: len(table) - step, corner] = self._hash[step:]
            self._cells[active] = table
        return self._cells[active]

    def pairs(self, low: Float32, active: tuple[int, ...], index: Index) -> None:
        """Where in `PAIRS` the corners of the cells `low` are, as `Hashes.pairs` has it."""
        steps = low - self._first
        place = steps[0]
        for row, stride in zip(steps[1:], self._stride[1:], strict=True):
            row *= np.float32(stride)
            place += row  # exact: a grid has less than 2²⁴ points
        found = self.cells(active).take(place.astype(np.intp), axis=0, mode="clip")
        whole = found.view(f"u{min(found.shape[1] * found.itemsize, 8)}").reshape(len(found) // 2, 2, -1)
        bits = whole.dtype.type(SIZES[self.dimension].bit_length() - 1)
        pair = whole[:, 0] | whole[:, 1] << bits
        index.reshape(-1, index.shape[-1])[:] = pair.view(found.dtype).T
