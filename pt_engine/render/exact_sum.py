"""Sums of floating-point numbers that come out the same in any order, to the last bit.

Each term x is rounded once to a multiple of 2⁻³⁶ and cut in two float64 parts,

    x = high + low        high a multiple of 16 (0 for most terms), low a multiple of 2⁻³⁶

Float64 adds multiples of a common grid exactly while the sum stays below 2⁵³ steps: 2⁵⁷ ≈ 1.4e17 for the
high parts, 2¹⁷ for the low ones, from which whole sixteens are carried to the high ones in time. So the
pair is exact, high + low is its correctly rounded value however it is split, and with 0 ≤ low < 16
(`canonical`) equal sums are equal bits. Sums beyond 1.4e17 are still sums, but only as good as float64.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float64 = NDArray[np.float64]
Where = slice | NDArray[np.integer]

GRID = 2.0**-36
UNIT = 16.0
# Adding and subtracting 1.5 · 2⁵² steps rounds to a whole step.
_ROUND_LOW = 1.5 * 2.0**52 * GRID
_ROUND_HIGH = 1.5 * 2.0**52 * UNIT
_ROOM = 2.0**14  # for the low parts that are added at once
_GROUP = 2048  # terms that are added at once: 8 is the most that a cut leaves of each
_FULL = 2.0**15  # where a low sum is carried


def add(high: Float64, low: Float64, where: Where, terms: Float64, largest: float) -> None:
    """Add `terms` to the sums at `where`.

    Parameters
    ----------
    high, low : (n,) float64
        The sums; changed in place.
    where : slice or (m,) integers, all different
    terms : (k, m) float64
        k terms for each sum; overwritten.
    largest : float
        At least the magnitude of every term.
    """
    for first in range(0, len(terms), _GROUP):
        part = terms[first : first + _GROUP]
        limit = _ROOM / len(part)
        high_part = _cut(part, limit) if largest > limit else None
        _round(part, _ROUND_LOW)
        low_part = part[0] if len(part) == 1 else part.sum(axis=0)
        if high_part is not None:
            high[where] += high_part
        total = low[where]  # a view, where `where` is a slice
        total += low_part
        if np.max(total, initial=0.0) > _FULL or np.min(total, initial=0.0) < -_FULL:
            high[where] += _carry(total)
        if total.base is None:
            low[where] = total


def _cut(terms: Float64, limit: float) -> Float64:
    """Take whole sixteens out of the terms (if few are beyond ± limit, out of those): their sums (m,)."""
    flat = terms.reshape(-1)
    large = np.flatnonzero(np.abs(flat) > limit)
    if large.size * 8 > flat.size:
        dense = terms.copy()
        _round(dense, _ROUND_HIGH)
        terms -= dense
        return dense.sum(axis=0)
    sixteens = flat.take(large)
    _round(sixteens, _ROUND_HIGH)
    flat[large] -= sixteens
    m = terms.shape[1]
    return np.bincount(large % m, sixteens, minlength=m)


def merge(high: Float64, low: Float64, other_high: Float64, other_low: Float64) -> None:
    """Add other sums of the same shape."""
    other_low = other_low.copy()
    high += other_high
    high += _carry(other_low)
    high += _carry(low)
    low += other_low


def canonical(high: Float64, low: Float64) -> tuple[Float64, Float64]:
    """The same sums with 0 ≤ low < 16, as new arrays: the one form that equal sums share."""
    low = low.copy()
    return high + _carry(low), low


def _round(x: Float64, magic: float) -> None:
    x += magic
    x -= magic


def _carry(low: Float64) -> Float64:
    """Take whole sixteens out of `low`, so that 0 ≤ low < 16; return them."""
    # Rounding down is rounding to nearest 8 lower; half a step of the grid keeps it off the ties.
    sixteens = low - (0.5 * UNIT - 0.5 * GRID)
    _round(sixteens, _ROUND_HIGH)
    low -= sixteens
    return sixteens
