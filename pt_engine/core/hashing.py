"""Integer hashes: 32 bits in, 32 well-mixed bits out, on whole arrays.

`lowbias32` is the two-round multiply-xorshift found by Chris Wellons' hash prospector (2018; the variant
with bias 0.107): a bijection of the 32-bit integers in which each input bit flips each output bit
with probability close to 1/2.

    x ^= x >> 16;  x *= 0x21f0aaad;  x ^= x >> 15;  x *= 0xd35a2d97;  x ^= x >> 15

`keyed_hash` adds a second word between the rounds, as permuted congruential generators add their stream
(O'Neill 2014): two (x, key) pairs that agree in one word still differ in the result.
"""

from __future__ import annotations

from typing import Any, cast, overload

import numpy as np
from numpy.typing import NDArray

UInt32 = NDArray[np.uint32]
UInt64 = NDArray[np.uint64]
Float32 = NDArray[np.float32]

_M1, _M2 = np.uint32(0x21F0AAAD), np.uint32(0xD35A2D97)
_MASK = 0xFFFFFFFF
GOLDEN = 0x9E3779B9  # 2³² / φ: its multiples are spread evenly


def lowbias32(x: UInt32) -> UInt32:
    """Hash of each element, as a new array."""
    x = x.copy()
    lowbias32_inplace(x, np.empty_like(x))
    return x


def lowbias32_inplace(x: UInt32, scratch: UInt32) -> None:
    """Hash `x` in place; `scratch` has its shape."""
    keyed_hash_inplace(x, None, scratch)


def keyed_hash_inplace(x: UInt32, key: UInt32 | None, scratch: UInt32) -> None:
    """Hash `x` in place, `key` added between the rounds; `scratch` has its shape."""
    np.right_shift(x, 16, out=scratch)
    np.bitwise_xor(x, scratch, out=x)
    np.multiply(x, _M1, out=x)
    np.right_shift(x, 15, out=scratch)
    np.bitwise_xor(x, scratch, out=x)
    if key is not None:
        np.add(x, key, out=x)
    np.multiply(x, _M2, out=x)
    np.right_shift(x, 15, out=scratch)
    np.bitwise_xor(x, scratch, out=x)


@overload
def hash_words(*words: int) -> int: ...  # type: ignore[overload-overlap]  # arrays are no ints
@overload
def hash_words(*words: int | UInt64) -> UInt64: ...
def hash_words(*words: int | UInt64) -> int | UInt64:
    """One 32-bit hash of any number of integers (each taken modulo 2⁶⁴), for seeds and dimensions.

    Some may be arrays, of one shape: then so is the hash.
    """
    h: Any = 0x6A09E667
    for word in words:
        for half in (word & _MASK, (word >> 32) & _MASK):
            h = _lowbias32_of((h + half * GOLDEN + 1) & _MASK)
    return cast("int | UInt64", _lowbias32_of(h ^ 0xBB67AE85))


def _lowbias32_of(x: Any) -> Any:
    """`lowbias32` of an int or of a uint64 array, whose products do not overflow."""
    x = ((x ^ (x >> 16)) * int(_M1)) & _MASK
    x = ((x ^ (x >> 15)) * int(_M2)) & _MASK
    return x ^ (x >> 15)


def to_unit_interval(bits: UInt32, out: Float32) -> Float32:
    """The top 24 bits as float32 in [0, 1), each value exact, in `out`; `bits` is overwritten."""
    np.right_shift(bits, 8, out=bits)
    # 24 bits fit a signed integer, whose conversion every CPU vectorises.
    np.copyto(out, bits.view(np.int32), casting="unsafe")
    return np.multiply(out, np.float32(2.0**-24), out=out)
