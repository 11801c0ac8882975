"""What materials' programs give at hits of any materials: emission, or the share that is a holdout."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from .arrivals import Arrivals
from .lanes import Lanes
from .surface import Surface

if TYPE_CHECKING:
    from .scene import Scene

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


@stage("", "emission that varies")
def evaluated(scene: Scene, hit: Surface, came: Arrivals, material: Int32, what: str = "emission") -> Float32:
    """(3, K) what the materials' programs give for `emission` or `holdout`."""
    radiance = np.zeros((3, hit.size), np.float32)
    smooth = scene.geometry.surface_smooth.take(hit.surface)
    key = scene.materials.batch_of.take(material) * 2 + smooth
    for k in np.unique(key):
        lanes = np.flatnonzero(key == k)
        here = Lanes(scene, hit.take(lanes), came.take(lanes), bool(k & 1))
        value = getattr(scene.materials.batches[int(k) >> 1], what)(here)
        if value is not None:
            radiance[:, lanes] = value
    return radiance
