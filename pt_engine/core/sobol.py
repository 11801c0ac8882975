"""Sobol' points: the direction numbers of Joe and Kuo, and Owen's scrambling by a hash.

Sample i of dimension d is the XOR of the direction numbers V[d, k] of the bits k that are set in i, a
32-bit fraction. XOR is associative, so whole blocks come from two small tables: the low bits of i vary
within a block, the high bits are one constant.

Owen scrambling flips each binary digit by a random bit that depends on all the digits above it, which
keeps every elementary interval and makes each point uniform; variance of smooth integrands falls to
O(n⁻³) (Owen 1997). Bit-reversed, "depends on the digits above" is "depends on lower bits", which is how
multiplication and addition carry: a hash of those operations only is a nested scramble (Laine and Karras
2011; Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4); the constants are Nathan Vegdahl's).
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .hashing import lowbias32

UInt32 = NDArray[np.uint32]

BITS = 32
RUN = 4
THIRD = 11  # of these bits, rounded up
_DATA = Path(__file__).with_name("joe_kuo.txt")


@cache
def direction_numbers() -> UInt32:
    """V: (dimensions, 32) uint32, the first digit in the top bit (Joe and Kuo 2008, section 2).

    m_k = 2 a₁ m_{k−1} ⊕ 2² a₂ m_{k−2} ⊕ … ⊕ 2ˢ m_{k−s} ⊕ m_{k−s}        V_k = m_k 2^{32−k}
    """
    rows = [[1 << (BITS - 1 - k) for k in range(BITS)]]
    for line in _DATA.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            a, *m = (int(word) for word in line.split())
            rows.append(_recurrence(a, m))
    table = np.array(rows, np.uint64).astype(np.uint32)
    table.flags.writeable = False
    return table


def _recurrence(a: int, m: list[int]) -> list[int]:
    s = len(m)
    m = list(m)
    for k in range(s, BITS):
        value = m[k - s] ^ (m[k - s] << s)
        for i in range(1, s):
            if (a >> (s - 1 - i)) & 1:
                value ^= m[k - i] << i
        m.append(value)
    return [value << (BITS - 1 - k) for k, value in enumerate(m)]


def linear_table(directions: UInt32) -> UInt32:
    """XOR of each subset of `directions` (k,): (2ᵏ,), entry i combining the bits set in i."""
    table = np.zeros(1, np.uint32)
    for direction in directions:
        table = np.concatenate([table, table ^ direction])
    return table


def combine(dimension: int, index: int) -> int:
    """The point with one `index` in one dimension, as an integer."""
    return int(points(dimension, np.array([index], np.uint32))[0])


def points(dimension: int, index: UInt32) -> UInt32:
    """The points with these indices in one dimension, each by three look-ups: (n,)."""
    result = np.zeros(index.size, np.uint32)
    for first, table in _thirds(dimension):
        result ^= table[(index >> np.uint32(first)) & np.uint32(len(table) - 1)]
    return result


@cache
def _thirds(dimension: int) -> list[tuple[int, UInt32]]:
    """The first bit of each third of an index, and what it gives for any value of that third."""
    directions = direction_numbers()[dimension]
    return [(first, linear_table(directions[first : first + THIRD])) for first in range(0, BITS, THIRD)]


def owen_scramble(x: UInt32, seed: int | UInt32) -> UInt32:
    """Nested uniform scramble of 32-bit fractions, new array; one seed, or each its own (n,)."""
    return reverse_bits(_scramble_reversed(reverse_bits(x), np.asarray(seed, np.uint32)))


def shuffled(index: UInt32, seed: UInt32) -> UInt32:
    """The numbers in another order: runs of `RUN` nested as by Owen's scramble, each in any order within.

    Every 2ᵏ of at least `RUN`, from a multiple of it on, stay 2ᵏ of the sequence: a net.
    """
    first = index & ~np.uint32(RUN - 1)
    own, rank = lowbias32(index ^ seed), np.zeros_like(index)
    for k in range(RUN):
        rank += lowbias32((first | np.uint32(k)) ^ seed) < own
    return owen_scramble(index // np.uint32(RUN), seed) * np.uint32(RUN) + rank


def _scramble_reversed(x: UInt32, seed: UInt32) -> UInt32:
    """Each bit changed by a hash of the bits below it: every step only carries upward."""
    x = x ^ (x * np.uint32(0x3D20ADEA))
    x += seed
    x *= (seed >> np.uint32(16)) | np.uint32(1)
    x ^= x * np.uint32(0x05526C56)
    x ^= x * np.uint32(0x53A22864)
    return x


def reverse_bits(x: UInt32) -> UInt32:
    """Bit 0 becomes bit 31 and so on: bytes swapped, then nibbles, pairs and bits within each."""
    x = x.byteswap()
    for shift, mask in ((4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        low = np.uint32(mask)
        x = ((x >> np.uint32(shift)) & low) | ((x & low) << np.uint32(shift))
    return x
