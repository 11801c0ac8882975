"""Which of many lamps rays may meet: boxes around them in an acceleration structure of their own.

A ray gathers all lamps on its way, so it is sent on from each face of a box that it has met. Boxes whose
faces lie closer than that step touch or overlap; so a box that is met stands for all that it touches, and
none is missed. Lamps that overlap in great numbers are not for this: each ray has to meet them all.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .base import Float32, Float64, Index

Int32 = NDArray[np.int32]
CROWDED = 64  # boxes that the average box may touch
THICKNESS = 1e-4  # of the lamps' and the scene's size: how far boxes reach beyond lamps
STEP = 1e-5  # of that size, or of the way, from a face to where the ray goes on
FACES = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6)]
    + [(0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
)


class Closest(Protocol):
    """What is met first: t (N,) float32, and prim (N,) int32, −1 where nothing is."""

    @property
    def t(self) -> Float32: ...
    @property
    def prim(self) -> Int32: ...


class Intersector(Protocol):
    """Finds closest hits of rays o + s·d, 0 ≤ s ≤ tfar."""

    def intersect(self, origin: Float32, direction: Float32, tfar: Float32) -> Closest: ...


Accelerate = Callable[[Float32, Int32], Intersector]


class Boxes:
    """Boxes around K lamps.

    Parameters
    ----------
    low, high : (K, 3) float64
    size : float
        Of the scene around them.
    accel : callable
    """

    def __init__(self, low: Float64, high: Float64, size: float, accel: Accelerate) -> None:
        self._size = np.float32(max(size, float(np.abs([low, high]).max())))
        reach = THICKNESS * float(self._size)
        low, high = low - reach, high + reach
        self._longest = np.float32(np.sqrt(((high - low) ** 2).sum(axis=1)).max())
        corner = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        vertices = np.where(corner[None], high[:, None], low[:, None]).reshape(-1, 3).astype(np.float32)
        triangles = (8 * np.arange(len(low))[:, None, None] + FACES).reshape(-1, 3).astype(np.int32)
        self._accel = accel(vertices, triangles)
        self._touching, self._first = touching(low - reach, high + reach)
        self.crowded = self._touching is None

    def pairs(self, o: Float32, d: Float32, t: Float32) -> tuple[Index, Index]:
        """Lanes and lamps, sorted by lane, such that lane's ray may meet the lamp before t."""
        count = len(self._first) - 1
        found: list[NDArray[np.int64]] = []
        lanes: Index = np.flatnonzero(t >= 0.0)
        way = np.zeros(lanes.size, np.float32)
        o, d, end = o.take(lanes, axis=1), d.take(lanes, axis=1), t.take(lanes) + self._longest
        while lanes.size:
            hit = self._accel.intersect(o + way * d, d, end - way)
            met = np.flatnonzero(hit.prim >= 0)
            lanes, way = lanes.take(met), way.take(met) + hit.t.take(met)
            way += STEP * np.maximum(way, self._size)
            o, d, end = o.take(met, axis=1), d.take(met, axis=1), end.take(met)
            found.append(lanes.astype(np.int64) * count + hit.prim.take(met) // 12)
        key = np.unique(np.concatenate(found)) if found else np.zeros(0, np.int64)
        key = np.unique(self._with_touching(key // max(count, 1), key % max(count, 1)))
        return key // count, key % count

    def _with_touching(self, lanes: NDArray[np.int64], lamps: NDArray[np.int64]) -> NDArray[np.int64]:
        """Keys of the pairs, and of those lanes with all lamps that these touch."""
        assert self._touching is not None
        counts = self._first[lamps + 1] - self._first[lamps]
        which = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
        others = self._touching[np.repeat(self._first[lamps], counts) + which]
        return np.asarray(np.repeat(lanes, counts) * (len(self._first) - 1) + others)


def touching(low: Float64, high: Float64) -> tuple[NDArray[np.int64] | None, NDArray[np.int64]]:
    """Boxes that each box touches, itself among them, as a list and where in it each box's begin.

    The list is None where it would be too long.
    """
    count = len(low)
    axis = int(np.argmax(np.ptp(low, axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    low, high = low[order], high[order]
    ends = np.searchsorted(low[:, axis], high[:, axis], side="right")  # later ones that begin before it ends
    pairs = [np.stack([np.arange(count)] * 2)]
    total = 0
    step = max(1, (1 << 22) // max(int(np.max(ends - np.arange(count))), 1))
    for begin in range(0, count, step):
        a = np.arange(begin, min(begin + step, count))
        later = ends[a] - a - 1
        first = np.repeat(a, later)
        second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(later) - later, later)
        near = ((low[second] <= high[first]) & (low[first] <= high[second])).all(axis=1)
        pairs += [np.stack([first[near], second[near]]), np.stack([second[near], first[near]])]
        total += 2 * int(near.sum())
        if total > CROWDED * count:
            return None, np.zeros(count + 1, np.int64)
    one, other = order[np.concatenate(pairs, axis=1)]
    other = other[np.argsort(one, kind="stable")]
    return other, np.concatenate([[0], np.cumsum(np.bincount(one, minlength=count))])
