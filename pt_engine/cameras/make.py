"""The camera of a snapshot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.snapshot import CameraData
from .base import Camera
from .orthographic import Orthographic
from .panoramic import Panoramic
from .perspective import Perspective

CAMERAS: dict[str, type[Camera]] = {"PERSP": Perspective, "ORTHO": Orthographic, "PANO": Panoramic}


def make_camera(
    data: CameraData, origin: NDArray[np.float64], resolution: tuple[float, float] = (1.0, 1.0)
) -> Camera:
    """Camera for `data`, relative to the scene's origin (3,), for rasters of this resolution.

    A kind that is not understood becomes a perspective camera of the same frame; saying so is up to the
    caller, who keeps the list of what is approximate.
    """
    return CAMERAS.get(data.kind, Perspective)(data, origin, resolution)
