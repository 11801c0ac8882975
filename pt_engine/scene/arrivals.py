"""How rays came to a point: what shading may ask of a path."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


class Arrival(Protocol):
    """How rays came to a point: what `PathState` knows of it."""

    @property
    def kind(self) -> Int32: ...
    @property
    def depth(self) -> Int32: ...
    @property
    def passed(self) -> Int32: ...
    @property
    def radius(self) -> Float32 | None: ...
    @property
    def spread(self) -> Float32 | None: ...
    @property
    def sharpness(self) -> Float32 | None: ...
    @property
    def noise(self) -> NDArray[np.uint32] | None: ...


class Arrivals(NamedTuple):
    """How some rays came, apart from their paths."""

    kind: Int32
    depth: Int32
    passed: Int32
    radius: Float32 | None = None  # of the ray's cone and how it widens; None: a camera pixel's
    spread: Float32 | None = None
    sharpness: Float32 | None = None
    noise: NDArray[np.uint32] | None = None  # None: nodes that trace rays do without

    @classmethod
    def by(cls, kind: int, n: int) -> Arrivals:
        """`n` rays of one kind that have met nothing before."""
        zero = np.zeros(n, np.int32)
        return cls(np.full(n, kind, np.int32), zero, zero)

    def take(self, index: NDArray[np.intp]) -> Arrivals:
        """Some of them."""
        return Arrivals._make(None if row is None else row.take(index, axis=-1) for row in self)
