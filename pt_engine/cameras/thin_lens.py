"""The thin lens: a point on the aperture, from which all rays meet in one point of the plane of focus.

A point at depth z is imaged as a disk whose diameter, measured on the plane at distance 1, is

    c = 2 r |1/z − 1/f|           r the aperture's radius, f the focus distance (for the perspective camera)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core import warps
from ..core.clock import stage
from ..scene.snapshot import CameraData

Float32 = NDArray[np.float32]


class Aperture(NamedTuple):
    """A round or polygonal opening.

    Attributes
    ----------
    radius : float
        Metres; of the circumscribed circle where there are blades.
    blades : int
        Corners; fewer than 3 make it round.
    rotation : float
        Radians.
    ratio : float
        Anamorphic: the width is divided by it.
    """

    radius: float
    blades: int = 0
    rotation: float = 0.0
    ratio: float = 1.0

    @classmethod
    def of(cls, data: CameraData) -> Aperture | None:
        """The camera's aperture, or None for a pinhole."""
        if not data.aperture_radius > 0:
            return None
        blades = data.blades if data.blades >= 3 else 0
        radius, rotation, ratio = data.aperture_radius, data.blade_rotation, data.aperture_ratio
        return cls(float(radius), blades, float(rotation), float(ratio))

    @stage("", "depth of field")
    def sample(self, u: Float32) -> Float32:
        """Points of the opening in metres, uniform by area: (2, N) for u (2, N)."""
        if self.blades:
            points = warps.square_to_polygon(u[0], u[1], self.blades, self.rotation)
        else:
            points = warps.square_to_disk(u[0], u[1])
        scale = np.array([[self.radius / self.ratio], [self.radius]], np.float32)
        scaled: Float32 = points * scale
        return scaled
