"""How a ray came to the point that it has found."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


class Arrival(Protocol):
    """What `PathState` knows of each ray: its `RayKind` bits, the bounces and surfaces passed before it.

    `travelled` is how far it had come through transparent surfaces when its last part began.
    """

    @property
    def kind(self) -> Int32: ...
    @property
    def depth(self) -> Int32: ...
    @property
    def passed(self) -> Int32: ...
    @property
    def travelled(self) -> Float32: ...
    @property
    def diffuse_depth(self) -> Int32: ...
    @property
    def glossy_depth(self) -> Int32: ...
    @property
    def transmission_depth(self) -> Int32: ...
    @property
    def portal_depth(self) -> Int32: ...
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
    travelled: Float32
    diffuse_depth: Int32
    glossy_depth: Int32
    transmission_depth: Int32
    portal_depth: Int32
    radius: Float32 | None = None  # of the ray's cone and how it widens; None: a camera pixel's
    spread: Float32 | None = None
    sharpness: Float32 | None = None
    noise: NDArray[np.uint32] | None = None  # None: nodes that trace rays do without

    @classmethod
    def by(cls, kind: int, n: int) -> Arrivals:
        """`n` rays of one kind that have met nothing before."""
        zero = np.broadcast_to(np.int32(0), n)
        start = np.broadcast_to(np.float32(0), n)
        return cls(np.broadcast_to(np.int32(kind), n), zero, zero, start, zero, zero, zero, zero)

    @classmethod
    def of(cls, path: Arrival, lanes: NDArray[np.intp]) -> Arrivals:
        """The rays of some of a path's lanes."""
        return cls(*(getattr(path, name) for name in cls._fields)).take(lanes)

    def take(self, index: NDArray[np.intp]) -> Arrivals:
        """Some of them."""
        return Arrivals._make(None if row is None else row.take(index, axis=-1) for row in self)
