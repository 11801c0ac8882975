"""A portal: light leaves elsewhere, in a given direction, as if it had passed through a hole in space.

f ∝ δ(wo − direction), at `position` instead of the point that was hit. Its colour is the closure's weight,
and its frame the world's, so that directions need no turning (see `nodes.ray_portal`). Whoever samples it
moves the hit point, by `scene.lanes.Surface.relocate`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .base import BSDFSample, Float32, Lobe
from .transparent import albedo, eval_pdf

__all__ = ["LEADS_AWAY", "Params", "albedo", "eval_pdf", "sample"]

LEADS_AWAY = True


class Params(NamedTuple):
    """
    Attributes
    ----------
    direction : (3, N) float32
        Unit, world space.
    position : (3, N) float32 or None
        True world position; the hit point where None.
    """

    direction: Float32
    position: Float32 | None = None


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """wo = direction, certainly."""
    n = wi.shape[1]
    lobe = Lobe.DELTA | Lobe.TRANSMIT | Lobe.TRANSPARENT | Lobe.PORTAL
    wo = np.broadcast_to(params.direction, (3, n))
    return BSDFSample(wo, np.ones(n, np.float32), np.ones((1, n), np.float32), lobe)
