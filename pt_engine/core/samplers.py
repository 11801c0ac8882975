"""Random numbers as pure functions of (seed, pixel, sample, dimension).

A lane carries two words of state, so a path may be dropped, moved to another slot, or replayed alone and
still sees the same numbers. Nothing depends on batch size, thread or order.

`Independent` hashes. `Sobol` walks Joe and Kuo's sequence over the samples of a pixel, each dimension
Owen-scrambled, and decorrelates pixels by an XOR of each (pixel, dimension): see its docstring. Even and odd
samples are two such sequences that know nothing of each other, so that their difference shows the error.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
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

    def __init__(self, seed: int = 0, samples_hint: int = 0) -> None:
        """`samples_hint`, the samples per pixel to come, only sizes tables; it never changes a number."""
        self.seed = int(seed)
        self._pixel_seed = np.uint32(hash_words(self.seed, 1))
        self._dimension_keys: dict[int, np.uint32] = {}

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
        result, stream = np.empty((count, state.shape[1]), np.float32), self.stream(state)
        for row in range(count):
            stream.fill(dimension + row, result[row])
        return result

    def dimension_key(self, dimension: int) -> np.uint32:
        """What tells one dimension's hash from another's."""
        key = self._dimension_keys.get(dimension)
        if key is None:
            key = self._dimension_keys[dimension] = np.uint32(hash_words(self.seed, 2, dimension))
        return key


class Stream(Protocol):
    """Numbers of a set of lanes; what its dimensions share is computed once."""

    def fill(self, dimension: int, out: Float32) -> None:
        """Put one dimension's (N,) uniforms into `out`."""
        ...


class IndependentStream:
    """Two rounds over pixel and sample, shared by all dimensions, then a keyed hash for each of them."""

    def __init__(self, sampler: Sampler, state: UInt32) -> None:
        self._sampler, self._pixel = sampler, state[0]
        self._base = state[1] * np.uint32(GOLDEN)
        self._base ^= self._pixel
        self._scratch, self._bits = np.empty_like(self._base), np.empty_like(self._base)
        lowbias32_inplace(self._base, self._scratch)

    def fill(self, dimension: int, out: Float32) -> None:
        """Hash the lanes with the dimension's key."""
        np.bitwise_xor(self._base, self._sampler.dimension_key(dimension), out=self._bits)
        keyed_hash_inplace(self._bits, self._pixel, self._scratch)
        to_unit_interval(self._bits, out)


class Independent(Sampler):
    """Independent numbers, by hash: error falls as 1/√n, whatever the integrand."""

    name = "independent"
    label = "Independent"
    correlated = False

    def stream(self, state: UInt32) -> IndependentStream:
        return IndependentStream(self, state)


class Sobol(Sampler):
    """Sobol' points, Owen-scrambled per dimension, XOR-shifted per pixel and dimension.

    The scramble belongs to (seed, dimension), so it is baked into the table and costs nothing per lane;
    the shift belongs to (pixel, dimension). A shifted nested scramble is again a nested scramble, so each
    pixel by itself has just the distribution, and the variance, of full Owen scrambling. Given the
    scramble, pixels are shifted independently and each shift is uniform, so their errors stay uncorrelated.

    Sample s is point s // 2 of sequence s mod 2. The two have scrambles and shifts of their own, so the means
    of even and of odd samples are independent (given the scrambles, too), and ¼ (A − B)² is an unbiased
    estimate of the squared error of their mean: a single sequence cannot tell its own error.
    What the second sequence costs is measured in docs/calibration.md.

    Measured, variance of independent numbers / variance, 16, 64, 256, 1024 samples in a pixel:

        integrand (first dimension)      XOR shift alone       Owen per pixel      this one
        smooth, 2-D (4)                  23, 190, 800, 3400    55, 260, 170, 4e4   58, 310, 180, 4e4
        edge, 4-D (4)                    1.5, 1.5, 1.3, 3.8    2.1, 2.5, 4.0, 5.0  2.1, 2.8, 3.5, 5.2
        disc, 2-D (200: a poor pair)     5.7, 5.2, 1.7, 0.48   5.5, 4.5, 1.4, 1.8  5.4, 4.1, 1.2, 1.7
        ns per number, 64k lanes         1.9                   5.2                 1.9  (independent 1.5)

    A shift alone keeps the pattern of a poor pair of dimensions in every pixel and can do worse than
    independent numbers; scrambling per pixel is as good as this one and costs 2.7 times as much.
    """

    name = "sobol"
    label = "Sobol"
    correlated = True

    def __init__(self, seed: int = 0, samples_hint: int = 0) -> None:
        super().__init__(seed, samples_hint)
        self._directions = sobol.direction_numbers()
        bits = max(samples_hint - 1, 0).bit_length() or MAX_BLOCK_BITS
        self.block_bits = min(max(bits, MIN_BLOCK_BITS), MAX_BLOCK_BITS)
        # Per dimension the block of samples in use and its table: one assignment, so threads never see half.
        self._blocks: dict[int, tuple[int, UInt32]] = {}

    @property
    def dimensions(self) -> int:
        """Dimensions that the sequence has; those beyond are independent."""
        return len(self._directions)

    def state(self, pixel: NDArray[np.integer], sample: NDArray[np.integer]) -> UInt32:
        state = super().state(pixel, sample)
        state[0] ^= (state[1] & np.uint32(1)) * np.uint32(GOLDEN)  # another shift for the other sequence
        return state

    def stream(self, state: UInt32) -> SobolStream:
        return SobolStream(self, state)

    def block(self, dimension: int, block: int) -> UInt32:
        """Scrambled points of samples `block`·2ᵏ … in one dimension: (2ᵏ,), computed when first asked for."""
        known = self._blocks.get(dimension)
        if known is not None and known[0] == block:
            return known[1]
        directions = self._directions[dimension]
        bits = self.block_bits - 1
        start = sobol.combine(directions, block << bits)
        points = sobol.linear_table(directions[:bits]) ^ np.uint32(start)
        table = np.empty(2 * points.size, np.uint32)
        for half in range(2):
            table[half::2] = sobol.owen_scramble(points, self._scramble_seed(dimension, half))
        self._blocks[dimension] = (block, table)
        return table

    def points(self, dimension: int, index: NDArray[np.intp]) -> UInt32:
        """The same points for samples far apart (tiny images): three look-ups and the scramble itself."""
        directions = self._directions[dimension]
        points = np.zeros(index.size, np.uint32)
        for first in range(0, sobol.BITS, 11):
            table = sobol.linear_table(directions[first : first + 11])
            points ^= table.take((index >> (first + 1)) & (len(table) - 1), mode="clip")
        for half in range(2):
            lanes = np.flatnonzero((index & 1) == half)
            points[lanes] = sobol.owen_scramble(points[lanes], self._scramble_seed(dimension, half))
        return points

    def _scramble_seed(self, dimension: int, half: int) -> int:
        return hash_words(self.seed, 3, dimension, half)


class SobolStream:
    """Look-ups in the dimension's table, or points of their own for samples far apart."""

    def __init__(self, sampler: Sobol, state: UInt32) -> None:
        self._sampler, self._state = sampler, state
        self._key, sample = state
        if sample.size == 0:
            return
        first, last = int(sample.min()), int(sample.max())
        self._block = first >> sampler.block_bits
        self._one_block = self._block == last >> sampler.block_bits
        # take() wants intp; the conversion is shared by all dimensions.
        mask = np.uint32((1 << sampler.block_bits) - 1)
        self._index = (sample & mask if self._one_block else sample).astype(np.intp)
        self._shift, self._scratch, self._points = (np.empty_like(sample) for _ in range(3))

    @cached_property
    def _beyond(self) -> IndependentStream:
        """For dimensions that the sequence does not have."""
        return IndependentStream(self._sampler, self._state)

    def fill(self, dimension: int, out: Float32) -> None:
        """The dimension's points, shifted by a hash of (pixel, dimension)."""
        if out.size == 0:
            return
        sampler, points = self._sampler, self._points
        if dimension >= sampler.dimensions:
            self._beyond.fill(dimension, out)
            return
        if self._one_block:
            np.take(sampler.block(dimension, self._block), self._index, out=points, mode="clip")
        else:
            points = sampler.points(dimension, self._index)
        np.bitwise_xor(self._key, sampler.dimension_key(dimension), out=self._shift)
        lowbias32_inplace(self._shift, self._scratch)
        np.bitwise_xor(points, self._shift, out=points)
        to_unit_interval(points, out)


MIN_BLOCK_BITS, MAX_BLOCK_BITS = 6, 11  # tables of 256 bytes to 8 KiB: they stay in the first-level cache

SAMPLERS: dict[str, type[Sampler]] = {sampler.name: sampler for sampler in (Sobol, Independent)}
