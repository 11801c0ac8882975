"""Sums of floating-point numbers that come out the same in any order, to the last bit.

Each term x is rounded once to a multiple of 2⁻³⁶ and cut in two float64 parts,

    x = high + low        high a multiple of 16 (0 for most terms), low a multiple of 2⁻³⁶

Float64 adds multiples of a common grid exactly while the sum stays below 2⁵³ steps: 2⁵⁷ ≈ 1.4e17 for the
high parts, 2¹⁷ for the low ones. After every addition whole sixteens are carried from low to high,
0 ≤ low < 16, which makes the pair a unique representation: equal sums are equal bits. Sums beyond 1.4e17
are still sums, but only as good as float64.
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
_ROOM = 2.0**14  # for the low parts between two carries
_GROUP = 2048  # terms between two carries, so that a low part of 8 has room


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
        _carry(high, low, where, part[0] if len(part) == 1 else part.sum(axis=0), high_part)


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
    _carry(high, low, slice(None), other_low, other_high)


def _round(x: Float64, magic: float) -> None:
    x += magic
    x -= magic


def _carry(high: Float64, low: Float64, where: Where, low_part: Float64, high_part: Float64 | None) -> None:
    total = low[where] + low_part
    if high_part is not None or (total.size and (np.max(total) >= UNIT or np.min(total) < 0.0)):
        carry = np.floor(total * (1.0 / UNIT)) * UNIT
        total -= carry
        high[where] += carry if high_part is None else carry + high_part
    low[where] = total
