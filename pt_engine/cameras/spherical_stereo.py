"""One eye of a head that turns about its axis: rays start beside the camera, whatever way they look.

A ray along d starts at e = b·(d × up)/|d × up|, b half the distance between the eyes (< 0: the left one), and
meets the ray from the middle at the distance c of convergence:  d' ∝ c d − e.  Toward the poles, where the
head has no sideways, b fades to 0 by a cosine (Cycles' "pole merge").
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import cross, dot, normalize
from ..scene.snapshot import Stereo

Float32 = NDArray[np.float32]


def of_eye(eye: Stereo, d: Float32, up: Float32) -> tuple[Float32, Float32]:
    """Where rays start, from the head's axis, and where they look.

    Parameters
    ----------
    eye : Stereo
    d : (3, N) float32
        Unit directions from the middle.
    up : (3, 1) float32
        The head's axis, in the same coordinates; its opposite where those are left-handed.

    Returns
    -------
    offset, direction : (3, N) float32
    """
    side = cross(d, up)
    length = np.maximum(np.sqrt(dot(side, side)), np.float32(1e-12))
    reach: Float32 = _fade(eye, dot(d, up))
    reach *= np.float32(eye.offset)
    reach /= length
    offset: Float32 = side * reach
    if not np.isfinite(eye.convergence):
        return offset, d
    toward: Float32 = d * np.float32(eye.convergence) - offset
    return offset, normalize(toward)


def _fade(eye: Stereo, sine: Float32) -> Float32:
    """1 at the horizon, 0 at the poles; `sine` is that of the altitude."""
    if eye.merge_to <= 0:
        return np.ones_like(sine)
    altitude = np.arcsin(np.minimum(np.abs(sine), 1))
    part = (altitude - np.float32(eye.merge_from)) / np.float32(max(eye.merge_to - eye.merge_from, 1e-6))
    fade: Float32 = np.cos(np.clip(part, 0, 1) * np.float32(np.pi / 2))
    return fade
