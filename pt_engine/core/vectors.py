"""Arithmetic of batches of vectors: (3, N) float32, component first.

Every function works lane by lane in a fixed order of operations, so a lane's result never depends on
where in a batch it stands or how large the batch is.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]

TINY = float(np.finfo(np.float32).tiny)
SIGN = np.int32(np.iinfo(np.int32).min)  # the highest bit alone


def dot(a: Float32, b: Float32, out: Float32 | None = None) -> Float32:
    """a·b: (N,), in `out` if that is given. Either may be (3, 1)."""
    total: Float32 = np.multiply(a[0], b[0], out=out)
    total += a[1] * b[1]
    total += a[2] * b[2]
    return total


def cross(a: Float32, b: Float32) -> Float32:
    """a × b: (3, N). Nearly parallel vectors cancel; `difference_of_products` does not."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def length(a: Float32) -> Float32:
    """|a|: (N,). Squares underflow below 1e-19 and overflow above 1e19."""
    return np.sqrt(dot(a, a))


def normalize(a: Float32) -> Float32:
    """a / |a|: (3, N); a vector too short to have a direction (|a| < 1e-19) stays as short as it is."""
    squared = dot(a, a)
    inverse: Float32 = np.reciprocal(np.sqrt(squared + (squared < TINY)))
    unit: Float32 = a * inverse
    return unit


def reflect(w: Float32, n: Float32) -> Float32:
    """Mirror w about n, both away from the surface: 2 (w·n) n − w."""
    return (2.0 * dot(w, n)) * n - w


def difference_of_products(a: Float32, b: Float32, c: Float32, d: Float32) -> Float32:
    """a b − c d, correctly rounded: float32 products are exact in float64, so nothing cancels."""
    result: Float64 = np.multiply(a, b, dtype=np.float64)
    result -= np.multiply(c, d, dtype=np.float64)
    return result.astype(np.float32)


def mean3(a: Float32) -> Float32:
    """Mean of the three components of (3, N), or the row itself of (1, N): (N,)."""
    if len(a) == 1:
        row: Float32 = a[0]
        return row
    mean: Float32 = (a[0] + a[1] + a[2]) * np.float32(1 / 3)
    return mean


def flipped(a: Float32, sign: Float32) -> None:
    """Turn (3, N) vectors round where `sign` (N,) is negative, in place."""
    bits = a.view(np.int32)
    bits ^= sign.view(np.int32) & SIGN


def nonzero3(a: Float32) -> NDArray[np.bool_]:
    """(N,) whether any component of (3, N) is not 0; NaN is not."""
    x, y, z = a.view(np.int32)
    bits = x | y
    bits |= z
    bits <<= 1  # ±0 have no other bit than the sign
    nonzero: NDArray[np.bool_] = bits != 0
    return nonzero


def max3(a: Float32) -> Float32:
    """Largest of the three components of (3, N): (N,)."""
    largest: Float32 = np.maximum(a[0], a[1])
    np.maximum(largest, a[2], out=largest)
    return largest
