"""Holdouts: where a camera ray meets one, the film has a hole, with or without a transparent sky."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..core import vectors
from ..core.clock import stage
from ..core.raykind import RayKind
from .arrivals import Arrivals
from .evaluated import evaluated
from .geometry import SKY

if TYPE_CHECKING:
    from ..render.path_state import PathState
    from .scene import Scene
    from .wave import Intersection, Rays


@stage("emission", "holdouts")
def cut_holes(scene: Scene, rays: Rays, found: Intersection, path: PathState) -> None:
    """Take what holdouts hide of the camera rays' throughput off the film's coverage.

    As in Cycles a ray ends where a surface is all holdout, whatever else is added to it; where it is partly
    one the rest of its closures are as they are. To other rays a holdout is black.
    """
    lanes = np.flatnonzero(scene.surface_holds_out.take(found.surface))
    lanes = lanes[(path.kind.take(lanes) & RayKind.CAMERA) != 0]
    if len(lanes) == 0 or scene.alpha is None:
        return
    hit = scene.surface(rays, found, lanes)
    material = scene.geometry.surface_material.take(hit.surface)
    share = evaluated(scene, hit, Arrivals.of(path, lanes), material, "holdout")
    scene.alpha[path.slot.take(lanes)] -= vectors.mean3(share * path.beta.take(lanes, axis=1))
    found.surface[lanes[(share == 1).all(axis=0)]] = SKY  # nothing is there any more
