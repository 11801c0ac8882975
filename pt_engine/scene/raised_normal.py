"""Shading normals that let a mirror direction leave the true surface (Cycles' valid specular reflection).

An interpolated or bumped normal n may send the mirror direction R = 2 (n·wi) n − wi below the surface. n is
then turned toward the true normal ng, within the plane of both, until R stands just above it:

    R'·ng = t = min(0.9 wi·ng, 0.01)        4 a z⁴ − 2 b z² + c = 0,    z = n'·ng
    a = x² + y²,  b = 2 (a + y t),  c = (y + t)²,     y = wi·ng,  x = wi along n's part across ng
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import dot

Float32 = NDArray[np.float32]


def raised_normal(ng: Float32, wi: Float32, n: Float32) -> Float32:
    """(3, N) unit normals: n itself wherever its mirror direction is above the surface."""
    up = dot(wi, ng)
    limit = np.minimum(np.float32(0.9) * up, np.float32(0.01))
    mirrored = 2 * dot(n, wi) * dot(n, ng) - up
    low = np.flatnonzero((mirrored < limit) & (up > 0))
    if len(low) == 0:
        return n
    raised = n.copy()
    low_ng, low_wi, low_n = (v.take(low, axis=1) for v in (ng, wi, n))
    raised[:, low] = _raised(low_ng, low_wi, low_n, up.take(low), limit.take(low))
    return raised


def _raised(ng: Float32, wi: Float32, n: Float32, y: Float32, t: Float32) -> Float32:
    across = n - dot(n, ng) * ng
    length = np.sqrt(dot(across, across))
    across /= np.maximum(length, np.float32(1e-20))
    x = dot(wi, across)
    a = x * x + y * y
    b = 2 * (a + y * t)
    c = (y + t) ** 2
    root = np.copysign(np.sqrt(np.maximum(b * b - 4 * a * c, 0)), -x)
    z2 = np.clip(np.float32(0.25) * (b + root) / np.maximum(a, np.float32(1e-30)), 0, 1)
    z2 = np.where(length > 0, z2, np.float32(1))
    raised: Float32 = np.sqrt(1 - z2) * across + np.sqrt(z2) * ng
    return raised
