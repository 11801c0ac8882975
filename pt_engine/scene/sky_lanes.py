"""What a shader program sees of rays that have left the scene."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..core.raykind import RayKind
from ..core.view import View
from .arrivals import Arrival
from .no_surface import NoSurface

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


class SkyLanes(NoSurface):
    """Lanes whose ray left the scene: every coordinate is the ray's direction, as in Blender.

    Parameters
    ----------
    direction : (3, N) float32
        World direction of travel.
    came : Arrival
    view : View
        The camera's.
    origin : (3, N) float32 or None
        Where in the world the rays have started; only what an orthographic camera sees depends on it.
    """

    def __init__(self, direction: Float32, came: Arrival, view: View, origin: Float32 | None = None) -> None:
        self.n = direction.shape[1]
        self.position = self.p = direction
        self.ray_kind, self.transparent_depth, self._came = came.kind, came.passed, came
        self._direction, self._origin, self.view = direction, origin, view

    @cached_property
    def wi(self) -> Float32:
        """(3, n) where the rays came from; whoever asks for a normal gets it, too."""
        return -self._direction

    @property
    def ng(self) -> Float32:
        """As `wi`."""
        return self.wi

    ns = ng

    @cached_property
    def material(self) -> Int32:
        """(n,) zero."""
        return np.zeros(self.n, np.int32)

    @cached_property
    def backfacing(self) -> Float32:
        """(n,) zero."""
        return np.zeros(self.n, np.float32)

    @cached_property
    def ray_length(self) -> Float32:
        """(n,) very far."""
        return np.full(self.n, np.float32(1e30))

    def window(self) -> Float32:
        """(2, n) where the direction is in the image; through an orthographic camera, where its ray started.

        Other rays of such a camera's picture take the direction for a point, as Cycles does.
        """
        if self.view.kind != "ORTHO":
            return self.view.image_of_direction(self._direction)
        seen = ((self.ray_kind & RayKind.CAMERA) != 0).astype(np.float32)
        start = self._direction if self._origin is None else self._origin
        return self.view.image_of_point(start * seen + self._direction * (1 - seen))

    @property
    def depth(self) -> Int32:
        """(n,) bounces so far; the sky is one further, as in Cycles."""
        return self._came.depth + np.int32(1)

    def depth_of(self, kind: str) -> Int32:
        """(n,) bounces of one kind so far."""
        return getattr(self._came, f"{kind}_depth")  # type: ignore[no-any-return]

    def generated(self) -> Float32:
        """(3, n) the direction."""
        return self._direction

    object_position = generated

    def uv(self, name: str) -> Float32:
        """Zero: the sky has no uv map."""
        return np.zeros((2, self.n), np.float32)

    def barycentric(self) -> Float32:
        """Zero."""
        return np.zeros((2, self.n), np.float32)

    def object_location(self) -> Float32:
        """Zero."""
        return np.zeros((3, self.n), np.float32)
