"""The cells of Voronoi textures: the random points in them, and which of these is nearest.

Cells around a block of lanes are one array: an axis for each dimension, the first the innermost as in
Blender's loops, and the lanes last. What cells in a row have in common is so computed once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .hashes import cell, floats_to_color, floats_to_float
from .math_nodes import divide
from .voronoi_grids import CellGrid

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Point = Sequence[Float32]

FAR: Final = np.float32(3e38)


class Settings(NamedTuple):
    """What a Voronoi texture is told, each (n,) or (1,)."""

    feature: str
    metric: str
    exponent: Float32
    randomness: Float32
    smoothness: Float32

    def of(self, lanes: NDArray[np.intp] | slice) -> Settings:
        """Those of some lanes."""
        return Settings(*self[:2], *(a if a.shape[-1] == 1 else a[lanes] for a in self[2:]))


def distance(settings: Settings, difference: Point) -> Float32:
    """Length of a difference by the metric, in its memory."""
    if settings.metric == "EUCLIDEAN" and len(difference) > 1:
        squares, *others = (np.multiply(d, d, out=d) for d in difference)
        for other in others:
            squares += other
        return np.sqrt(squares, out=squares)
    size = [np.abs(d) for d in difference]
    if len(size) == 1:
        return size[0]
    if settings.metric == "MANHATTAN":
        return sum_of(size)
    if settings.metric == "CHEBYCHEV":
        out = size[0]
        for s in size[1:]:
            out = np.maximum(out, s)
        return out
    total: Float32 = sum_of([s**settings.exponent for s in size]) ** divide(
        np.ones(1, np.float32), settings.exponent
    )
    return total


def sum_of_squares(parts: Sequence[Float32]) -> Float32:
    total = parts[0] * parts[0]
    for p in parts[1:]:
        total += p * p
    return total


def sum_of(parts: Sequence[Float32]) -> Float32:
    total = parts[0]
    for p in parts[1:]:
        total = total + p
    return total


def _whole(f: Float32) -> Float32:
    """What fits an integer of 32 bits."""
    return f if (np.abs(f) < 2e9).all() else np.clip(np.nan_to_num(f), -2e9, 2e9)


class Cells:
    """The cells around some points, and where the points in them are known from if not hashed."""

    def __init__(self, settings: Settings, point: Point, grid: CellGrid | None = None) -> None:
        self.settings, self._grid = settings, grid
        self.low = [np.floor(p) for p in point]
        self.local = [p - f for p, f in zip(point, self.low, strict=True)]
        self.dimension = len(point)
        self.number: list[Int32] = [_whole(f).astype(np.int32) for f in self.low]

    def random(self, offset: Sequence[Int32]) -> list[Float32]:
        """The point of the cell `offset` away, in [0, 1] of that cell."""
        if self.dimension == 1:
            return [floats_to_float(self._cell_1d(offset[0]))]
        if self._grid is not None:
            return self._grid.random(self.number, offset)
        return cell(*(k + o for k, o in zip(self.number, offset, strict=True)))

    def _cell_1d(self, offset: Int32) -> Float32:
        """Number of the cell `offset` away, as the float that is hashed."""
        return self.low[0] + offset.astype(np.float32)

    def color(self, offset: Sequence[Int32]) -> Float32:
        """(3, n) colour of the cell `offset` away."""
        if self.dimension == 1:
            return floats_to_color(self._cell_1d(offset[0]))
        keys = [k + o for k, o in zip(self.number, offset, strict=True)]
        if self.dimension == 2:
            keys.append(np.zeros_like(keys[0]))
        return np.stack(cell(*keys)[:3])

    def points(self, center: Sequence[Int32] | None = None) -> list[Float32]:
        """(3ᵈ, n) per axis: the points of the cells around the lanes' own, or the cells `center` away."""
        offset: list[Int32] = list(neighbours(self.dimension))
        if center is not None:
            offset = [o + c for o, c in zip(offset, center, strict=True)]
        return self.points_at(offset)

    def points_at(self, offset: Sequence[Int32]) -> list[Float32]:
        """(K, n) per axis: the points of cells whose offsets have an array dimension for each axis."""
        points, randomness = self.random(offset), self.settings.randomness
        scattered = not (randomness == 1).all()
        for p, o in zip(points, offset, strict=True):
            if scattered:
                p *= randomness
            p += o.astype(np.float32)
        return [p.reshape(-1, p.shape[-1]) for p in points]

    def near(self) -> tuple[list[Int32], Float32]:
        """Per axis the (2, n) offsets of the own cell and the nearer one; how far all others' points are.

        A point lies within the randomness r of its cell's corner. So where the lane is t from its own along
        an axis, points of the cells before are at least 1 + t − r away, of those behind 1 − t.
        """
        r, far = self.settings.randomness, np.full(1, FAR)
        offset = []
        for axis, t in enumerate(self.local):
            behind = (t <= np.float32(0.5) * r).astype(np.int32)
            far = np.minimum(far, 1 + np.maximum(t - r, -t))
            shape = [2 if k == self.dimension - 1 - axis else 1 for k in range(self.dimension)]
            offset.append(np.stack([-behind, 1 - behind]).reshape(*shape, -1))
        return offset, far

    def around(self, reach: int) -> Iterator[tuple[list[Int32], list[Float32]]]:
        """Offsets and points of the cells within `reach`, in Blender's order (the first axis fastest)."""
        steps = range(-reach, reach + 1)
        for reverse in itertools.product(steps, repeat=self.dimension):
            offset = [np.full(1, o, np.int32) for o in reverse[::-1]]
            r = self.settings.randomness
            random = self.random(offset)
            yield offset, [o.astype(np.float32) + x * r for o, x in zip(offset, random, strict=True)]

    def octave(
        self, nearest: Nearest, points: list[Float32], offset: Sequence[Int32] | None = None
    ) -> tuple[Float32, ...]:
        """Distance, colour and position of the point chosen among all cells, or those at `offset`."""
        place = [p + f for p, f in zip(nearest.of(points), self.low, strict=True)]
        return nearest.distance, self.color(nearest.offset(offset or neighbours(self.dimension))), *place


@cache
def neighbours(dimension: int) -> tuple[Int32, ...]:
    """Per axis −1, 0, 1 along its own array dimension, with one more for the lanes."""
    steps = np.arange(-1, 2, dtype=np.int32)
    shapes = [[3 if k == dimension - 1 - axis else 1 for k in range(dimension)] for axis in range(dimension)]
    return tuple(steps.reshape(*shape, 1) for shape in shapes)


class Nearest:
    """Which of (K, n) distances is the smallest, per lane; the first of equals."""

    def __init__(self, distances: Float32) -> None:
        count = len(distances)
        self.distance: Float32 = smallest(distances)
        rank = (distances == self.distance).view(np.uint8)
        rank *= np.arange(count, 0, -1, dtype=np.uint8)[:, None]
        first = count - rank.max(axis=0).astype(np.intp)
        self.found: NDArray[np.bool_] = self.distance < FAR  # none where the point is not finite
        self.number = np.where(self.found, first, count // 2)
        self.index = self.number * distances.shape[1] + np.arange(distances.shape[1])

    def of(self, values: list[Float32]) -> list[Float32]:
        """The chosen ones of (K, n) arrays."""
        return [v.take(self.index, mode="wrap") * self.found for v in values]

    def offset(self, cells: Sequence[Int32]) -> list[Int32]:
        """The chosen cell's offset along each axis, of cells given as for `Cells.points_at`."""
        place, chosen = self.number, []
        for steps in cells:  # the first axis is the fastest
            count, lanes = math.prod(steps.shape[:-1]), steps.shape[-1]
            lane = 0 if lanes == 1 else np.arange(lanes)
            chosen.append(steps.ravel().take(place % count * lanes + lane, mode="clip"))
            place = place // count
        return chosen


def smallest(values: Float32) -> Float32:
    """(n,) the smallest of (K, n), at most FAR."""
    nearest = np.full(values.shape[1:], FAR)
    np.fmin.reduce(values, axis=0, initial=FAR, out=nearest)  # fmin: not a number is far
    return nearest


def two_smallest(values: Float32) -> tuple[Float32, Float32]:
    """(n,) the two smallest of (K, n), at most FAR: a tournament of which the two best are kept."""
    count = len(values)
    rows = np.full((1 << (count - 1).bit_length(), values.shape[1]), FAR)
    np.fmin(values, FAR, out=rows[:count])
    half = len(rows) // 2
    low, high = np.minimum(rows[:half], rows[half:]), np.maximum(rows[:half], rows[half:])
    while half > 1:
        half //= 2
        high = np.minimum(high[:half], high[half:])
        np.minimum(high, np.maximum(low[:half], low[half:]), out=high)
        low = np.minimum(low[:half], low[half:])
    return low[0], high[0]
