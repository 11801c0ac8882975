"""All emissive faces of a scene: which triangles are drawn alone, which in pairs, and how likely each is."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.snapshot import Visibility
from .base import TINY, Float32, Float64
from .outline import Outlines, joined, of_faces
from .parallelogram import Parallelograms, paired
from .parts import Part
from .select import triangle_power
from .triangle import TriangleEmitters, Triangles


class Faces:
    """Emissive triangles, grouped into faces that are each one emitter.

    Attributes
    ----------
    power : (F,) float64
        Watts of each face: the triangles that stand alone, then the parallelograms.
    triangles : int
        Number of triangles.
    parts : list of Part
        Their samplers, in that order.
    """

    def __init__(self, emitters: TriangleEmitters) -> None:
        watts = triangle_power(emitters)
        self._emitters, self._pairs = emitters, paired(emitters)
        self._alone = np.setdiff1d(np.arange(emitters.count), self._pairs)
        self.power: Float64 = np.concatenate([watts[self._alone], watts[self._pairs].sum(axis=1)])
        self.triangles = emitters.count
        self.parts: list[Part] = []

    def outlines(self) -> Outlines:
        """What the choice has to know of each face."""
        corners = self._emitters.vertices.astype(np.float64)
        alone, pairs = corners[self._alone], corners[self._pairs].reshape(-1, 6, 3)
        watts = self.power[: len(alone)], self.power[len(alone) :]
        return joined(of_faces(alone, watts[0]), of_faces(pairs, watts[1]))

    def choose_with(self, chance: Float64) -> None:
        """Make the samplers; `chance` (F,) is the probability of each face."""
        emitters, alone, pairs = self._emitters, self._alone, self._pairs
        of_alone, of_pairs = chance[: len(alone)], chance[len(alone) :]
        if len(alone):
            self.parts.append(Triangles(emitters, alone, of_alone))
        if len(pairs):
            self.parts.append(Parallelograms(emitters, pairs, of_pairs))
        self._number = np.empty(emitters.count, np.int32)
        self._number[alone] = np.arange(len(alone))
        self._number[pairs] = len(alone) + np.arange(len(pairs))[:, None]
        density = np.empty(emitters.count)
        area = emitters.areas()
        density[alone] = of_alone / np.maximum(area[alone], TINY)
        density[pairs] = (of_pairs / np.maximum(area[pairs].sum(axis=1), TINY))[:, None]
        self._density: Float32 = density.astype(np.float32)

    def number(self, triangle: NDArray[np.integer]) -> NDArray[np.int32]:
        """(n,) the face that each `triangle` belongs to."""
        return self._number.take(triangle, mode="clip")

    def whose(self) -> NDArray[np.int64]:
        """(F,) `TriangleEmitters.whose` of each face."""
        every = np.full(len(self.power), Visibility.ALL, np.int64)
        if self._emitters.whose is not None:
            every[self._number] = self._emitters.whose
        return every

    def pdf(self, triangle: NDArray[np.integer], t: Float32, cos_light: Float32) -> Float32:
        """(n,) density of a ray that meets `triangle` after `t` at |cos| `cos_light`, the choice included."""
        density = self._density.take(triangle, mode="clip")
        density *= t * t
        density /= np.maximum(cos_light, 1e-12)
        return density
