"""Random numbers that shading itself asks for: pure functions of a path's sample, its bounce, and a key.

Nodes that trace rays need any number of them, so they have no dimensions of the sampler's sequence: they are
hashed, and the samples of one node are consecutive points of a (0, 2)-sequence, shifted digit by digit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import sobol
from .hashing import GOLDEN, hash_words, keyed_hash_inplace, lowbias32_inplace, to_unit_interval

UInt32 = NDArray[np.uint32]
Float32 = NDArray[np.float32]


def noise(state: UInt32, bounce: int) -> UInt32:
    """(2, N) what numbers of one bounce are hashed from; `state` (2, N) is `Sampler.state`'s."""
    mixed = np.empty_like(state)
    np.multiply(state[1], np.uint32(GOLDEN), out=mixed[0])
    mixed[0] ^= state[0]
    mixed[0] ^= np.uint32(hash_words(4, bounce))
    lowbias32_inplace(mixed[0], np.empty_like(mixed[0]))
    mixed[1] = state[0]
    return mixed


def bits(noise: UInt32, *key: int) -> UInt32:
    """(2, N) random bits, of which no two keys' agree."""
    out = np.empty_like(noise)
    scratch = np.empty_like(noise[0])
    for row in range(2):
        np.bitwise_xor(noise[0], np.uint32(hash_words(5, row, *key)), out=out[row])
        keyed_hash_inplace(out[row], noise[1], scratch)
    return out


def uniforms(shift: UInt32, number: int) -> Float32:
    """(2, N) in [0, 1): point `number` of Sobol's first two dimensions, its digits shifted by `bits`."""
    out = np.empty(shift.shape, np.float32)
    for row in range(2):
        to_unit_interval(shift[row] ^ np.uint32(sobol.combine(row, number)), out[row])
    return out
