"""Lanes that lie on no triangle and no strand: what nodes ask of those, where a lamp or the sky is asked."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]


class NoSurface:
    """Answers that lamps and the sky share: they have no faces, no attributes and no object."""

    n: int
    smooth = False
    rounds = None

    def color(self, name: str) -> Float32:
        """Zero: no colour attribute."""
        return np.zeros((4, self.n), np.float32)

    per_object = color

    def attribute(self, name: str) -> Float32:
        """Not found: zero with alpha 1."""
        out = np.zeros((5, self.n), np.float32)
        out[3] = 1
        return out

    def object_random(self) -> Float32:
        """Zero."""
        return np.zeros(self.n, np.float32)

    object_index = object_random

    def object_color(self) -> Float32:
        """Zero."""
        return np.zeros((4, self.n), np.float32)

    def strand(self) -> Float32:
        """Zero: no strand."""
        return np.zeros((4, self.n), np.float32)

    def sides(self) -> list[tuple[Float32, Float32]]:
        """None: no triangle."""
        return []

    def object_tangent(self, uv_name: str) -> tuple[Float32, Float32]:
        """Zero: no uv map."""
        return np.zeros((3, self.n), np.float32), np.ones(self.n, np.float32)

    def bump_steps(self, width: float) -> tuple[Float32, Float32]:
        """None: no bumps."""
        zero = np.zeros((3, self.n), np.float32)
        return zero, zero

    def shifted(self, axis: int, width: float) -> NoSurface:
        """The same lanes."""
        return self
