"""The Voronoi texture: distances to the random points of a grid's cells, value for value Blender's.

Each cell of the integer grid holds one point; features look at the 3ᵈ cells around (5ᵈ for the smooth
one). After Inigo Quilez' articles on Voronoi edges and smooth Voronoi.

All 3ᵈ cells of a block of lanes are one array: an axis for each dimension, the first the innermost as in
Blender's loops, and the lanes last. What cells in a row have in common is so computed once, and blocks are
small enough to stay in cache.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .hashes import cell, floats_to_color, floats_to_float
from .math_nodes import divide, smooth_step

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Point = Sequence[Float32]

FAR: Final = np.float32(3e38)
BLOCK: Final = 65536  # cells at a time


class Settings(NamedTuple):
    """What a Voronoi texture is told, each (n,) or (1,)."""

    feature: str
    metric: str
    exponent: Float32
    randomness: Float32
    smoothness: Float32


class Octave(NamedTuple):
    """What one octave gives: distance (n,), colour (3, n), position of the point by axis."""

    distance: Float32
    color: Float32
    position: list[Float32]


def distance(settings: Settings, difference: Point) -> Float32:
    """Length of a difference by the metric."""
    if settings.metric == "EUCLIDEAN" and len(difference) > 1:
        squares = _sum_of_squares(difference)
        return np.sqrt(squares, out=squares)
    size = [np.abs(d) for d in difference]
    if len(size) == 1:
        return size[0]
    if settings.metric == "MANHATTAN":
        return _sum(size)
    if settings.metric == "CHEBYCHEV":
        out = size[0]
        for s in size[1:]:
            out = np.maximum(out, s)
        return out
    total: Float32 = _sum([s**settings.exponent for s in size]) ** divide(
        np.ones(1, np.float32), settings.exponent
    )
    return total


def _sum_of_squares(parts: Sequence[Float32]) -> Float32:
    total = parts[0] * parts[0]
    for p in parts[1:]:
        total += p * p
    return total


def _sum(parts: Sequence[Float32]) -> Float32:
    total = parts[0]
    for p in parts[1:]:
        total = total + p
    return total


def _whole(f: Float32) -> Float32:
    """What fits an integer of 32 bits."""
    return f if (np.abs(f) < 2e9).all() else np.clip(np.nan_to_num(f), -2e9, 2e9)


class Cells:
    """The grid around some points."""

    def __init__(self, settings: Settings, point: Point) -> None:
        self.settings = settings
        self.low = [np.floor(p) for p in point]
        self.local = [p - f for p, f in zip(point, self.low, strict=True)]
        self.dimension = len(point)
        self.number: list[Int32] = [_whole(f).astype(np.int32) for f in self.low]

    def random(self, offset: Sequence[Int32]) -> list[Float32]:
        """The point of the cell `offset` away, in [0, 1] of that cell."""
        if self.dimension == 1:
            return [floats_to_float(self._cell_1d(offset[0]))]
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
        points, randomness = self.random(offset), self.settings.randomness
        scattered = not (randomness == 1).all()
        for p, o in zip(points, offset, strict=True):
            if scattered:
                p *= randomness
            p += o.astype(np.float32)
        return [p.reshape(-1, p.shape[-1]) for p in points]

    def around(self, reach: int) -> Iterator[tuple[list[Int32], list[Float32]]]:
        """Offsets and points of the cells within `reach`, in Blender's order (the first axis fastest)."""
        steps = range(-reach, reach + 1)
        for reverse in itertools.product(steps, repeat=self.dimension):
            offset = [np.full(1, o, np.int32) for o in reverse[::-1]]
            r = self.settings.randomness
            random = self.random(offset)
            yield offset, [o.astype(np.float32) + x * r for o, x in zip(offset, random, strict=True)]

    def octave(self, nearest: Nearest, points: list[Float32]) -> tuple[Float32, ...]:
        """Distance, colour and position of the chosen cell's point."""
        place = [p + f for p, f in zip(nearest.of(points), self.low, strict=True)]
        return nearest.distance, self.color(nearest.offset(self.dimension)), *place


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
        self.distance: Float32 = _smallest(distances)
        rank = (distances == self.distance).view(np.uint8)
        rank *= np.arange(count, 0, -1, dtype=np.uint8)[:, None]
        first = count - rank.max(axis=0).astype(np.intp)
        self.found: NDArray[np.bool_] = self.distance < FAR  # none where the point is not finite
        self.number = np.where(self.found, first, count // 2)
        self.index = self.number * distances.shape[1] + np.arange(distances.shape[1])

    def of(self, values: list[Float32]) -> list[Float32]:
        """The chosen ones of (K, n) arrays."""
        return [v.take(self.index, mode="clip") * self.found for v in values]

    def offset(self, dimension: int) -> list[Int32]:
        """The chosen cell's offset along each axis."""
        steps = np.broadcast_arrays(*neighbours(dimension))
        return [np.ravel(step).take(self.number, mode="clip") for step in steps]


def _smallest(values: Float32) -> Float32:
    """(n,) the smallest of (K, n), at most FAR."""
    nearest = np.full(values.shape[1:], FAR)
    np.fmin.reduce(values, axis=0, initial=FAR, out=nearest)  # fmin: not a number is far
    return nearest


def _second_smallest(values: Float32) -> Float32:
    """(n,) the second smallest of (K, n), at most FAR: a tournament of which the two best are kept."""
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
    second: Float32 = high[0]
    return second


def in_blocks(
    kernel: Callable[[Settings, Point], tuple[Float32, ...]], settings: Settings, point: Point
) -> tuple[Float32, ...]:
    """What `kernel` gives, a block of lanes at a time."""
    inputs = [*point, settings.exponent, settings.randomness, settings.smoothness]
    size = max(a.shape[-1] for a in inputs)
    step = max(BLOCK // 3 ** len(point), 1)
    parts = []
    for start in range(0, size, step):
        span = slice(start, min(start + step, size))
        wide = [np.broadcast_to(p, size)[span] for p in point]
        some = [a if a.shape[-1] == 1 else a[span] for a in settings[2:]]
        parts.append(kernel(Settings(*settings[:2], *some), wide))
    if len(parts) == 1:
        return parts[0]
    return tuple(np.concatenate(part, axis=-1) for part in zip(*parts, strict=True))


def _octave(found: tuple[Float32, ...]) -> Octave:
    return Octave(found[0], found[1], list(found[2:]))


def _ways(cells: Cells, points: list[Float32]) -> list[Float32]:
    """From the lanes' points to those of the cells."""
    return [p - q for p, q in zip(points, cells.local, strict=True)]


def f1(settings: Settings, point: Point) -> Octave:
    """The nearest point."""
    return _octave(in_blocks(_f1, settings, point))


def _f1(settings: Settings, point: Point) -> tuple[Float32, ...]:
    cells = Cells(settings, point)
    points = cells.points()
    return cells.octave(Nearest(distance(settings, _ways(cells, points))), points)


def f2(settings: Settings, point: Point) -> Octave:
    """The second nearest point."""
    return _octave(in_blocks(_f2, settings, point))


def _f2(settings: Settings, point: Point) -> tuple[Float32, ...]:
    cells = Cells(settings, point)
    points = cells.points()
    distances = np.array(distance(settings, _ways(cells, points)))
    distances.reshape(-1)[Nearest(distances).index] = FAR
    return cells.octave(Nearest(distances), points)


def distances(settings: Settings, point: Point) -> Float32:
    """(n,) distance of `f1`, or of `f2`, without what else they give."""
    return in_blocks(_second_distance if settings.feature == "F2" else _distance, settings, point)[0]


def _distance(settings: Settings, point: Point) -> tuple[Float32, ...]:
    cells = Cells(settings, point)
    return (_smallest(distance(settings, _ways(cells, cells.points()))),)


def _second_distance(settings: Settings, point: Point) -> tuple[Float32, ...]:
    cells = Cells(settings, point)
    return (_second_smallest(distance(settings, _ways(cells, cells.points()))),)


def smooth_f1(settings: Settings, point: Point) -> Octave:
    """The nearest points blended over `smoothness`."""
    cells, k = Cells(settings, point), settings.smoothness
    dist: Float32 | None = None
    color = np.zeros((3, cells.local[0].shape[-1]), np.float32)
    place: list[Float32] = [np.zeros(1, np.float32)] * cells.dimension
    for offset, at in cells.around(2):
        d = distance(settings, _ways(cells, at))
        tint = cells.color(offset)
        if dist is None:
            dist, color, place = d, tint, at
            continue
        h = smooth_step(np.clip(np.float32(0.5) + np.float32(0.5) * divide(dist - d, k), 0, 1))
        correction = k * h * (1 - h)
        dist = dist + h * (d - dist) - correction
        correction = correction / (1 + 3 * k)
        color = color + h * (tint - color) - correction
        place = [a + h * (b - a) - correction for a, b in zip(place, at, strict=True)]
    if dist is None:
        raise ValueError("a Voronoi texture has at least one dimension")
    return Octave(dist, color, [p + f for p, f in zip(place, cells.low, strict=True)])


def edge_distance(settings: Settings, point: Point) -> Float32:
    """Euclidean distance to the nearest border between cells."""
    return in_blocks(_edge_distance, settings, point)[0]


def _edge_distance(settings: Settings, point: Point) -> tuple[Float32, ...]:
    cells = Cells(settings, point)
    if cells.dimension == 1:
        before, own, after = cells.points()[0]
        sides = [np.abs((own + p) * np.float32(0.5) - cells.local[0]) for p in (before, after)]
        return (np.minimum(*sides),)
    ways = _ways(cells, cells.points())
    best = Nearest(_sum_of_squares(ways)).of(ways)
    across = [w - b for w, b in zip(ways, best, strict=True)]
    size = _sum_of_squares(across)
    same = ~(size > np.float32(0.0001))  # the nearest cell itself has no border with itself
    middle = _sum([(w + b) * np.float32(0.5) * a for w, b, a in zip(ways, best, across, strict=True)])
    size += same
    middle *= ~same / np.sqrt(size)
    middle += same * FAR
    return (_smallest(middle),)


def sphere_radius(settings: Settings, point: Point) -> Float32:
    """Half the distance from the nearest point to its own nearest neighbour."""
    return in_blocks(_sphere_radius, settings, point)[0]


def _sphere_radius(settings: Settings, point: Point) -> tuple[Float32, ...]:
    cells = Cells(settings, point)
    points = cells.points()
    nearest = Nearest(_sum_of_squares(_ways(cells, points)))
    own = nearest.of(points)
    others = cells.points(nearest.offset(cells.dimension))
    distances = _sum_of_squares([p - q for p, q in zip(others, own, strict=True)])
    distances[len(distances) // 2] = FAR  # the point itself
    return (np.sqrt(_smallest(distances)) * np.float32(0.5),)
