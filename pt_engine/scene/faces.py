"""The triangles that lanes are on: what is known at their corners, gathered once for all that asks.

Bump looks at places beside each lane on the same triangle; it shares what is here with the lane itself.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .attributes import between
from .surface import Surface

if TYPE_CHECKING:
    from .scene import Scene

Float32 = NDArray[np.float32]
Spans = tuple[Float32, Float32, Float32]


class Faces:
    """The triangles of the lanes `si`."""

    def __init__(self, scene: Scene, si: Surface) -> None:
        self._scene, self._si = scene, si
        self._spans: dict[tuple[str, str], Spans] = {}

    def spans(self, kind: str, name: str = "") -> Spans:
        """(C, n) values of a layer at corner 0, and what corners 1 and 2 have more; not to be changed."""
        if (kind, name) not in self._spans:
            layer = self._scene.layer(kind, name)
            self._spans[kind, name] = layer.spans(self._si.prim, self._si.instance)
        return self._spans[kind, name]

    def at(self, si: Surface, kind: str, name: str = "") -> Float32:
        """(C, n) values of a layer at points of the triangles."""
        return between(self.spans(kind, name), si.u, si.v)

    @cached_property
    def plane(self) -> tuple[Float32, Float32]:
        """(3, n) n = e1 × e2 in object space, and (n,) 1 / n²: negative on back faces, 0 without an area."""
        _, e1, e2 = self.spans("position")
        n = vectors.cross(e1, e2)
        area = vectors.dot(n, n)
        return n, (1 - 2 * self._si.back) * (area > 0) / (area + (area == 0))
