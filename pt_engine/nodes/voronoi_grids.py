"""The random points of Voronoi cells, hashed once for a box of cells that many lanes look at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from .grids import CHUNK, Grids, points_of
from .hashes import cell

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Index = NDArray[np.intp]

MOST: Final = 1 << 16  # cells of a grid; a larger one leaves a core's cache, and hashing is hardly dearer
REACH: Final = 2  # how far from their own lanes look at cells
FEW: Final = 512  # lanes beside which a grid's calls cost more than it spares
LARGEST: Final = 1e9  # coordinates that are sure to fit an integer of 32 bits


class CellGrid:
    """The points, as `hashes.cell` has them, of a box of cells that ends at `first` and `last`, by axis."""

    def __init__(self, first: Sequence[int], last: Sequence[int]) -> None:
        count = [b - a + 1 for a, b in zip(first, last, strict=True)]
        lines = [np.int32(a) + np.arange(n, dtype=np.int32) for a, n in zip(first, count, strict=True)]
        cells = [axis.view(np.int32) for axis in points_of(lines)]
        self._points = np.empty((len(first), math.prod(count)), np.float32)
        for k in range(0, self._points.shape[1], CHUNK):
            self._points[:, k : k + CHUNK] = cell(*(axis[k : k + CHUNK] for axis in cells))
        self._stride = [math.prod(count[:axis]) for axis in range(len(count))]
        self._first = list(first)

    @property
    def nbytes(self) -> int:
        """What its points take."""
        return self._points.nbytes

    def random(self, number: Sequence[Int32], offset: Sequence[Int32]) -> list[Float32]:
        """The points, in [0, 1], of the cells `offset` away from those that lanes are in."""
        steps = [n - np.int32(first) for n, first in zip(number, self._first, strict=True)]
        place = self._place(steps) + self._place(offset)
        return [axis.take(place, mode="wrap") for axis in self._points]

    def _place(self, steps: Sequence[Int32]) -> Index:
        """How far in the table so many steps along each axis are."""
        place, *others = (step * np.int32(stride) for step, stride in zip(steps, self._stride, strict=True))
        for other in others:
            place = place + other
        return place.astype(np.intp)


GRIDS: Final = Grids(CellGrid, MOST)


def grid_around(point: Sequence[Float32], cells: int) -> CellGrid | None:
    """One for all lanes, of which each looks at so many cells, or None where hashing these is less work."""
    size = max(p.shape[-1] for p in point)
    if len(point) == 1 or size < FEW:
        return None
    ends = [(float(np.min(p)), float(np.max(p))) for p in point]
    if not all(low > -LARGEST and high < LARGEST for low, high in ends):
        return None
    first = [math.floor(low) - REACH for low, _ in ends]
    last = [math.floor(high) + REACH for _, high in ends]
    return GRIDS.around(first, last, size * cells / 8)
