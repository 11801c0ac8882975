"""Where light is asked for: the cells of a grid that surfaces pass through, apart for each side they face.

A place is a cell and one of six sides, the axis and sign that a normal is nearest to. Places without a
surface have no number of their own; who asks there anyway gets place 0, everywhere. Where emitters fill but a
small part of the scene, a finer grid lies over that part. Of instances that share their triangles only the
boxes are known: a surface of any direction may be in all cells that these touch.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .base import Float32, Float64, Index

Int32 = NDArray[np.int32]
Bounds = tuple[Float64, Float64]
NO_BOXES: Bounds = (np.zeros((0, 3)), np.zeros((0, 3)))
FINEST, COARSEST = 48, 4  # cells along the longest side
CHUNK = 1 << 20  # pairs of triangle and cell at once
NEAR = 1e-3  # of the scene's size is always near an emitter
SMALL = 0.5  # of the scene's size: a smaller part that has all emitters gets a grid of its own
OBLIQUE = float(np.arccos(3**-0.5))  # how far a normal leans at most from the axis that it is nearest to
MARGIN = 1e-3  # of a cell, and of a cosine: rounding moves no point to a place that does not exist


class Receivers(NamedTuple):
    """What lies in K places: boxes around it (K, 3), mean normals (K, 3) and how far others lean, radians."""

    low: Float64
    high: Float64
    normal: Float64
    lean: Float64


class Places:
    """Numbers of places.

    Parameters
    ----------
    vertices : (V, 3) float32
    triangles : (T, 3) int32
    limit : int
        So many places at most in a grid; it is as fine as that allows.
    sided : bool
        Whether it matters which side a surface faces; it does not where light passes through.
    emitters : (low, high), each (3,) float64
        Their box.
    boxes : (low, high), each (B, 3) float64
        Those of instances whose triangles are not among the others.
    """

    def __init__(
        self,
        vertices: Float32,
        triangles: Int32,
        limit: int,
        sided: bool,
        emitters: Bounds,
        boxes: Bounds = NO_BOXES,
    ) -> None:
        used = np.zeros(len(vertices), np.bool_)
        used[triangles] = True
        corners = np.concatenate([vertices[used].astype(np.float64), *boxes])
        low, high = corners.min(axis=0), corners.max(axis=0)
        self.sided = sided
        self._grid = Grid(vertices, triangles, limit, sided, (low, high), boxes)
        self.receivers, self.width, self._fine = self._grid.receivers, self._grid.width, None
        near = overlap((low, high), emitters)
        if float(np.max(near[1] - near[0])) < SMALL * float(np.max(high - low)):
            self._fine = Grid(vertices, triangles, limit, sided, near, boxes)
            both = zip(self._grid.receivers, self._fine.receivers, strict=True)
            self.receivers, self.width = Receivers(*(np.concatenate(b) for b in both)), self._fine.width

    @property
    def count(self) -> int:
        """Numbers given, 0 included."""
        return len(self.receivers.lean) + 1

    def number(self, p: Float32, n: Float32) -> Int32:
        """(N,) of points p (3, N) on surfaces whose normals are n (3, N)."""
        number = self._grid.number(p, n)
        if self._fine is None:
            return number
        fine = self._fine.number(p, n)
        found = fine > 0
        number *= ~found
        number += fine
        number += np.int32(len(self._grid.receivers.lean)) * found
        return number


class Grid:
    """Numbers of places within `bounds`; for the rest see `Places`."""

    def __init__(
        self, vertices: Float32, triangles: Int32, limit: int, sided: bool, bounds: Bounds, boxes: Bounds
    ) -> None:
        low, high = bounds
        longest = max(float(np.max(high - low)), 1e-6)
        self.sided = sided
        cells = float(FINEST)
        while True:
            self.width = longest / cells
            self.shape = np.minimum(((high - low) / self.width).astype(np.int64) + 2, FINEST + 2)
            self._low = low - 0.5 * (self.shape * self.width - (high - low))
            keys, receivers = self._occupied(vertices, triangles, boxes)
            if len(keys) * (2 if sided else 1) <= limit or cells <= COARSEST:
                break
            cells /= 1.3
        self._number(keys, receivers)
        self._low32 = self._low.astype(np.float32)
        self._per_width = np.float32(1.0 / self.width)

    def _number(self, keys: NDArray[np.int64], found: Receivers) -> None:
        """Give places their numbers, opposite sides next to each other; 0 is left for everywhere."""
        self._number_of = np.zeros(int(self.shape.prod()) * (6 if self.sided else 1), np.int32)
        numbers = np.arange(len(keys), dtype=np.int32)
        if not self.sided:
            self._number_of[keys] = numbers + 1
            self.receivers = found
            return
        self._number_of[2 * keys], self._number_of[2 * keys + 1] = 2 * numbers + 1, 2 * numbers + 2
        twice = Receivers(*(np.repeat(column, 2, axis=0) for column in found))
        twice.normal[1::2] *= -1.0
        self.receivers = twice

    def number(self, p: Float32, n: Float32) -> Int32:
        """(N,) of points p (3, N) on surfaces whose normals are n (3, N)."""
        key = np.zeros(p.shape[1], np.int32)
        inside = np.ones(p.shape[1], np.bool_)
        for axis in range(3):
            along = p[axis] - self._low32[axis]
            along *= self._per_width
            size = int(self.shape[axis])
            inside &= (along >= 0.0) & (along < size)
            key *= size
            key += np.clip(along, 0.0, size - 0.5).astype(np.int32)
        if self.sided:
            x, y, z = np.abs(n)
            flat: Float32 = np.maximum(x, y)
            up = z > flat
            side = np.logical_and(y > x, ~up).astype(np.int32)
            side += 2 * up.astype(np.int32)
            below = (n[0] < 0.0) & (side == 0) | (n[1] < 0.0) & (side == 1) | (n[2] < 0.0) & up
            key *= 6
            key += 2 * side
            key += below
        number: Int32 = self._number_of.take(key, mode="clip")
        number *= inside
        return number

    def _occupied(
        self, vertices: Float32, triangles: Int32, boxes: Bounds
    ) -> tuple[NDArray[np.int64], Receivers]:
        """Keys of the occupied cells and axes, and what lies there, on either side."""
        slots = int(self.shape.prod()) * (3 if self.sided else 1)
        low, high = np.full((slots, 3), np.inf), np.full((slots, 3), -np.inf)
        normals, count = np.zeros((slots, 3)), np.zeros(slots)
        step = CHUNK // 16
        for first in range(0, len(triangles), step):
            corners = vertices[triangles[first : first + step]].astype(np.float64)
            self._gather(corners, low, high, normals, count)
        boxed = self._gather_boxes(boxes, low, high, normals, count)
        keys = np.flatnonzero(count)
        mean = normals[keys] / count[keys, None]
        length = np.sqrt((mean**2).sum(axis=1))
        lean = np.minimum(1.5 * np.arccos(np.clip(length, -1.0, 1.0)), 0.5 * np.pi)
        lean[boxed[keys]] = OBLIQUE if self.sided else 0.5 * np.pi
        return keys, Receivers(low[keys], high[keys], mean / np.maximum(length, 1e-12)[:, None], lean)

    def _gather(
        self, corners: Float64, low: Float64, high: Float64, normals: Float64, count: Float64
    ) -> None:
        """Add triangles (T, 3, 3) to the boxes, normals and counts of the cells that they may touch."""
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal /= np.maximum(np.sqrt((normal**2).sum(axis=1, keepdims=True)), 1e-300)
        corners = (corners - self._low) / self.width
        lowest, highest = corners.min(axis=1), corners.max(axis=1)
        for owner, cell in self._cells(lowest, highest):
            n = normal[owner]
            plane = ((cell + 0.5 - corners[owner, 0]) * n).sum(axis=1)
            touches = np.flatnonzero(np.abs(plane) <= (0.5 + MARGIN) * np.abs(n).sum(axis=1))
            owner, cell, n = owner[touches], cell[touches], n[touches]
            box = np.maximum(lowest[owner], cell), np.minimum(highest[owner], cell + 1)
            self._add(cell, n, box, (low, high, normals, count))

    def _cells(self, lowest: Float64, highest: Float64) -> Iterator[tuple[Index, NDArray[np.int64]]]:
        """Boxes (N, 3) in units of cells, and the cells that they touch, pair by pair, some at a time."""
        first = np.clip(np.floor(lowest - MARGIN), 0, self.shape - 1).astype(np.int64)
        counts = np.clip(np.floor(highest + MARGIN), 0, self.shape - 1).astype(np.int64) - first + 1
        beyond = (highest < 0.0).any(axis=1) | (lowest > self.shape).any(axis=1)
        cells = counts.prod(axis=1) * ~beyond
        ends = np.cumsum(cells)
        begin = 0
        while begin < len(cells):
            before = int(ends[begin - 1]) if begin else 0
            end = max(int(np.searchsorted(ends, before + CHUNK)), begin + 1)
            owner = np.repeat(np.arange(begin, end), cells[begin:end])
            k = np.arange(len(owner)) - np.repeat(
                ends[begin:end] - cells[begin:end] - before, cells[begin:end]
            )
            begin = end
            size = counts[owner]
            offset = np.stack(
                [k // (size[:, 1] * size[:, 2]), k // size[:, 2] % size[:, 1], k % size[:, 2]], 1
            )
            yield owner, first[owner] + offset

    def _gather_boxes(
        self, boxes: Bounds, low: Float64, high: Float64, normals: Float64, count: Float64
    ) -> NDArray[np.bool_]:
        """Add boxes to the cells that they touch, for all sides; which cells and axes these are."""
        axes = 3 if self.sided else 1
        boxed = np.zeros(len(count), np.bool_)
        lowest, highest = ((corner - self._low) / self.width for corner in boxes)
        for owner, cell in self._cells(lowest, highest):
            first = axes * self._key(cell)
            one = self._low + self.width * np.maximum(lowest[owner], cell)
            other = self._low + self.width * np.minimum(highest[owner], cell + 1)
            for axis in range(axes):
                at = first + axis
                boxed[at], count[at], normals[at] = True, 1.0, np.eye(3)[axis]
                np.minimum.at(low, at, one)
                np.maximum.at(high, at, other)
        return boxed

    def _key(self, cell: NDArray[np.int64]) -> NDArray[np.int64]:
        """(N,) of cells (N, 3)."""
        key: NDArray[np.int64] = (cell[:, 0] * self.shape[1] + cell[:, 1]) * self.shape[2] + cell[:, 2]
        return key

    def _add(
        self,
        cell: NDArray[np.int64],
        n: Float64,
        box: tuple[Float64, Float64],
        into: tuple[Float64, Float64, Float64, Float64],
    ) -> None:
        """Add pairs of triangle and cell; one that leans equally to two axes counts for both."""
        low, high, normals, count = into
        key = self._key(cell)
        most = np.abs(n).max(axis=1)
        for axis in range(3 if self.sided else 1):
            lanes = np.flatnonzero(np.abs(n[:, axis]) >= most - MARGIN) if self.sided else np.arange(len(key))
            at = key[lanes] * (3 if self.sided else 1) + axis
            turned = n[lanes] * np.where(n[lanes, axis] < 0.0, -1.0, 1.0)[:, None]
            np.add.at(count, at, 1.0)
            np.add.at(normals, at, turned)
            np.minimum.at(low, at, self._low + self.width * box[0][lanes])
            np.maximum.at(high, at, self._low + self.width * box[1][lanes])


def overlap(surfaces: Bounds, emitters: Bounds) -> Bounds:
    """The part of the surfaces' bounds that is near emitters; all of it where nothing is."""
    low, high = emitters
    reach = 0.5 * float(np.sqrt(((high - low) ** 2).sum())) + NEAR * float(np.max(surfaces[1] - surfaces[0]))
    low, high = np.maximum(surfaces[0], low - reach), np.minimum(surfaces[1], high + reach)
    return (low, high) if (low <= high).all() else surfaces
