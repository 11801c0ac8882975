"""Which random number is used for what.

Every decision has a dimension of its own, so a pixel's sample can be replayed alone and a low-discrepancy
sequence stays stratified in each decision.

    0, 1   pixel filter         2, 3   lens         then per bounce:
    +0 roulette    +1, +2, +3 emitter: which, where    +4, +5, +6 BSDF: lobe, direction
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from ..core.samplers import Sampler, Stream
from ..core.uniforms import LazyRows

Float32 = NDArray[np.float32]
UInt32 = NDArray[np.uint32]

CAMERA = 4
PER_BOUNCE = 7
SHUTTER = 639  # the last that Sobol has: it is shared with a path's 90th bounce at the earliest


class LaneSampler:
    """Random numbers of a set of lanes: a sampler and each lane's (key, sample index).

    Parameters
    ----------
    sampler : Sampler
    state : (2, N) uint32
        From `Sampler.state`; picked along with the lanes by `take`.
    """

    def __init__(self, sampler: Sampler, state: UInt32) -> None:
        self._sampler, self.state = sampler, state

    def with_state(self, state: UInt32) -> LaneSampler:
        """The same numbers for other lanes: those whose (key, sample index) are `state`."""
        return LaneSampler(self._sampler, state)

    @cached_property
    def _stream(self) -> Stream:
        return self._sampler.stream(self.state)

    @stage("random")
    def _row(self, dimension: int) -> Float32:
        out = np.empty(self.state.shape[1], np.float32)
        self._stream.fill(dimension, out)
        return out

    def _uniforms(self, first: int, count: int) -> LazyRows:
        return LazyRows(lambda k: self._row(first + k), count)

    def pixel(self) -> Float32:
        """(2, N) for the pixel filter."""
        return self._sampler.uniforms(self.state, 0, 2)

    def lens(self) -> Float32:
        """(2, N) for the point on the lens."""
        return self._sampler.uniforms(self.state, 2, 2)

    def roulette(self, bounce: int) -> Float32:
        """(N,) to decide which paths go on."""
        return self._row(CAMERA + PER_BOUNCE * bounce)

    def emitter(self, bounce: int) -> LazyRows:
        """(3, N): which emitter, and where on it."""
        return self._uniforms(CAMERA + PER_BOUNCE * bounce + 1, 3)

    def bsdf(self, bounce: int) -> LazyRows:
        """(3, N): which lobe, and its direction."""
        return self._uniforms(CAMERA + PER_BOUNCE * bounce + 4, 3)
