"""Which random number is used for what.

Every decision has a dimension of its own, so a pixel's sample can be replayed alone and a low-discrepancy
sequence stays stratified in each decision. Four from a multiple of 4 on are stratified together, the first
two best (`core.samplers.Sobol`): they are a place on something.

    0, 1   pixel filter         2, 3   lens         then per bounce:
    +0, +1 place on an emitter    +2 which    +3 roulette    +4, +5 BSDF: direction    +6 lobe    +7 left over
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
PER_BOUNCE = 8
SHUTTER = CAMERA + 7  # what the first bounce leaves


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
    def _rows(self, first: int, count: int) -> Float32:
        return self._stream.rows(first, count)

    def _choice_and_place(self, first: int) -> LazyRows:
        """As emitters and BSDFs take them."""
        return LazyRows((1, lambda: self._rows(first + 2, 1)), (2, lambda: self._rows(first, 2)))

    def pixel(self) -> Float32:
        """(2, N) for the pixel filter."""
        return self._sampler.uniforms(self.state, 0, 2)

    def lens(self) -> Float32:
        """(2, N) for the point on the lens."""
        return self._sampler.uniforms(self.state, 2, 2)

    def roulette(self, bounce: int) -> Float32:
        """(N,) to decide which paths go on."""
        u: Float32 = self._rows(CAMERA + PER_BOUNCE * bounce + 3, 1)[0]
        return u

    def emitter(self, bounce: int) -> LazyRows:
        """(3, N): which emitter, and where on it."""
        return self._choice_and_place(CAMERA + PER_BOUNCE * bounce)

    def bsdf(self, bounce: int) -> LazyRows:
        """(3, N): which lobe, and its direction."""
        return self._choice_and_place(CAMERA + PER_BOUNCE * bounce + 4)
