"""Which of many boxes rays run through: a tree in which each node has eight children, walked level by level.

Boxes lie in the order of a Z curve, and eight neighbours make a node: node i has the children 8i to 8i + 7,
so the tree is but an array of boxes for each level. A wavefront goes down it as pairs of ray and node.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Index = NDArray[np.intp]

WIDTH = 8
SLACK = np.float32(1 + 2.0**-20)  # of distances, and of what boxes are larger than what is in them: rounding


class Pairs(NamedTuple):
    """Rays and boxes that they run through, sorted by ray, then by where it enters: (M,) each."""

    ray: Index
    box: Index
    enters: Float32


class BoxTree:
    """A tree over K boxes.

    Parameters
    ----------
    low, high : (K, 3) float64
    """

    def __init__(self, low: Float64, high: Float64) -> None:
        self._order = z_order((low + high) / 2)
        reach = 2.0**-20 * np.maximum(np.abs(low), np.abs(high)).max(initial=0.0)
        boxes = np.concatenate([(low - reach).T, (high + reach).T])[:, self._order].astype(np.float32)
        self._levels: list[Float32] = []  # (6, nodes, children), the root first
        while True:
            boxes = padded(boxes)
            nodes = boxes.reshape(6, -1, WIDTH)
            self._levels.insert(0, nodes)
            if nodes.shape[1] == 1:
                break
            boxes = np.concatenate([np.nanmin(nodes[:3], axis=2), np.nanmax(nodes[3:], axis=2)])

    def pairs(self, o: Float32, d: Float32, tfar: Float32) -> Pairs:
        """What rays (3, N) with t in [0, `tfar`] may meet."""
        ray = np.flatnonzero(tfar >= 0)
        node = np.zeros(len(ray), np.intp)
        steep = np.where(np.abs(d) < 1e-30, np.copysign(np.float32(1e-30), d), d)
        lines = np.concatenate([o, 1 / steep, tfar[None]])
        for level in self._levels:
            line = lines.take(ray, axis=1)[:, :, None]
            box = level.take(node, axis=1)
            with np.errstate(over="ignore"):
                one, other = (box[:3] - line[:3]) * line[3:6], (box[3:] - line[:3]) * line[3:6]
            enters = np.maximum(np.minimum(one, other).max(axis=0), 0)
            leaves = np.minimum(np.maximum(one, other).min(axis=0), line[6]) * SLACK
            which = np.flatnonzero(enters <= leaves)
            parent, child = np.divmod(which, WIDTH)
            ray, node = ray.take(parent), node.take(parent) * WIDTH + child
            enters = enters.ravel().take(which)
        order = np.lexsort((enters, ray))
        return Pairs(ray.take(order), self._order.take(node.take(order)), enters.take(order))


def padded(boxes: Float32) -> Float32:
    """Boxes (6, K) made a multiple of eight by ones of NaN, which no ray meets."""
    missing = -boxes.shape[1] % WIDTH or (WIDTH if boxes.shape[1] == 0 else 0)
    return np.concatenate([boxes, np.full((6, missing), np.nan, np.float32)], axis=1)


def z_order(points: Float64) -> Index:
    """Order of points (K, 3) along a Z curve with 2²⁰ steps to each side."""
    if len(points) == 0:
        return np.zeros(0, np.intp)
    low, size = points.min(axis=0), float(np.max(np.ptp(points, axis=0)))
    cell = ((points - low) * ((2**20 - 1) / max(size, 1e-300))).astype(np.int64)
    key = np.zeros(len(points), np.int64)
    for bit in range(20):
        for axis in range(3):
            key |= (cell[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(key, kind="stable")
