"""The integer hash behind Blender's noises: Bob Jenkins' lookup3 (public domain), and PCG for cells.

The same bits as in Blender, so that a noise pattern is the same pattern.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
UInt32 = NDArray[np.uint32]
Int32 = NDArray[np.int32]

SEED = 0xDEADBEEF + 13
UNIT = np.float32(1 / 0xFFFFFFFF)


def _rotate(x: UInt32, k: int) -> UInt32:
    return (x << np.uint32(k)) | (x >> np.uint32(32 - k))


def _step(x: UInt32, y: UInt32, k: int) -> UInt32:
    """(x ^ y) − (y rotated left by k)."""
    out = x ^ y
    turned = y << np.uint32(k)
    turned |= y >> np.uint32(32 - k)
    out -= turned
    return out


def _final(a: UInt32, b: UInt32, c: UInt32) -> UInt32:
    c = _step(c, b, 14)
    a = _step(a, c, 11)
    b = _step(b, a, 25)
    c = _step(c, b, 16)
    a = _step(a, c, 4)
    b = _step(b, a, 14)
    return _step(c, b, 24)


def _mix(a: UInt32, b: UInt32, c: UInt32) -> tuple[UInt32, UInt32, UInt32]:
    for first, second, third in ((4, 6, 8), (16, 19, 4)):
        a = (a - c) ^ _rotate(c, first)
        c = c + b
        b = (b - a) ^ _rotate(a, second)
        a = a + c
        c = (c - b) ^ _rotate(b, third)
        b = b + a
    return a, b, c


def hash_uints(*keys: UInt32) -> UInt32:
    """Hash of 1 to 4 integers, arrays that broadcast."""
    start = np.uint32((SEED + 4 * len(keys)) & 0xFFFFFFFF)
    parts = [k + start for k in keys[:3]]
    parts += [np.full(1, start, np.uint32)] * (3 - len(parts))
    a, b, c = parts
    if len(keys) == 4:
        a, b, c = _mix(a, b, c)
        a = a + keys[3]
    return _final(a, b, c)


def to_unit(h: UInt32) -> Float32:
    """Integers to [0, 1]."""
    out: Float32 = h.astype(np.float32) * UNIT
    return out


def bits(x: Float32 | float) -> UInt32:
    """The bit pattern of a float."""
    return np.ascontiguousarray(np.atleast_1d(np.asarray(x, np.float32))).view(np.uint32)


def floats_to_float(*p: Float32 | float) -> Float32:
    """A number in [0, 1] from the bits of 1 to 4 floats."""
    return to_unit(hash_uints(*(bits(x) for x in p)))


def floats_to_color(*p: Float32) -> Float32:
    """Three numbers in [0, 1] from the bits of 1 to 4 floats."""
    if len(p) == 4:
        x, y, z, w = p
        orders: tuple[tuple[Float32 | float, ...], ...] = ((x, y, z, w), (z, x, w, y), (w, z, y, x))
    else:
        orders = (p, (*p, 1.0), (*p, 2.0))
    return np.stack(np.broadcast_arrays(*(floats_to_float(*o) for o in orders)))


def _pcg_step(v: list[Int32]) -> None:
    """Mix every component, in turn, with others as they are by then."""
    if len(v) == 2:
        _add_product(v, 0, v[1], np.int32(1664525))
        _add_product(v, 1, v[0], np.int32(1664525))
        return
    turns = ((0, 1, 2), (1, 2, 0), (2, 0, 1)) if len(v) == 3 else ((0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2))
    for k, a, b in turns:
        _add_product(v, k, v[a], v[b])


def _add_product(v: list[Int32], k: int, a: Int32, b: Int32 | np.int32) -> None:
    """v[k] += a·b, in the product's memory where the sum fits."""
    product: Int32 = a * b
    fits = np.broadcast(product, v[k]).shape == product.shape
    v[k] = np.add(product, v[k], out=product if fits else None)


def cell(*keys: Int32) -> list[Float32]:
    """As many numbers in [0, 1] as integers (2 to 4), for the points of Voronoi cells.

    Jarzynski and Olano 2020, "Hash Functions for GPU Rendering", with signed integers as in Blender.
    """
    v = [k * np.int32(1664525) + np.int32(1013904223) for k in keys]
    _pcg_step(v)
    for x in v:
        x ^= x >> np.int32(16)
    _pcg_step(v)
    return [_fraction(x) for x in v]


def _fraction(x: Int32) -> Float32:
    """The low 31 bits as a number in [0, 1]."""
    x &= np.int32(0x7FFFFFFF)
    out = x.astype(np.float32)
    out *= np.float32(1 / 0x7FFFFFFF)
    return out
