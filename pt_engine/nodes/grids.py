"""Parts of a lattice hashed as a whole, for lanes that are more than its points.

Bumps, bounces and samples come back to the same places octave by octave, so grids are kept: here those of
Perlin noise, in `voronoi_grids` those of Voronoi cells.
"""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Sequence
from typing import Any, Final, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from .hashes import hash_uints
from .lattice import SIZES, Index

Float32 = NDArray[np.float32]
UInt32 = NDArray[np.uint32]
UInt64 = NDArray[np.uint64]

FEW: Final = 2048  # lanes beside which a grid's calls cost more than it spares
DEAR: Final = 2.5  # times as much as a point of a grid the eight corners of a lane cost
CHUNK: Final = 32768  # points hashed at a time
MOST: Final = 1 << 18  # points of a grid; looking up cells of a larger one is hardly cheaper than hashing
KEPT: Final = 1 << 25  # bytes of all grids that are kept
PLACES: Final = 1024  # that are remembered


class Grid:
    """The hashes of all lattice points of a box, whose ends are `first` and `last` by axis."""

    def __init__(self, first: Sequence[int], last: Sequence[int]) -> None:
        self.dimension = len(first)
        count = [b - a + 1 for a, b in zip(first, last, strict=True)]
        lines = [(np.int32(a) + np.arange(n, dtype=np.int32)) for a, n in zip(first, count, strict=True)]
        size = SIZES[self.dimension]
        kind: Any = np.uint8 if size <= 16 else np.uint16  # two of them have room in it
        row, rest = points_of(lines[:2]), [axis[:, None] for axis in points_of(lines[2:])]
        hashes = np.empty((math.prod(count[2:]), row[0].size), kind)
        some = max(CHUNK // row[0].size, 1)
        for k in range(0, len(hashes), some):
            part = hash_uints(*row, *(axis[k : k + some] for axis in rest))
            np.bitwise_and(part, np.uint32(size - 1), out=hashes[k : k + some], casting="unsafe")
        self._hash = hashes.reshape(-1)
        self._stride = [math.prod(count[:axis]) for axis in range(self.dimension)]
        self._first = np.array(first, np.float32)[:, None]
        self._cells: dict[tuple[int, ...], UInt64] = {}
        # a word of a cell's hashes; those of two lanes are put together bit by bit
        self._in_word = 8 // hashes.itemsize
        self._bits, self._mask = np.uint64(size.bit_length() - 1), np.uint64((1 << 8 * hashes.itemsize) - 1)
        self._shifts = (8 * hashes.itemsize * np.arange(self._in_word, dtype=np.uint64))[:, None]

    @property
    def nbytes(self) -> int:
        """What its points and cells take."""
        return self._hash.nbytes * (1 + (1 << self.dimension))

    def cells(self, active: tuple[int, ...]) -> UInt64:
        """(points, words) hashes of the corners of the cell that begins at each point, the first lowest."""
        if active not in self._cells:
            strides = [self._stride[axis] for axis in active]
            corners = list(itertools.product((0, 1), repeat=len(active)))
            table = np.zeros((len(self._hash), max(len(corners), self._in_word)), self._hash.dtype)
            for k, corner in enumerate(corners):
                step = sum(itertools.compress(strides, corner))
                table[: len(table) - step, k] = self._hash[step:]
            self._cells[active] = table.view(np.uint64)
        return self._cells[active]

    def pairs(self, low: Float32, active: tuple[int, ...], index: Index) -> None:
        """Where in `PAIRS` the corners of the cells `low` are, as `Hashes.pairs` has it."""
        steps = low - self._first
        place = steps[0]
        for row, stride in zip(steps[1:], self._stride[1:], strict=True):
            row *= np.float32(stride)
            place += row  # exact: a grid has less than 2²⁴ points
        found = self.cells(active).take(place.astype(np.intp), axis=0, mode="wrap")
        pair = found[1::2] << self._bits
        pair |= found[::2]
        where = index.view(np.uint64).reshape(found.shape[1], -1, len(pair))
        np.right_shift(pair.T[:, None], self._shifts[: where.shape[1]], where)
        np.bitwise_and(where, self._mask, where)


def points_of(lines: Sequence[NDArray[np.int32]]) -> list[UInt32]:
    """The coordinates by axis of all points that some coordinates on each make, the first the innermost."""
    axes = np.meshgrid(*lines[::-1], indexing="ij")
    return [np.ascontiguousarray(axis).reshape(-1).view(np.uint32) for axis in axes[::-1]]


class HasSize(Protocol):
    """A grid of any kind."""

    @property
    def nbytes(self) -> int: ...


G = TypeVar("G", bound=HasSize)


class Place(Generic[G]):
    """A box of the lattice, how many lanes have come since it is as large, and its grid if they were many."""

    def __init__(self, first: Sequence[int], last: Sequence[int]) -> None:
        self.first, self.last, self.lanes = list(first), list(last), 0.0
        self.grid: G | None = None

    def widen(self, first: Sequence[int], last: Sequence[int], most: int) -> None:
        """Have the box hold another, with some room around it if it did not; alone if both are too much."""
        ends = list(zip(self.first, self.last, first, last, strict=True))
        if all(a <= c and d <= b for a, b, c, d in ends):
            return
        room = max(max(b, d) - min(a, c) for a, b, c, d in ends) >> 4
        self.first = [a if a <= c else c - room for a, _, c, _ in ends]
        self.last = [b if d <= b else d + room for _, b, _, d in ends]
        if points_between(self.first, self.last) > most:
            self.first, self.last = list(first), list(last)
        self.lanes, self.grid = 0, None


def points_between(first: Sequence[int], last: Sequence[int]) -> int:
    """How many points a box has."""
    return math.prod([b - a + 1 for a, b in zip(first, last, strict=True)])


class Grids(Generic[G]):
    """Grids by place. One is made when the lanes that came there, hashed one by one, have cost as much.

    Parameters
    ----------
    make : callable
        The first and the last point of a box, by axis → its grid.
    most : int
        Points of a grid.
    """

    def __init__(self, make: Callable[[Sequence[int], Sequence[int]], G], most: int) -> None:
        self._make, self._most = make, most
        self._places: dict[tuple[int, ...], Place[G]] = {}
        self._lock = threading.Lock()

    def around(self, first: Sequence[int], last: Sequence[int], lanes: float) -> G | None:
        """One that holds a box, or None where hashing 8 points for each lane is less work so far."""
        if points_between(first, last) > self._most:
            return None
        length = max(b - a for a, b in zip(first, last, strict=True)).bit_length()
        # boxes about as large, about there, are one place
        key = (length, *((a + b >> length) + 1 >> 1 for a, b in zip(first, last, strict=True)))
        with self._lock:
            place = self._places.pop(key, None) or Place[G](first, last)
            self._places[key] = place
            before = place.grid
            place.widen(first, last, self._most)
            place.lanes += lanes
            points = points_between(place.first, place.last)
            if place.grid is None and points <= self._most and points < DEAR * place.lanes:
                place.grid = self._make(place.first, place.last)
            if len(self._places) > PLACES:
                del self._places[next(iter(self._places))]
            if place.grid is not before:
                self._forget()
            return place.grid

    def _forget(self) -> None:
        """Drop the places that were not asked for the longest, as far as their grids are too large."""
        kept = sum(place.grid.nbytes for place in self._places.values() if place.grid is not None)
        for key in list(self._places):
            if kept <= KEPT:
                break
            grid = self._places.pop(key).grid
            kept -= 0 if grid is None else grid.nbytes


GRIDS: Final = Grids(Grid, MOST)
