"""A light tree: emitters halved by position until each is alone, every group with its outline.

The tree is complete: 2ᴸ leaves, those that no emitter needs stay dark. So it needs no pointers: group h has
the halves 2h and 2h + 1, the root is 1, and leaves under a group are consecutive. Inside of any group an
emitter is drawn by its intensity above all, from an alias table of the group's own (8·L·2ᴸ bytes in all).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.distributions import AliasTables
from .base import Float32, Float64, Index
from .outline import Outlines, merged

BY_POWER = 0.2


class LightTree:
    """Over M emitters.

    Parameters
    ----------
    emitters : Outlines
    chance : (M,) float64
        Of each emitter by power; a fifth of the draws inside of a group go by that.

    Attributes
    ----------
    levels : int
        L.
    groups : Outlines
        By group number; number 0 is not used.
    weight : (2ᴸ⁺¹,) float64
        Of each group: what emitters inside are drawn by; 1 in all.
    leaf_of : (M,) intp
        Place of each emitter in the row of leaves.
    emitter_at : (2ᴸ,) int32
        The emitter in each place.
    """

    def __init__(self, emitters: Outlines, chance: Float64) -> None:
        count = len(emitters.intensity)
        self.levels = max(int(np.ceil(np.log2(count))), 0)
        leaves = 1 << self.levels
        owner = np.arange(leaves) % count  # the second of one place is dark
        order = halved(0.5 * (emitters.low + emitters.high)[owner], self.levels)
        real = order < count
        self.emitter_at = owner[order].astype(np.int32)
        self.leaf_of: Index = np.empty(count, np.intp)
        self.leaf_of[order[real]] = np.flatnonzero(real)
        row = emitters.take(self.emitter_at)
        row = row._replace(intensity=row.intensity * real)
        by_power = chance[self.emitter_at] * real
        weight = (1.0 - BY_POWER) * row.intensity / float(row.intensity.sum())
        weight += BY_POWER * by_power / float(by_power.sum())
        self.groups, self.weight = self._grouped(row, weight)
        self._tables = AliasTables([weight.reshape(1 << level, -1) for level in range(self.levels + 1)])

    def _grouped(self, row: Outlines, weight: Float64) -> tuple[Outlines, Float64]:
        """Outlines and weights of all groups, from the leaves up."""
        rows, weights = [row], [weight]
        for _ in range(self.levels):
            halves = np.arange(len(weight))
            row, weight = merged(row.take(halves[::2]), row.take(halves[1::2])), weight[::2] + weight[1::2]
            rows.append(row)
            weights.append(weight)
        unused = rows[-1]
        groups = Outlines(*(np.concatenate(c) for c in zip(unused, *reversed(rows), strict=True)))
        return groups, np.concatenate([np.zeros(1), *reversed(weights)])

    def first_leaf(self, group: NDArray[np.integer]) -> NDArray[np.int64]:
        """Where the leaves under each group begin."""
        level = np.frexp(np.maximum(group, 1))[1].astype(np.int64) - 1
        leaves = np.left_shift(np.int64(1), self.levels - level)
        return np.asarray(group * leaves - (1 << self.levels), np.int64)

    def draw(self, group: NDArray[np.int32], u: Float32) -> NDArray[np.int32]:
        """(N,) a leaf from each group, by the uniform numbers `u`."""
        level = np.frexp(group)[1] - 1
        size = np.left_shift(np.int64(1), self.levels - level)
        first = group * size - len(self.emitter_at)
        drawn = self._tables.sample(level.astype(np.int64) * len(self.emitter_at) + first, size, u)[0]
        return np.asarray(first + drawn, np.int32)


def halved(centre: Float64, levels: int) -> Index:
    """Order (2ᴸ,) in which every aligned run of 2ᵏ places is split at its median along its longest side."""
    order: Index = np.arange(len(centre))
    for level in range(levels):
        runs = order.reshape(1 << level, -1)
        place = centre[runs]
        side = np.ptp(place, axis=1).argmax(axis=1)
        along = np.take_along_axis(place, side[:, None, None], axis=2)[..., 0]
        split = np.argpartition(along, runs.shape[1] // 2, axis=1)
        order = np.take_along_axis(runs, split, axis=1).ravel()
    return order
