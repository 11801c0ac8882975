"""Perlin noise in 1 to 4 dimensions, bit for bit Blender's.

Perlin 2002, "Improving Noise", with Jenkins' hash for the lattice. Cost is what matters here: a fractal asks
for this dozens of times per lane. So all corners of a block of lanes are worked on at once in buffers that
stay in cache; every axis has an array dimension of its own for its two corners, the first axis the
innermost, so that what corners have in common is computed once by broadcasting.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .hashes import SEED, hash_uints

Float32 = NDArray[np.float32]
UInt32 = NDArray[np.uint32]
Index = NDArray[np.intp]  # what `take` takes without a copy
Point = Sequence[Float32]

SCALE: Final = (0.25, 0.6616, 0.9820, 0.8344)  # to about [-1, 1], by dimension
PERIOD: Final = np.float32(100000)
BLOCK: Final = 65536  # corners at a time: few calls, and some arrays of them still fit a core's cache


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


GRADIENTS: Final = {d: _gradients(d) for d in (1, 2, 3, 4)}


class Work:
    """Buffers by name and shape, made once per call: fresh memory for each step would double its cost."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, tuple[int, ...], Any], NDArray[Any]] = {}

    def array(self, name: str, shape: tuple[int, ...], kind: Any) -> Any:
        """The buffer of that name; its content is what was last put there."""
        key = name, shape, kind
        if key not in self._kept:
            self._kept[key] = np.empty(shape, kind)
        return self._kept[key]


def signed_noise(point: Point) -> Float32:
    """Perlin noise in about [−1, 1]; it repeats every 100000 units, as in Blender."""
    dimension, size = len(point), max(p.shape[-1] for p in point)
    axes = np.empty((dimension, size), np.float32)
    for row, p in zip(axes, point, strict=True):
        row[:] = p
    axes = _periodic(axes)
    low = np.floor(axes)
    grid = Grid.around(low)
    out, work = np.empty(size, np.float32), Work()
    block = BLOCK >> dimension
    for start in range(0, size, block):
        part = slice(start, start + block)
        out[part] = _blended(axes[:, part], low[:, part], grid, work)
    out *= np.float32(SCALE[dimension - 1])
    out += np.float32(0)  # of two zeros always the positive one, whichever corners were left out
    return out


def _periodic(p: Float32) -> Float32:
    """Into (−100000, 100000); half a step off where the number is too coarse for the lattice."""
    size = np.abs(p)
    if not (size < PERIOD).all():
        p = np.fmod(p, PERIOD) + np.float32(0.5) * (size >= np.float32(1000000))
        p = np.nan_to_num(p, nan=0.0, posinf=0.0, neginf=0.0)
    return p


def _corners(
    low: NDArray[Any], high: NDArray[Any], counts: list[int], work: Work, name: str, kind: Any
) -> list[Any]:
    """Per axis its `counts` corners, each along an array dimension of its own."""
    dimension, n = low.shape
    both = work.array(name, (dimension, 2, n), kind)
    both[:, 0], both[:, 1] = low, high
    return [both[axis, :count].reshape(*_shape(axis, counts), n) for axis, count in enumerate(counts)]


def _shape(axis: int, counts: list[int]) -> list[int]:
    """Of one axis' corners."""
    dimension = len(counts)
    return [counts[axis] if k == dimension - 1 - axis else 1 for k in range(dimension)]


def _blended(point: Float32, low: Float32, grid: Grid | None, work: Work) -> Float32:
    """Unscaled noise of one block: the corners' slopes, blended along one axis after another.

    Along an axis on which all lanes lie on lattice points (z of a uv map) the blend is the nearer corner.
    """
    part = point - low
    counts = [2 if off else 1 for off in part.any(axis=1)]
    offsets = _corners(part, part - np.float32(1), counts, work, "offsets", np.float32)
    if grid is None:
        cell = low.astype(np.int32).view(np.uint32)
        index = _hashed(_corners(cell, cell + np.uint32(1), counts, work, "keys", np.uint32), work)
        slopes = GRADIENTS[len(point)]
    else:
        index, slopes = grid.index(low, counts, work), grid.slopes
    values = work.array("values", index.shape, np.float32)
    term = work.array("term", index.shape, np.float32)
    for axis, offset in enumerate(offsets):
        into = term if axis else values
        slopes[axis].take(index, out=into, mode="clip")
        into *= offset
        if axis:
            values += term
    faded = _fade(part)
    for axis, count in enumerate(counts):
        near, far = values[..., 0, :], values[..., -1, :]
        if count == 1:
            values = near
            continue
        values = np.subtract(far, near, out=term[..., 0, :] if axis == 0 else None)
        values *= faded[axis]
        values += near
    blended: Float32 = values
    return blended


def _fade(t: Float32) -> Float32:
    """6t⁵ − 15t⁴ + 10t³."""
    inner = t * 6
    inner -= 15
    inner *= t
    inner += 10
    cube = t * t
    cube *= t
    cube *= inner
    return cube


# ------------------------------------------------------------------ the lattice's random numbers


def _step(x: UInt32, y: UInt32, k: int, work: Work, name: str) -> UInt32:
    """(x ^ y) − (y rotated left by k)."""
    out: UInt32 = work.array(name, np.broadcast_shapes(x.shape, y.shape), np.uint32)
    spare = work.array("spare", y.shape, np.uint32)
    np.bitwise_xor(x, y, out=out)
    out -= np.left_shift(y, np.uint32(k), out=spare)
    out -= np.right_shift(y, np.uint32(32 - k), out=spare)
    return out


def _hashed(keys: list[UInt32], work: Work) -> Index:
    """Low bits of `hashes.hash_uints` of the corners.

    Its last two steps are cut down to what reaches those bits: the last 4 of the sum, to which bits 8 to 11
    of the step before are added, and so the last 12 of that.
    """
    mask = np.uint32(GRADIENTS[len(keys)].shape[1] - 1)
    if len(keys) == 4:
        h = hash_uints(*keys)
    else:
        start = np.uint32((SEED + 4 * len(keys)) & 0xFFFFFFFF)
        for key in keys:
            key += start
        a, b, c = (keys + [np.full((1,) * keys[0].ndim, start, np.uint32)] * 2)[:3]
        c = _step(c, b, 14, work, "c")
        a = _step(a, c, 11, work, "a")
        b = _step(b, a, 25, work, "b")
        c = _step(c, b, 16, work, "c")
        a = _step(a, c, 4, work, "a")
        spare = work.array("spare", a.shape, np.uint32)
        b ^= a
        b -= np.right_shift(a, np.uint32(18), out=spare)
        c ^= b
        c -= np.right_shift(b, np.uint32(8), out=spare)
        h = c
    index: Index = work.array("index", h.shape, np.intp)
    np.bitwise_and(h, mask, out=index)
    return index


class Grid:
    """The gradients of all lattice points around some lanes, where those are fewer than the lanes.

    Attributes
    ----------
    slopes : (dimension, K) float32
    """

    def __init__(self, first: Float32, count: list[int]) -> None:
        dimension = len(count)
        keys = []
        for axis, (low, n) in enumerate(zip(first, count, strict=True)):
            shape = [1] * dimension
            shape[dimension - 1 - axis] = n
            cells = np.int32(low) + np.arange(n, dtype=np.int32)
            keys.append(cells.view(np.uint32).reshape(shape))
        table = GRADIENTS[dimension]
        h = (hash_uints(*keys) & np.uint32(table.shape[1] - 1)).ravel().view(np.int32)
        self.slopes = np.ascontiguousarray(table.take(h, axis=1))
        self._first = first[:, None]
        self._stride = np.cumprod([1, *count[:-1]], dtype=np.intp)

    @classmethod
    def around(cls, low: Float32) -> Grid | None:
        """The grid of cells `low` (dimension, n), or None where hashing lane by lane is less work."""
        if low.shape[1] == 0:
            return None
        first, last = low.min(axis=1), low.max(axis=1)
        count = [int(n) for n in last - first + 2]
        return cls(first, count) if np.prod(count, dtype=np.float64) < 1.5 * low.shape[1] else None

    def index(self, low: Float32, counts: list[int], work: Work) -> Index:
        """Number of each corner's lattice point."""
        steps = (low - self._first).astype(np.intp) * self._stride[:, None]
        index: Index = work.array("index", (*counts[::-1], low.shape[1]), np.intp)
        corners = np.zeros((1,) * len(counts), np.intp)
        for axis, (stride, count) in enumerate(zip(self._stride, counts, strict=True)):
            corners = corners + (stride * np.arange(count, dtype=np.intp)).reshape(_shape(axis, counts))
        np.add(steps.sum(axis=0), corners[..., None], out=index)
        return index
