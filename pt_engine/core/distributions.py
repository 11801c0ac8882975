"""Discrete distributions by alias tables: one look-up, whatever the number of entries.

Each of n buckets of width 1/n holds its own entry up to `keep` and one other, its alias, above it (Walker
1977). The table is filled by the sweep of Hübschle-Schneider and Sanders 2019 ("Parallel Weighted Random
Sampling", section 3): with weights scaled to mean 1, light entries (< 1) have a deficit 1 − w, heavy ones
an excess w − 1, and a light entry borrows from the heavy one in whose stretch of the running excess its
running deficit begins. Running sums are cumulative sums and stretches are found by bisection, so there is
no loop over entries: 8 million take 1 to 3 seconds.

An entry of weight 0 is never chosen. Where all weights are 0 there is nothing to prefer: every entry has the
same probability and `total` is 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Int32 = NDArray[np.int32]
UInt32 = NDArray[np.uint32]

ONE_BELOW = 1.0 - 2.0**-24  # the largest float32 below 1
FLOAT32_ENTRIES = 4096


class AliasTable:
    """Draw indices with probability in proportion to weights.

    Attributes
    ----------
    pmf : (n,) float32
        Probability of each index; 0 where its weight is.
    total : float
        Sum of the weights.
    """

    def __init__(self, weights: NDArray[Any]) -> None:
        """`weights`: (n,) finite, ≥ 0, n ≥ 1. Raises ValueError otherwise."""
        weights = _checked(weights, 1)
        self.total = float(weights.sum())
        probability = weights / self.total if self.total > 0 else np.full(weights.size, 1.0 / weights.size)
        self.pmf: Float32 = probability.astype(np.float32)
        self._table = _alias_table((probability * weights.size)[None])[0]

    def __len__(self) -> int:
        return int(self.pmf.size)

    def sample(self, u: Float32, fine: Float32 | None = None) -> tuple[Int32, Float32]:
        """Index (N,) int32 and a fresh uniform (N,) float32 in [0, 1) from what is left of u.

        Parameters
        ----------
        u : (N,) float32 in [0, 1)
            Its 24 bits are shared among the entries: with n of them 24 − log₂ n are left.
        fine : (N,) float32 in [0, 1), optional
            Independent numbers that carry on where u's bits end. Give them where n is above some
            thousands, for exact probabilities and a remainder that is not coarse; they are used up.
        """
        return _draw(self._table, 0, len(self), u, fine)


class Distribution2D:
    """A piecewise constant density on the unit square, such as an environment map.

    A row is drawn first, then a texel in it, each from an alias table, so each number serves at most
    thousands of entries.

    Attributes
    ----------
    shape : (rows, columns)
    pmf : (rows·columns,) float32
        Probability of each texel, row by row.
    total : float
        Sum of the weights.
    """

    def __init__(self, weights: NDArray[Any]) -> None:
        """`weights`: (rows, columns), finite, ≥ 0; integrals over the texels."""
        weights = _checked(weights, 2)
        self.shape: tuple[int, int] = (weights.shape[0], weights.shape[1])
        rows, columns = self.shape
        row_sum = weights.sum(axis=1)
        self.total = float(row_sum.sum())
        if self.total == 0:
            weights = np.ones(self.shape)
            row_sum = np.full(rows, float(columns))
        self._rows = AliasTable(row_sum)
        self.pmf: Float32 = (weights / float(row_sum.sum())).astype(np.float32).ravel()
        # A row of zeros is never drawn; ones keep its part of the table valid.
        empty = row_sum == 0
        scale = columns / (row_sum + empty)
        self._table = _alias_table(weights * scale[:, None] + empty[:, None]).reshape(-1)

    def sample(self, u: Float32, v: Float32) -> tuple[Float32, Float32, Float32]:
        """Point (x, y) of the unit square (x along a row, y across rows) and its density, each (N,)."""
        rows, columns = self.shape
        row, v = self._rows.sample(v)
        first = row.astype(np.intp) * columns
        column, u = _draw(self._table, first, columns, u, None)
        density = self.pmf.take(first + column, mode="clip") * np.float32(rows * columns)
        x = np.minimum((column + u) * np.float32(1.0 / columns), np.float32(ONE_BELOW))
        y = np.minimum((row + v) * np.float32(1.0 / rows), np.float32(ONE_BELOW))
        return x.astype(np.float32), y.astype(np.float32), density

    def pdf(self, x: Float32, y: Float32) -> Float32:
        """Density at points of the unit square, with respect to its area: (N,)."""
        rows, columns = self.shape
        column = np.minimum((x * np.float32(columns)).astype(np.intp), columns - 1)
        row = np.minimum((y * np.float32(rows)).astype(np.intp), rows - 1)
        density: Float32 = self.pmf.take(row * columns + column, mode="clip") * np.float32(rows * columns)
        return density


class AliasTables:
    """Many alias tables one after the other, of any lengths, for lanes that each draw from one of them.

    Attributes
    ----------
    size : int
        Entries of all tables.
    """

    def __init__(self, blocks: Sequence[NDArray[Any]]) -> None:
        """`blocks`: arrays (tables, n) of weights, finite and ≥ 0; a table of zeros draws its first entry."""
        self._table = np.concatenate([_alias_table(_normalised(_checked(b, 2))).ravel() for b in blocks])
        self.size = int(self._table.size)

    def sample(
        self, first: NDArray[np.int64], n: NDArray[np.int64] | int, u: Float32
    ) -> tuple[NDArray[np.int64], Float32]:
        """Entry (N,) of the table of `n` entries that begins at `first` (N,), and what is left of u."""
        rest = u * np.asarray(n, np.float64)
        bucket = np.minimum(rest.astype(np.int64), np.subtract(n, 1))
        rest -= bucket
        entry = self._table.take(first + bucket, mode="clip").view(np.uint32).reshape(-1, 2)
        keep = np.ascontiguousarray(entry[:, 0]).view(np.float32)
        other = rest >= keep
        bucket += (entry[:, 1] - bucket) * other
        aliased = other.astype(np.float64)
        rest -= aliased * keep
        rest /= aliased * (1.0 - 2.0 * keep) + keep
        return bucket, np.minimum(rest, ONE_BELOW).astype(np.float32)


def _normalised(weights: Float64) -> Float64:
    """Rows scaled to mean 1; a row of zeros becomes its first entry alone."""
    weights = weights.copy()
    total = weights.sum(axis=1)
    weights[total == 0.0, 0] = 1.0
    return np.asarray(weights * (weights.shape[1] / np.where(total == 0.0, 1.0, total))[:, None])


def _checked(weights: NDArray[Any], ndim: int) -> Float64:
    weights = np.asarray(weights, np.float64)
    if weights.ndim != ndim or weights.size == 0:
        raise ValueError(f"expected a non-empty array of {ndim} dimension(s), got shape {weights.shape}")
    if not np.isfinite(weights).all() or weights.min() < 0:
        raise ValueError("weights must be finite and not negative")
    return weights


def _draw(
    table: NDArray[np.uint64], first: NDArray[np.intp] | int, n: int, u: Float32, fine: Float32 | None
) -> tuple[Int32, Float32]:
    """Index below n, and remainder, from the n entries that start at `first`."""
    # Where n is large only float64 holds the digits of u·n that decide between entry and alias.
    number = np.float32 if fine is None and n <= FLOAT32_ENTRIES else np.float64
    rest: NDArray[Any] = np.multiply(u, number(n), dtype=number)
    if fine is not None:
        rest += np.multiply(fine, n * 2.0**-24, dtype=number)
    bucket = np.floor(rest)
    np.minimum(bucket, number(n - 1), out=bucket)
    rest -= bucket
    np.minimum(rest, number(ONE_BELOW), out=rest)
    index = bucket.astype(np.int32)
    entry = table.take(index + first, mode="wrap").view(np.uint32).reshape(-1, 2)
    keep = np.ascontiguousarray(entry[:, 0]).view(np.float32)
    alias = entry[:, 1].view(np.int32)
    other = rest >= keep
    index += (alias - index) * other.view(np.int8)
    # rest < keep: rest / keep; otherwise (rest − keep) / (1 − keep). Neither divisor can be 0.
    aliased: NDArray[Any] = other.astype(number)
    rest -= aliased * keep
    rest /= aliased * (1.0 - 2.0 * keep) + keep
    return index, np.minimum(rest, number(ONE_BELOW)).astype(np.float32)


def _alias_table(scaled: Float64) -> NDArray[np.uint64]:
    """Alias tables of every row of `scaled` (rows, n), whose rows have mean 1.

    Returns (rows, n) uint64: the bits of float32 `keep` and of the alias' uint32 index within the row,
    side by side in memory so that a draw touches one cache line.
    """
    rows, n = scaled.shape
    heavy = scaled >= 1.0
    heavy[np.arange(rows), scaled.argmax(axis=1)] = True  # rounding may leave a row of equals all below 1
    # Running sums within each row; rows are set apart by more than any of them so that one search serves all.
    offset = np.arange(rows, dtype=np.float64)[:, None] * (n + 2.0)
    surplus = scaled - 1.0
    running = np.cumsum(np.where(heavy, surplus, 0.0), axis=1)
    excess = (running + offset)[heavy]
    np.cumsum(np.where(heavy, 0.0, -surplus), axis=1, out=running)
    running += offset
    deficit_after = running[~heavy]
    del running, surplus

    heavy_index = np.flatnonzero(heavy)
    last = np.cumsum(heavy.sum(axis=1)) - 1  # position in `excess` of each row's last heavy entry
    light_index = np.flatnonzero(~heavy)
    # The very bits of the deficit after the one before: where both meet a heavy entry's end they must agree.
    light_row = light_index // n
    deficit_before = offset.ravel()[light_row]
    same_row = np.flatnonzero(light_row[1:] == light_row[:-1]) + 1
    deficit_before[same_row] = deficit_after[same_row - 1]
    keep = np.ones(rows * n, np.float32)
    alias = np.arange(rows * n, dtype=np.int64)

    # A light entry borrows from the first heavy one whose running excess passes the deficit before it.
    donor = np.minimum(np.searchsorted(excess, deficit_before, side="right"), last[light_row])
    keep[light_index] = scaled.ravel()[light_index]
    alias[light_index] = heavy_index[donor]
    # A heavy entry is used up by the light one whose running deficit reaches its excess; the next heavy
    # one fills the rest of its bucket. A row's last one keeps its bucket.
    taker = np.searchsorted(deficit_after, excess, side="left")
    taken = deficit_after[np.minimum(taker, deficit_after.size - 1)] if deficit_after.size else excess
    not_last = np.ones(excess.size, np.bool_)
    not_last[last] = False
    left = 1.0 + excess - taken
    left[left < -1.0] = 1.0  # rounding has used up the row's deficits: that was the next row's
    left[excess <= offset.ravel()[heavy_index // n]] = 1.0  # nothing to give, and nothing taken yet
    keep[heavy_index[not_last]] = np.clip(left, 0.0, 1.0)[not_last]
    alias[heavy_index[not_last]] = heavy_index[np.flatnonzero(not_last) + 1]

    table = np.empty((rows * n, 2), np.uint32)
    table[:, 0] = keep.view(np.uint32)
    table[:, 1] = alias % n
    return table.view(np.uint64).reshape(rows, n)
