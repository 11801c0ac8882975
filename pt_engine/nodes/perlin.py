"""Perlin noise in 1 to 4 dimensions, bit for bit Blender's.

Perlin 2002, "Improving Noise", with Jenkins' hash for the lattice. Cost is what matters here: a fractal asks
for this dozens of times per lane. So all corners of a block of lanes are worked on at once in buffers that
stay in cache; every axis has an array dimension of its own for its two corners, the first axis the
innermost, so that what corners have in common is computed once by broadcasting.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .hashes import SEED, hash_uints

Float32 = NDArray[np.float32]
UInt32 = NDArray[np.uint32]
Index = NDArray[np.intp]  # what `take` takes without a copy
Point = Sequence[Float32]

SCALE: Final = (0.25, 0.6616, 0.9820, 0.8344)  # to about [-1, 1], by dimension
PERIOD: Final = 100000.0
COARSE: Final = np.float32(1000000)  # from here on points are taken half a step off
HUGE: Final = 1e15  # below it a float64 holds every multiple of the period exactly
BLOCK: Final = 65536  # corners at a time: few calls, and some arrays of them still fit a core's cache
SHIFT: Final = [np.array(k, np.uint32) for k in range(32)]  # ufuncs take arrays faster than numbers


def _gradients(dimension: int) -> Float32:
    """(dimension, K) gradient of each hash value's low bits."""
    size = {1: 16, 2: 8, 3: 16, 4: 32}[dimension]
    table = np.zeros((dimension, size), np.float32)
    for h in range(size):
        if dimension == 1:
            table[0, h] = (1 + (h & 7)) * (-1 if h & 8 else 1)
            continue
        if dimension == 2:
            axes: tuple[int, ...] = (0, 1) if h < 4 else (1, 0)
            factors: tuple[float, ...] = (1, 2)
        elif dimension == 3:
            axes = (0 if h < 8 else 1, 1 if h < 4 else 0 if h in (12, 14) else 2)
            factors = (1, 1)
        else:
            axes = (0 if h < 24 else 1, 1 if h < 16 else 2, 2 if h < 8 else 3)
            factors = (1, 1, 1)
        for bit, (axis, factor) in enumerate(zip(axes, factors, strict=True)):
            table[axis, h] += -factor if h >> bit & 1 else factor
    return table


def _pairs(gradients: Float32) -> NDArray[np.complex64]:
    """(dimension, K²) gradients of two corners, near + i·far, by near + K·far."""
    near, far = gradients[:, None, :], gradients[:, :, None]
    table: NDArray[np.complex64] = (near + 1j * far).astype(np.complex64)
    return table.reshape(len(gradients), -1)


GRADIENTS: Final = {d: _gradients(d) for d in (1, 2, 3, 4)}
PAIRS: Final = {d: _pairs(table) for d, table in GRADIENTS.items()}


def signed_noise(point: Point, room: Room | None = None) -> Float32:
    """Perlin noise in about [−1, 1]; it repeats every 100000 units, as in Blender.

    Calls that share a `room` need no buffers of their own.
    """
    room = room or Room()
    dimension, size = len(point), max(p.shape[-1] for p in point)
    out = np.empty(size, np.float32)
    if size == 0:
        return out
    first = [float(np.floor(np.min(p))) for p in point]
    last = [float(np.floor(np.max(p))) for p in point]
    far = not all(a > -PERIOD and b < PERIOD for a, b in zip(first, last, strict=True))
    grid = None if far else Grid.between(first, last, size)
    count = -(-(size << dimension) // BLOCK)
    n = -(-size // count)
    part, low = np.empty((dimension, n), np.float32), np.empty((dimension, n), np.float32)
    every = (*range(dimension),)
    for k in range(count):
        start = min(k * n, size - n)  # all blocks are of one size; the last overlaps the one before
        for row, p in zip(part, point, strict=True):
            row[:] = p[start : start + n] if p.shape[-1] > 1 else p
        if far:
            part[:] = _periodic(part)
        np.floor(part, out=low)
        part -= low
        active = every if part[:, 0].all() else (*np.flatnonzero(part.any(axis=1)).tolist(),)
        room.block(dimension, active, n).blend(part, low, grid, out[start : start + n])
    out *= np.float32(SCALE[dimension - 1])
    out += np.float32(0)  # of two zeros always the positive one, whichever corners were left out
    return out


def _periodic(p: Float32) -> Float32:
    """Into (−100000, 100000), exactly; half a step off where the number is too coarse for the lattice."""
    size = np.abs(p)
    longest = size.max()
    if longest < HUGE:
        wide = p.astype(np.float64)
        wide -= np.trunc(wide / PERIOD) * PERIOD
        inside = wide.astype(np.float32)
    else:
        inside = np.nan_to_num(np.fmod(p, np.float32(PERIOD)), nan=0.0, posinf=0.0, neginf=0.0)
    if not longest < COARSE:
        inside += np.float32(0.5) * (size >= COARSE)
    return inside


class Room:
    """Buffers for blocks of lanes, kept: fresh memory for each step would double its cost."""

    def __init__(self) -> None:
        self._blocks: dict[tuple[int, tuple[int, ...], int], Block] = {}

    def block(self, dimension: int, active: tuple[int, ...], n: int) -> Block:
        """The buffers for such a block."""
        key = dimension, active, n
        if key not in self._blocks:
            self._blocks[key] = Block(*key)
        return self._blocks[key]


class Block:
    """Where the noise of a block of lanes is worked out.

    An axis on which all lanes lie on lattice points (z of a uv map) has no far corners and no slope. Each of
    the others has an array dimension for its two corners, the first axis the innermost. But two corners
    along the last of them are looked up together, and lie side by side until they are blended.

    Parameters
    ----------
    dimension : int
        1 to 4.
    active : tuple of int
        Axes that are not on lattice points everywhere.
    n : int
        Number of lanes.
    """

    def __init__(self, dimension: int, active: tuple[int, ...], n: int) -> None:
        self.dimension, self.active = dimension, active
        axes = len(active)
        if axes == 0:
            return
        self.hashes = Hashes(dimension, active, n)
        self.index: Index = np.empty(((2,) * (axes - 1) + (n,)), np.intp)
        values, term = np.empty(self.index.shape, np.complex64), np.empty(self.index.shape, np.complex64)
        self.pairs, self.slopes = [values] + [term] * (axes - 1), values.view(np.float32)
        self.term = term.view(np.float32)
        # distances from the near and the far corner, and fades, twice: for both of a pair
        self.sides = np.empty((3, axes - 1, n, 2), np.float32)
        flat = self.sides.reshape(3, axes - 1, 2 * n)
        self.ends = np.empty((n, 2), np.float32)
        self.offsets = [flat[:2, k].reshape(*_along(k, axes - 1), 2 * n) for k in range(axes - 1)]
        self.offsets.append(self.ends.reshape(2 * n))
        self.fades = flat[2]
        self.fade, self.cube = np.empty((axes, n), np.float32), np.empty((axes, n), np.float32)

    def blend(self, part: Float32, low: Float32, grid: Grid | None, out: Float32) -> None:
        """Unscaled noise `part` of a step beyond lattice points `low`: slopes, blended axis after axis."""
        if not self.active:
            out[:] = 0
            return
        if grid is None:
            self.hashes.pairs(low, self.index)
        else:
            grid.pairs(low, self.active, self.index)
        if len(self.active) < self.dimension:
            part = part[list(self.active)]
        self._place(part)
        numbers, more = self.slopes, self.term
        for k, (axis, pairs, offset) in enumerate(zip(self.active, self.pairs, self.offsets, strict=True)):
            PAIRS[self.dimension][axis].take(self.index, out=pairs, mode="clip")
            if k:
                more *= offset
                numbers += more
            else:
                numbers *= offset
        for fade in self.fades:
            near, numbers = numbers[..., 0, :], numbers[..., 1, :]
            numbers -= near
            numbers *= fade
            numbers += near
        near, far = numbers[0::2], numbers[1::2]
        np.subtract(far, near, out=out)
        out *= self.fade[-1]
        out += near

    def _place(self, part: Float32) -> None:
        """Distances from the corners, and the weights of the far ones: 6t⁵ − 15t⁴ + 10t³."""
        fade, cube, sides = self.fade, self.cube, self.sides
        np.multiply(part, np.float32(6), out=fade)
        fade -= np.float32(15)
        fade *= part
        fade += np.float32(10)
        np.multiply(part, part, out=cube)
        cube *= part
        fade *= cube
        sides[0, ..., 0] = sides[0, ..., 1] = part[:-1]
        np.subtract(sides[0], np.float32(1), out=sides[1])
        sides[2, ..., 0] = sides[2, ..., 1] = fade[:-1]
        self.ends[:, 0] = part[-1]
        np.subtract(part[-1], np.float32(1), out=self.ends[:, 1])


def _along(axis: int, axes: int) -> list[int]:
    """Shape of one axis' two corners; the first axis is the innermost."""
    return [2 if k == axes - 1 - axis else 1 for k in range(axes)]


# ------------------------------------------------------------------ the lattice's random numbers


class Hashes:
    """`hashes.hash_uints` of the corners of a block's cells, cut down to the bits that choose a gradient.

    These are the last 5 of the last sum, to which bits 8 to 12 of the step before are added, and so the last
    13 of that.
    """

    def __init__(self, dimension: int, active: tuple[int, ...], n: int) -> None:
        self.dimension, axes = dimension, len(active)
        self.start = np.array((SEED + 4 * dimension) & 0xFFFFFFFF, np.uint32)
        self.corners = np.empty((dimension, 2, n), np.uint32)
        self.keys = [corner[0].reshape((1,) * axes + (n,)) for corner in self.corners]
        for k, axis in enumerate(active):
            self.keys[axis] = self.corners[axis].reshape(*_along(k, axes), n)
        keys = [*self.keys, self.start, self.start][:3]
        self.first = np.empty(np.broadcast_shapes(keys[1].shape, keys[2].shape), np.uint32)
        self.a, self.b, self.c = (np.empty((2,) * axes + (n,), np.uint32) for _ in range(3))
        self.spare = np.empty(self.a.size, np.uint32)

    def pairs(self, low: Float32, index: Index) -> None:
        """Where in `PAIRS` the pairs of corners are: of the last axis, which has no dimension any more."""
        size = np.uint32(GRADIENTS[self.dimension].shape[1])
        near, far = self.of_corners(low.astype(np.int32).view(np.uint32))
        near &= size - 1
        far &= size - 1
        far *= size
        near += far
        index[:] = near

    def of_corners(self, cell: UInt32) -> UInt32:
        """Right in the lowest 5 bits."""
        if self.dimension == 4:
            self.corners[:, 0] = cell
            np.add(cell, np.uint32(1), out=self.corners[:, 1])
            return hash_uints(*self.keys)
        near = np.add(cell, self.start, out=self.corners[:, 0])
        np.add(near, np.uint32(1), out=self.corners[:, 1])
        x, y, z = [*self.keys, self.start, self.start][:3]
        first, a, b, c = self.first, self.a, self.b, self.c
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
        out -= spare
        np.right_shift(y, SHIFT[32 - k], out=spare)
        out -= spare


class Grid:
    """The hashes of all lattice points around some lanes, where those are fewer than the lanes."""

    def __init__(self, first: list[float], count: list[int]) -> None:
        dimension = len(count)
        keys = []
        for axis, (low, n) in enumerate(zip(first, count, strict=True)):
            shape = [n if k == dimension - 1 - axis else 1 for k in range(dimension)]
            keys.append((np.int32(low) + np.arange(n, dtype=np.int32)).view(np.uint32).reshape(shape))
        self._size = GRADIENTS[dimension].shape[1]
        self._hash = (hash_uints(*keys) & np.uint32(self._size - 1)).ravel().astype(np.intp)
        self._stride = np.cumprod([1, *count[:-1]], dtype=np.intp)
        self._first = np.array(first, np.float32)[:, None]

    @classmethod
    def between(cls, first: list[float], last: list[float], lanes: int) -> Grid | None:
        """The grid of some cells' corners, or None where hashing lane by lane is less work."""
        count = [int(b - a) + 2 for a, b in zip(first, last, strict=True)]
        return cls(first, count) if math.prod(count) < 1.5 * lanes else None

    def pairs(self, low: Float32, active: Sequence[int], index: Index) -> None:
        """Where in `PAIRS` the pairs of corners of the cells `low` are, as `Hashes.pairs` has it."""
        step = self._stride[active[-1]]
        pairs = self._hash[:-step] + self._size * self._hash[step:]
        place = ((low - self._first).astype(np.intp) * self._stride[:, None]).sum(axis=0)
        corners = np.zeros((1,) * (len(active) - 1), np.intp)
        for k, axis in enumerate(active[:-1]):
            corners = corners + np.array([0, self._stride[axis]]).reshape(_along(k, len(active) - 1))
        pairs.take(place + corners[..., None], out=index, mode="clip")
