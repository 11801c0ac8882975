"""Shading normals as colours (the lecture's Ver 0.1 and 0.2): checks rays, hits and frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.geometry import SKY
from ..scene.scene import Scene
from ..scene.wave import Rays
from .dimensions import LaneSampler
from .integrator import Integrator

Float32 = NDArray[np.float32]


class Normals(Integrator):
    """Colour (n + 1) / 2 of the world-space shading normal at the first hit; black where nothing is hit."""

    name = "normals"
    label = "Normals"
    description = "World-space shading normals as colours, without any light"

    def sample(self, scene: Scene, rays: Rays, sampler: LaneSampler) -> Float32:
        found = scene.intersect(rays)
        normal = scene.shading_normal(rays, found)
        colour: Float32 = (normal * np.float32(0.5) + np.float32(0.5)) * (found.surface != SKY)
        return colour
