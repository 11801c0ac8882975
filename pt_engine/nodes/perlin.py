"""Perlin noise in 1 to 4 dimensions, bit for bit Blender's.

Perlin 2002, "Improving Noise", with Jenkins' hash for the lattice. Cost is what matters here: a fractal asks
for this dozens of times per lane. So all corners of a block of lanes are worked on at once in buffers that
stay in cache; every axis has an array dimension of its own for its two corners, the first axis the
outermost, so that what corners have in common is computed once by broadcasting. Gradients are looked up for
two lanes at a time.
"""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.memory import Memory, in_large_pages
from .grids import FEW, GRIDS, Grid
from .lattice import SIZES, Hashes, along

Float32 = NDArray[np.float32]
Point = Sequence[Float32] | Float32
Ends = tuple[float, float]
Axes = tuple[int, ...]

PERIOD: Final = 100000.0
COARSE: Final = np.float32(1000000)  # from here on points are taken half a step off
MANY_PERIODS: Final = 5000 * PERIOD  # float32 holds all multiples of the period up to here
HUGE: Final = 1e15  # below it a float64 holds every multiple of the period exactly
KEPT: Final = 4  # blocks' buffers
BLOCK: Final = 65536  # corners at a time: few calls, and some arrays of them still fit a core's cache
SPACE: Final = 48 * BLOCK  # bytes that are enough for the buffers of the largest block
LINE: Final = 16  # lanes in a line of cache: rows that begin with one are read faster
ZERO, ONE, SIX, TEN, FIFTEEN = (np.array(k, np.float32) for k in (0, 1, 6, 10, 15))
# to about [−1, 1], by dimension
FACTORS: Final = {d: np.array(k, np.float32) for d, k in enumerate((0.25, 0.6616, 0.9820, 0.8344), 1)}


def _gradients(dimension: int) -> Float32:
    """(dimension, K) gradient of each hash value's low bits."""
    size = SIZES[dimension]
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


def _pairs(gradients: Float32, step: int) -> NDArray[np.complex64]:
    """(dimension, K·step) gradients of two lanes, one + i·other, by one + step·other."""
    dimension, size = gradients.shape
    table = np.zeros((dimension, size, step), np.complex64)
    table[..., :size] = gradients[:, None, :] + 1j * gradients[:, :, None]
    return table.reshape(dimension, -1)


GRADIENTS: Final = {d: _gradients(d) for d in (1, 2, 3, 4)}
PAIRS: Final = {d: _pairs(table, table.shape[1]) for d, table in GRADIENTS.items()}
APART: Final = {d: _pairs(table, 256) for d, table in GRADIENTS.items()}  # a byte for each lane


class Cloud(NamedTuple):
    """Points whose noise is asked for at several scales.

    Attributes
    ----------
    rows : (dimension, n) float32
        Coordinates by axis.
    bounds : (dimension, 2) float32
        Between which they lie.
    """

    rows: Float32
    bounds: Float32

    @classmethod
    def of(cls, point: Point) -> Cloud:
        """The cloud of a point's lanes."""
        rows = point if isinstance(point, np.ndarray) else np.stack(np.broadcast_arrays(*point))
        if rows.size == 0:
            return cls(rows, np.zeros((len(rows), 2), np.float32))
        return cls(rows, np.stack((rows.min(axis=1), rows.max(axis=1)), axis=1))

    @property
    def size(self) -> int:
        """n."""
        return int(self.rows.shape[1])

    def ends(self, scale: Float32) -> list[Ends]:
        """By axis between which coordinates the points times a number lie; rounding keeps their order."""
        return [(min(pair), max(pair)) for pair in (self.bounds * scale).tolist()]


def signed_noise(point: Point) -> Float32:
    """Perlin noise in about [−1, 1]; it repeats every 100000 units, as in Blender."""
    return scaled_noise(Cloud.of(point), ONE)


def scaled_noise(cloud: Cloud, scale: Float32) -> Float32:
    """`signed_noise` of a cloud's points times a number (1,)."""
    dimension, size = cloud.rows.shape
    out = np.empty(size, np.float32)
    if size == 0:
        return out
    ends = cloud.ends(scale)
    shift, grid = _common_shift(ends), None
    if shift is not None:
        turned = any(turns for turns, _ in shift)
        if turned:
            ends = _shifted(np.array(ends, np.float32), shift).tolist()
        if size >= FEW:
            grid = GRIDS.around([math.floor(a) for a, _ in ends], [math.floor(b) + 1 for _, b in ends], size)
    count = -(-(size << dimension) // BLOCK)
    n = -(-size // count)
    m = -(-n // LINE) * LINE
    point, low = ROOM.rows(dimension, m)
    every = (*range(dimension),)
    still = tuple(itertools.compress(every, (a == b for a, b in ends)))
    for k in range(count):
        start = min(k * n, size - n)  # all blocks are of one size; the last overlaps the one before
        np.multiply(cloud.rows[:, start : start + n], scale, point[:, :n])
        point[:, n:] = point[:, :1]  # where it is in the grid, too
        if shift is None:
            point[:] = _periodic(point)
        elif turned:
            _shifted(point, shift)
        np.floor(point, low)
        off = point[:, 0] != low[:, 0]  # mostly one lane tells
        active = every if off.all() else (*np.flatnonzero((point != low).any(axis=1)).tolist(),)
        found = ROOM.block(dimension, active, still, m).blend(point, low, grid)
        np.multiply(found[:n], FACTORS[dimension], out[start : start + n])
    out += ZERO  # of two zeros always the positive one, whichever corners were left out
    return out


def _common_shift(ends: Sequence[Ends]) -> list[tuple[float, float]] | None:
    """By axis what `_periodic` subtracts from and then adds to all coordinates between two, or None."""
    shift = []
    for low, high in ends:
        if not (low > -MANY_PERIODS and high < MANY_PERIODS):
            return None
        turns = math.trunc(low / PERIOD)
        if turns != math.trunc(high / PERIOD):
            return None
        shift.append((turns * PERIOD, 0.5 if abs(turns) * PERIOD >= COARSE else 0.0))
    return shift


def _shifted(rows: Float32, shift: Sequence[tuple[float, float]]) -> Float32:
    """Coordinates moved in place; exact but for the last rounding."""
    for row, (turned, half) in zip(rows, shift, strict=True):
        if turned:
            row -= np.float32(turned)
            row += np.float32(half)
    return rows


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


class Room(threading.local):
    """Buffers for blocks of lanes, kept by each thread: fresh memory for each step would double its cost.

    Blocks are worked on one after the other, so all lie in the same place, and that fits a core's cache.
    """

    def __init__(self) -> None:
        self._memory = in_large_pages(SPACE)
        self._blocks: dict[tuple[int, Axes, Axes, int], Block] = {}

    def rows(self, dimension: int, n: int) -> Float32:
        """(2, dimension, n) for a block's points and the cells where they are."""
        rows: Float32 = Memory(self._memory).array((2, dimension, n), np.float32)
        return rows

    def block(self, dimension: int, active: Axes, still: Axes, n: int) -> Block:
        """The buffers for such a block beside its `rows`, among the last few that were asked for."""
        key = dimension, active, still, n
        block = self._blocks.pop(key, None)
        if block is None:
            memory = Memory(self._memory)
            memory.array((2, dimension, n), np.float32)
            block = Block(memory, *key)
        if len(self._blocks) >= KEPT:
            del self._blocks[next(iter(self._blocks))]
        self._blocks[key] = block
        return block


class Block:
    """Where the noise of a block of lanes is worked out.

    An axis on which all lanes lie on lattice points (z of a uv map) has no far corners and no slope. Each of
    the others has an array dimension for its two corners, the first axis the outermost. One on which all
    lanes are at one place (z of a uv map that was moved) has the same distances and weights for all.

    Parameters
    ----------
    memory : Memory
        Where its buffers are.
    dimension : int
        1 to 4.
    active : tuple of int
        Axes that are not on lattice points everywhere.
    still : tuple of int
        Axes on which all lanes are at one place.
    n : int
        Number of lanes, even.
    """

    def __init__(self, memory: Memory, dimension: int, active: Axes, still: Axes, n: int) -> None:
        self.dimension, self.active, self.n = dimension, active, n
        axes = len(active)
        if axes == 0:
            return
        # hashes, and once they are known what comes after
        work = memory.array((4, *(2,) * axes, n), np.uint32)
        self.hashes = Hashes(dimension, active, work, memory)
        self.pairs, self.index = work[:2].view(np.complex64), work[2].view(np.intp)
        self.slopes, self.term = work[:2].view(np.float32)
        own = [axis for axis in active if axis not in still]
        self.kinds = [
            Distances(memory, rows, size)
            for rows, size in ((own, n), ([axis for axis in active if axis in still], 1))
            if rows
        ]
        self.offsets, self.halves, numbers = [], [], self.slopes
        for k, axis in enumerate(active):
            sides, fade = next(kind.of(axis) for kind in self.kinds if axis in kind.axes)
            self.offsets.append(sides.reshape(*along(k, axes), -1))
            near, numbers = numbers
            self.halves.append((near, numbers, fade))

    def blend(self, point: Float32, low: Float32, grid: Grid | None) -> Float32:
        """Unscaled noise of points in the cells that begin at `low`: slopes, blended axis after axis."""
        if not self.active:
            return np.zeros(self.n, np.float32)
        table = (APART if grid is None else PAIRS)[self.dimension]
        if grid is None:
            self.hashes.pairs(low, self.index)
        else:
            grid.pairs(low, self.active, self.index)
        for kind in self.kinds:
            kind.measure(point, low)
        numbers, more = self.slopes, self.term
        for k, (axis, offset) in enumerate(zip(self.active, self.offsets, strict=True)):
            table[axis].take(self.index, out=self.pairs[min(k, 1)], mode="wrap")
            if k:
                more *= offset
                numbers += more
            else:
                numbers *= offset
        for near, numbers, fade in self.halves:
            numbers -= near
            numbers *= fade
            numbers += near
        blended: Float32 = numbers
        return blended


class Distances:
    """How far lanes are from the corners of their cells along some axes, and the weights of the far ones.

    Attributes
    ----------
    axes : list of int
    """

    def __init__(self, memory: Memory, axes: list[int], lanes: int) -> None:
        self.axes = axes
        self.rows = slice(axes[0], axes[-1] + 1) if axes[-1] - axes[0] < len(axes) else axes
        self.sides = memory.array((2, len(axes), lanes), np.float32)
        self.fade, self.cube = memory.array((2, len(axes), lanes), np.float32)

    def of(self, axis: int) -> tuple[Float32, Float32]:
        """Distances from the near and the far corners (2, n), and the weights (n,), on an axis."""
        k = self.axes.index(axis)
        return self.sides[:, k], self.fade[k]

    def measure(self, point: Float32, low: Float32) -> None:
        """Of points in the cells that begin at `low`; weights are 6t⁵ − 15t⁴ + 10t³."""
        (near, far), fade, cube = self.sides, self.fade, self.cube
        lanes = near.shape[1]
        np.subtract(point[self.rows, :lanes], low[self.rows, :lanes], near)
        np.multiply(near, SIX, fade)
        fade -= FIFTEEN
        fade *= near
        fade += TEN
        np.multiply(near, near, cube)
        cube *= near
        fade *= cube
        np.subtract(near, ONE, far)


ROOM: Final = Room()
