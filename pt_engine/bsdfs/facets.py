"""GGX facets about any unit normal m: for surfaces whose normal is not their frame's.

With z = w·m, α the roughness and t(w) = √(z² + α²(1 − z²)) as in `microfacet`. Half vectors may have any
length, D(h/|h|)/|h|⁴ = α²/π (α²(h·m)² + |h × m|²)⁻²: the cross product keeps its digits where a narrow lobe's
1 − (h·m)² has none.
"""

from __future__ import annotations

import numpy as np

from ..core import frames
from ..core.vectors import cross, dot, normalize
from .base import Float32
from .microfacet import INV_PI, PI, TINY


def stretched(z: Float32, a2: Float32) -> Float32:
    """t of a direction at cosine z: (N,)."""
    t: Float32 = np.sqrt(z * z + a2 * np.maximum(1.0 - z * z, 0.0))
    return t


def density(m: Float32, h: Float32, a2: Float32) -> Float32:
    """D(h/|h|)/|h|⁴: (N,)."""
    along, across = dot(m, h), cross(m, h)
    e = a2 * (along * along) + dot(across, across)
    d: Float32 = (INV_PI * a2) / (e * e + TINY)
    return d


def visible_normal(w: Float32, m: Float32, z: Float32, alpha: Float32, u1: Float32, u2: Float32) -> Float32:
    """A facet's unit normal (3, N), drawn from those about m that w sees: see `microfacet.GGX`."""
    side = alpha * (w - z * m)
    length: Float32 = np.sqrt(dot(side, side) + z * z + TINY)
    inverse = np.reciprocal(length)
    above = 1.0 + z * inverse
    q = u2 * above
    sine: Float32 = np.sqrt(np.maximum(q * (2.0 - q), 0.0))
    phi = u1 * np.float32(2.0 * PI)
    s, t = frames.frame(m)
    toward = (sine * np.cos(phi)) * s + (sine * np.sin(phi)) * t + inverse * side
    h: Float32 = (above - q) * m
    h += alpha * toward
    return normalize(h)
