"""Random numbers as pure functions of (seed, pixel, sample, dimension).

A lane carries two words of state, so a path may be dropped, moved to another slot, or replayed alone and
still sees the same numbers. Nothing depends on batch size, thread or order.

`Independent` hashes. `Sobol` walks Joe and Kuo's first four dimensions over the samples of a pixel, for each
set of four dimensions in another order, Owen-scrambled, and decorrelates pixels by an XOR of each (pixel,
dimension): see its docstring. Even and odd samples are two such sequences that know nothing of each other, so
that their difference shows the error.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from . import sobol
from .hashing import GOLDEN, hash_words, keyed_hash_inplace, lowbias32, lowbias32_inplace, to_unit_interval

UInt32 = NDArray[np.uint32]
Float32 = NDArray[np.float32]

MAX_SAMPLES = 2**31


class Sampler(ABC):
    """Uniform numbers in [0, 1) for each dimension of each sample of each pixel.

    Attributes
    ----------
    name, label : str
    correlated : bool
        Whether samples of a pixel know of each other. Even and odd ones never do.
    """

    name: ClassVar[str]
    label: ClassVar[str]
    correlated: ClassVar[bool]

    def __init__(self, seed: int = 0) -> None:
        self.seed = int(seed)
        self._pixel_seed = np.uint32(hash_words(self.seed, 1))
        self._dimension_keys: dict[tuple[int, int], UInt32] = {}

    def state(self, pixel: NDArray[np.integer], sample: NDArray[np.integer]) -> UInt32:
        """What a lane has to carry: (2, N) uint32 of pixel key and sample index.

        Parameters
        ----------
        pixel : (N,) integers < 2³²
        sample : (N,) integers < 2³¹
            Or, for all samples of all pixels, (m,) and (s, 1): N = s·m, sample by sample.
        """
        key = lowbias32(np.asarray(pixel).astype(np.uint32, copy=False) ^ self._pixel_seed)
        state = np.empty((2, *np.broadcast_shapes(pixel.shape, sample.shape)), np.uint32)
        state[0], state[1] = key, sample
        return state.reshape(2, -1)

    @abstractmethod
    def stream(self, state: UInt32) -> Stream:
        """The numbers of the lanes with `state` (2, N), dimension by dimension."""

    def uniforms(self, state: UInt32, dimension: int, count: int) -> Float32:
        """`count` dimensions from `dimension` on: (count, N) float32 in [0, 1), multiples of 2⁻²⁴."""
        return self.stream(state).rows(dimension, count)

    def dimension_keys(self, first: int, count: int) -> UInt32:
        """What tells one dimension's hash from another's: (count, 1), of those from `first` on."""
        keys = self._dimension_keys.get((first, count))
        if keys is None:
            words = [[hash_words(self.seed, 2, first + k)] for k in range(count)]
            keys = self._dimension_keys[first, count] = np.array(words, np.uint32)
        return keys


class Stream(Protocol):
    """Numbers of a set of lanes; what its dimensions share is computed once."""

    def rows(self, first: int, count: int) -> Float32:
        """(count, N) uniforms of the dimensions from `first` on."""
        ...


class IndependentStream:
    """Two rounds over pixel and sample, shared by all dimensions, then a keyed hash for each of them."""

    def __init__(self, sampler: Sampler, state: UInt32) -> None:
        self._sampler, self._pixel = sampler, state[0]
        self._base = state[1] * np.uint32(GOLDEN)
        self._base ^= self._pixel
        lowbias32_inplace(self._base, np.empty_like(self._base))

    def rows(self, first: int, count: int) -> Float32:
        """Hash the lanes with each dimension's key."""
        bits = self._base ^ self._sampler.dimension_keys(first, count)
        scratch = np.empty_like(bits)
        keyed_hash_inplace(bits, self._pixel, scratch)
        return to_unit_interval(bits, scratch.view(np.float32))


class Independent(Sampler):
    """Independent numbers, by hash: error falls as 1/√n, whatever the integrand."""

    name = "independent"
    label = "Independent"
    correlated = False

    def stream(self, state: UInt32) -> IndependentStream:
        return IndependentStream(self, state)


class Sobol(Sampler):
    """Sobol' points, shuffled and Owen-scrambled, XOR-shifted per pixel and dimension.

    Four dimensions in a row, from a multiple of 4 on, are a set: the first four of the sequence, whose pairs
    are the best it has, in an order of the set's own (Burley 2020, section 5). Powers of two of points, from
    4 on, stay together (`sobol.shuffled`), so each set is a net; which of its points meets which of another
    set's is chance, and what two sets give together is left as with independent numbers. A sequence of
    hundreds of dimensions has pairs so poor that the error stands still for a hundred samples, here or there.

    Scrambles and orders belong to (seed, dimension or set) and to one of 16 groups, which each pixel is of by
    chance: they are baked into a table and cost nothing per lane. Were there but one, all pixels would share
    its luck, and the error of a render would be that of its seed. The shift belongs to (pixel, dimension). A
    shifted nested scramble is again a nested scramble, so each pixel by itself has just the distribution, and
    the variance, of full Owen scrambling. Given the scrambles, pixels are shifted independently and each
    shift is uniform, so their errors stay uncorrelated.

    Sample s is point s // 2 of sequence s mod 2. The two have scrambles and shifts of their own, so the means
    of even and of odd samples are independent (given the scrambles, too), and ¼ (A − B)² is an unbiased
    estimate of the squared error of their mean: a single sequence cannot tell its own error.
    What the second sequence costs is measured in docs/calibration.md.

    Measured, variance of independent numbers / variance, 16, 64, 256, 1024 samples in a pixel:

        integrand (dimensions)           640 dimensions, one scramble    this one
        smooth, 2-D (4, 5)               1.3, 50, 150, 2500              15, 150, 1600, 2.2e4
        disc, 2-D (200, 201)             3.0, 3.9, 2.5, 3.0              2.8, 8.5, 15, 32
        disc, 2-D of two sets (1, 4)     3.1, 3.1, 13, 33                2.9, 3.2, 3.0, 3.1
        edge, 4-D (4, 5, 6, 7)           2.6, 2.4, 6.0, 7.5              3.0, 2.9, 5.1, 4.7
        edge, 4-D of two (0, 1, 4, 5)    3.0, 2.5, 1.1, 6.5              2.9, 3.1, 3.1, 3.2
        edge, 4-D of two (0, 1, 12, 13)  2.6, 2.8, 3.0, 5.1              2.9, 3.0, 2.9, 3.1
    """

    name = "sobol"
    label = "Sobol"
    correlated = True

    def __init__(self, seed: int = 0) -> None:
        super().__init__(seed)
        # Per dimension the block of samples in use and its table, and per set its order: one assignment, so
        # threads never see half.
        self._blocks: dict[int, tuple[int, UInt32]] = {}
        self._orders: dict[int, tuple[int, UInt32]] = {}

    def state(self, pixel: NDArray[np.integer], sample: NDArray[np.integer]) -> UInt32:
        state = super().state(pixel, sample)
        state[0] ^= (state[1] & np.uint32(1)) * np.uint32(GOLDEN)  # another shift for the other sequence
        return state

    def stream(self, state: UInt32) -> SobolStream:
        return SobolStream(self, state)

    def block(self, dimension: int, block: int) -> UInt32:
        """Points of the block's samples in one dimension, of all groups: (BLOCK · GROUPS,), kept."""
        known = self._blocks.get(dimension)
        if known is not None and known[0] == block:
            return known[1]
        sample, group = np.divmod(np.arange(BLOCK * GROUPS, dtype=np.uint32), np.uint32(GROUPS))
        sample += np.uint32(block * BLOCK)
        number = dimension // SET
        order = self._orders.get(number)
        if order is None or order[0] != block:
            order = self._orders[number] = block, self._shuffled(number, sample, group)
        table = self._scrambled(dimension, order[1], sample, group)
        self._blocks[dimension] = (block, table)
        return table

    def points(self, dimension: int, sample: UInt32, group: UInt32) -> UInt32:
        """Scrambled points of samples (n,), each in the order and the scramble of its group."""
        order = self._shuffled(dimension // SET, sample, group)
        return self._scrambled(dimension, order, sample, group)

    def _shuffled(self, number: int, sample: UInt32, group: UInt32) -> UInt32:
        """Which points of the sequence samples are in a set of dimensions."""
        seeds = self._seeds(SHUFFLED, number)[sample & np.uint32(1), group]
        return sobol.shuffled(sample >> np.uint32(1), seeds)

    def _scrambled(self, dimension: int, order: UInt32, sample: UInt32, group: UInt32) -> UInt32:
        seeds = self._seeds(SCRAMBLED, dimension)[sample & np.uint32(1), group]
        return sobol.owen_scramble(sobol.points(dimension % SET, order), seeds)

    def _seeds(self, purpose: int, number: int) -> UInt32:
        """(2, GROUPS): of each sequence and group."""
        half, group = np.divmod(np.arange(2 * GROUPS, dtype=np.uint64), np.uint64(GROUPS))
        return hash_words(self.seed, purpose, number, half, group).astype(np.uint32).reshape(2, GROUPS)


class SobolStream:
    """Look-ups in the dimension's table, or points of their own for samples far apart."""

    def __init__(self, sampler: Sobol, state: UInt32) -> None:
        self._sampler = sampler
        self._key, self._sample = state
        if self._sample.size == 0:
            return
        self._block = int(self._sample.min()) // BLOCK
        self._one_block = self._block == int(self._sample.max()) // BLOCK
        self._group = self._key >> np.uint32(32 - GROUP_BITS)
        if self._one_block:
            # take() wants intp; the conversion is shared by all dimensions.
            index = (self._sample & np.uint32(BLOCK - 1)) << np.uint32(GROUP_BITS)
            index |= self._group
            self._index = index.astype(np.intp)

    def rows(self, first: int, count: int) -> Float32:
        """Each dimension's points, shifted by a hash of (pixel, dimension)."""
        bits = self._key ^ self._sampler.dimension_keys(first, count)
        scratch = np.empty_like(bits)
        lowbias32_inplace(bits, scratch)
        if bits.size:
            for dimension, points in enumerate(scratch, first):
                self._put_points(dimension, points)
            bits ^= scratch
        return to_unit_interval(bits, scratch.view(np.float32))

    def _put_points(self, dimension: int, out: UInt32) -> None:
        sampler = self._sampler
        if self._one_block:
            sampler.block(dimension, self._block).take(self._index, out=out, mode="wrap")
        else:
            out[:] = sampler.points(dimension, self._sample, self._group)


SET = 4  # dimensions that are stratified together
GROUP_BITS, BLOCK = 4, 128  # a table of all groups and so many samples is 8 KiB: it stays in the first cache
GROUPS = 1 << GROUP_BITS
SCRAMBLED, SHUFFLED = 3, 4  # what seeds are for

SAMPLERS: dict[str, type[Sampler]] = {sampler.name: sampler for sampler in (Sobol, Independent)}
