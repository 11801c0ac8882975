"""How a ray came to the point that it has found."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Int32 = NDArray[np.int32]


class Arrival(Protocol):
    """How rays came to a point: what `PathState` knows of it."""

    @property
    def kind(self) -> Int32: ...
    @property
    def depth(self) -> Int32: ...
    @property
    def passed(self) -> Int32: ...


class Arrivals(NamedTuple):
    """How some rays came, apart from their paths."""

    kind: Int32
    depth: Int32
    passed: Int32

    @classmethod
    def by(cls, kind: int, n: int) -> Arrivals:
        """`n` rays of one kind that have met nothing before."""
        zero = np.zeros(n, np.int32)
        return cls(np.full(n, kind, np.int32), zero, zero)

    def take(self, index: NDArray[np.intp]) -> Arrivals:
        """Some of them."""
        return Arrivals(*(row.take(index) for row in self))
