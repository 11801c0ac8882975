"""The Voronoi texture: distances to the random points of a grid's cells, value for value Blender's.

Each cell of the integer grid holds one point; features look at the 3ᵈ cells around (5ᵈ for the smooth
one). After Inigo Quilez' articles on Voronoi edges and smooth Voronoi.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .hashes import cell, floats_to_color, floats_to_float
from .math_nodes import divide, select, smooth_step

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


class Octave(NamedTuple):
    """What one octave gives: distance (n,), colour (3, n), position of the point by axis."""

    distance: Float32
    color: Float32
    position: list[Float32]


class Cell(NamedTuple):
    """A neighbour: its integer offset and its point relative to the lane's own cell."""

    offset: tuple[int, ...]
    point: list[Float32]
    random: list[Float32]


def distance(settings: Settings, difference: Point) -> Float32:
    """Length of a difference by the metric."""
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
    if settings.metric == "MINKOWSKI":
        total: Float32 = _sum([s**settings.exponent for s in size]) ** divide(
            np.ones(1, np.float32), settings.exponent
        )
        return total
    return np.sqrt(_sum([s * s for s in size]))


def _sum(parts: Sequence[Float32]) -> Float32:
    total = parts[0]
    for p in parts[1:]:
        total = total + p
    return total


class Cells:
    """The grid around some points."""

    def __init__(self, settings: Settings, point: Point) -> None:
        self.settings = settings
        self.low = [np.floor(p) for p in point]
        self.local = [p - f for p, f in zip(point, self.low, strict=True)]
        self.dimension = len(point)
        finite = [np.clip(np.nan_to_num(f), -2e9, 2e9) for f in self.low]
        self.number: list[Int32] = [f.astype(np.int32) for f in finite]

    def random(self, offset: Sequence[int] | Sequence[Int32]) -> list[Float32]:
        """The point of the cell `offset` away, in [0, 1] of that cell."""
        if self.dimension == 1:
            return [floats_to_float(self._cell_1d(offset[0]))]
        return cell(*(k + np.asarray(o, np.int32) for k, o in zip(self.number, offset, strict=True)))

    def _cell_1d(self, offset: int | Int32) -> Float32:
        """Number of the cell `offset` away, as the float that is hashed."""
        return self.low[0] + np.asarray(offset, np.float32)

    def color(self, offset: Sequence[Int32]) -> Float32:
        """(3, n) colour of the cell `offset` away."""
        if self.dimension == 1:
            return floats_to_color(self._cell_1d(offset[0]))
        keys = [k + o for k, o in zip(self.number, offset, strict=True)]
        if self.dimension == 2:
            keys.append(np.zeros_like(keys[0]))
        return np.stack(cell(*keys)[:3])

    def around(self, reach: int) -> Iterator[Cell]:
        """All cells within `reach`, in Blender's order (the first axis fastest)."""
        steps = range(-reach, reach + 1)
        for reverse in itertools.product(steps, repeat=self.dimension):
            offset = reverse[::-1]
            random = self.random(offset)
            r = self.settings.randomness
            yield Cell(offset, [o + x * r for o, x in zip(offset, random, strict=True)], random)

    def octave(self, dist: Float32, offset: list[Int32], point: list[Float32]) -> Octave:
        """An octave's output from the chosen cell."""
        return Octave(dist, self.color(offset), [p + f for p, f in zip(point, self.low, strict=True)])


class Nearest:
    """The nearest cell so far, per lane."""

    def __init__(self, like: Float32, dimension: int) -> None:
        self.distance = np.full(like.shape, FAR)
        self.offset: list[Int32] = [np.zeros(like.shape, np.int32)] * dimension
        self.point: list[Float32] = [np.zeros(like.shape, np.float32)] * dimension

    def put(
        self, where: NDArray[np.bool_], dist: Float32, offset: Sequence[int] | list[Int32], point: Point
    ) -> None:
        """Take this cell where `where`."""
        self.distance = select(where, dist, self.distance)
        self.offset = [
            np.where(where, o, old).astype(np.int32, copy=False)
            for o, old in zip(offset, self.offset, strict=True)
        ]
        self.point = [select(where, p, old) for p, old in zip(point, self.point, strict=True)]


def f1(settings: Settings, point: Point) -> Octave:
    """The nearest point."""
    cells = Cells(settings, point)
    best = Nearest(cells.local[0], cells.dimension)
    for c in cells.around(1):
        d = distance(settings, [p - q for p, q in zip(c.point, cells.local, strict=True)])
        best.put(d < best.distance, d, c.offset, c.point)
    return cells.octave(best.distance, best.offset, best.point)


def f2(settings: Settings, point: Point) -> Octave:
    """The second nearest point."""
    cells = Cells(settings, point)
    best = Nearest(cells.local[0], cells.dimension)
    second = Nearest(cells.local[0], cells.dimension)
    for c in cells.around(1):
        d = distance(settings, [p - q for p, q in zip(c.point, cells.local, strict=True)])
        first = d < best.distance
        second.put(first, best.distance, best.offset, best.point)
        second.put(~first & (d < second.distance), d, c.offset, c.point)
        best.put(first, d, c.offset, c.point)
    return cells.octave(second.distance, second.offset, second.point)


def smooth_f1(settings: Settings, point: Point) -> Octave:
    """The nearest points blended over `smoothness`."""
    cells, k = Cells(settings, point), settings.smoothness
    dist: Float32 | None = None
    color = np.zeros((3, cells.local[0].shape[-1]), np.float32)
    place: list[Float32] = [np.zeros(1, np.float32)] * cells.dimension
    for c in cells.around(2):
        d = distance(settings, [p - q for p, q in zip(c.point, cells.local, strict=True)])
        tint = cells.color([np.full(1, o, np.int32) for o in c.offset])
        if dist is None:
            dist, color, place = d, tint, list(c.point)
            continue
        h = smooth_step(np.clip(np.float32(0.5) + np.float32(0.5) * divide(dist - d, k), 0, 1))
        correction = k * h * (1 - h)
        dist = dist + h * (d - dist) - correction
        correction = correction / (1 + 3 * k)
        color = color + h * (tint - color) - correction
        place = [a + h * (b - a) - correction for a, b in zip(place, c.point, strict=True)]
    if dist is None:
        raise ValueError("a Voronoi texture has at least one dimension")
    return Octave(dist, color, [p + f for p, f in zip(place, cells.low, strict=True)])


def edge_distance(settings: Settings, point: Point) -> Float32:
    """Euclidean distance to the nearest border between cells."""
    cells = Cells(settings, point)
    if cells.dimension == 1:
        points = [c.point[0] for c in cells.around(1)]
        sides = [np.abs((points[1] + p) * np.float32(0.5) - cells.local[0]) for p in (points[0], points[2])]
        return np.minimum(*sides)
    best = Nearest(cells.local[0], cells.dimension)
    ways: list[list[Float32]] = []
    for c in cells.around(1):
        way = [p - q for p, q in zip(c.point, cells.local, strict=True)]
        ways.append(way)
        d = _sum([w * w for w in way])
        best.put(d < best.distance, d, c.offset, way)
    nearest = np.full(cells.local[0].shape, FAR)
    for way in ways:
        across = [w - b for w, b in zip(way, best.point, strict=True)]
        size = _sum([a * a for a in across])
        far = size > np.float32(0.0001)
        inverse = far / np.sqrt(size + ~far)
        middle = _sum(
            [(w + b) * np.float32(0.5) * a for w, b, a in zip(way, best.point, across, strict=True)]
        )
        nearest = np.minimum(nearest, select(far, middle * inverse, FAR))
    return nearest


def sphere_radius(settings: Settings, point: Point) -> Float32:
    """Half the distance from the nearest point to its own nearest neighbour."""
    cells = Cells(settings, point)
    best = Nearest(cells.local[0], cells.dimension)
    for c in cells.around(1):
        d = _sum([(p - q) ** 2 for p, q in zip(c.point, cells.local, strict=True)])
        best.put(d < best.distance, d, c.offset, c.point)
    nearest = np.full(cells.local[0].shape, FAR)
    for offset in itertools.product((-1, 0, 1), repeat=cells.dimension):
        if not any(offset):
            continue
        there = [o + b for o, b in zip(offset, best.offset, strict=True)]
        random = cells.random(there)
        place = [o + x * settings.randomness for o, x in zip(there, random, strict=True)]
        d = _sum([(p - b) ** 2 for p, b in zip(place, best.point, strict=True)])
        nearest = np.minimum(nearest, d.astype(np.float32, copy=False))
    return np.sqrt(nearest) * np.float32(0.5)
