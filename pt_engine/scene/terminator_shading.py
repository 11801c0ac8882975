"""Light that fades before the shadow terminator: the angle to the normal counts more than it is.

    factor = max(0, cos fθ) / cos θ        f = 1 / (1 − offset/2), from 1 to 2

As in Cycles (Shadow Terminator Shading Offset), on what closures reflect, about their own normals. Since
0 ≤ θ ≤ π/2 and f ≥ 1, cos fθ ≤ cos θ: the factor lies in [0, 1] and no closure gains energy. White Lambert
under a uniform sky keeps 2 ∫ cos fθ sin θ dθ up to θ = π/(2f), 0.28 with the greatest offset.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .snapshot import Snapshot

Float32 = NDArray[np.float32]
SMALLEST = np.float32(1e-6)


def fade(cos_o: Float32, factor: Float32) -> Float32:
    """(N,) factor on a closure's value toward directions at `cos_o` to its normal; 1 below the surface."""
    cosine = np.clip(cos_o, SMALLEST, 1)
    more = np.arccos(cosine) * (factor - 1)
    tangent = np.sqrt(1 - cosine * cosine) / cosine
    left = np.cos(more) - tangent * np.sin(more)  # cos fθ / cos θ, exact where f is 1
    faded: Float32 = np.where(cos_o >= 0, np.maximum(left, 0), np.float32(1))
    return faded


def angles_of(snapshot: Snapshot) -> Float32 | None:
    """(I,) f of each instance; None where all are 1."""
    offset = snapshot.instances.shading_offset
    if offset is None or not (offset > 0).any():
        return None
    return np.reciprocal(1 - 0.5 * np.clip(offset, 0, 1)).astype(np.float32)
