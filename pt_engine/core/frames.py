"""Local frames: +Z along a normal, tangents without a branch.

Duff et al. 2017, "Building an Orthonormal Basis, Revisited" (JCGT 6(1)): with σ = sign(n_z) and
a = −1/(σ + n_z),

    s = (1 + σ a n_x², σ a n_x n_y, −σ n_x)        t = (a n_x n_y, σ + a n_y², −n_y)

which is continuous but for the equator and orthonormal to rounding, for n_z = −1 too.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .vectors import cross, dot

Float32 = NDArray[np.float32]


def frame(n: Float32) -> tuple[Float32, Float32]:
    """Two tangents s, t (3, N) that with the unit normals n (3, N) make a right-handed frame (s × t = n)."""
    x, y, z = n
    sign = np.copysign(np.float32(1.0), z)
    a = -1.0 / (sign + z)
    b = x * y * a
    s, t = np.empty(n.shape, n.dtype), np.empty(n.shape, n.dtype)
    np.add(1.0, sign * x * x * a, out=s[0])
    np.multiply(sign, b, out=s[1])
    np.multiply(-sign, x, out=s[2])
    t[0] = b
    np.add(sign, y * y * a, out=t[1])
    np.negative(y, out=t[2])
    return s, t


def from_tangent(n: Float32, tangent: Float32) -> tuple[Float32, Float32]:
    """s, t (3, N) with s along `tangent` made orthogonal to n; `frame(n)` where the two are parallel."""
    s = tangent - dot(tangent, n) * n
    squared = dot(s, s)
    usable = (squared > 1e-12).astype(np.float32)
    fallback, _ = frame(n)
    s = s * (usable / np.sqrt(squared + (1 - usable))) + fallback * (1 - usable)
    return s, cross(n, s)


def to_local(s: Float32, t: Float32, n: Float32, w: Float32) -> Float32:
    """World direction w (3, N) in the frame: (w·s, w·t, w·n)."""
    local = np.empty(w.shape, w.dtype)
    for row, axis in zip(local, (s, t, n), strict=True):
        dot(w, axis, out=row)
    return local


def to_world(s: Float32, t: Float32, n: Float32, w: Float32) -> Float32:
    """Local direction w (3, N) in world space: w_x s + w_y t + w_z n."""
    world: Float32 = w[0] * s + w[1] * t + w[2] * n
    return world
