"""Lanes a small step along their faces, for Bump's differences of height."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import vectors

if TYPE_CHECKING:
    from .lanes import Lanes

Float32 = NDArray[np.float32]

LONGEST = np.float32(1e6)
DIAGONAL: Float32 = np.array([[0.5**0.5], [-(0.5**0.5)], [0]], np.float32)


def steps(lanes: Lanes, width: float) -> tuple[Float32, Float32]:
    """Two steps (3, n) along the face, `width` of the ray's, that with `ng` are a right-handed frame."""
    a, b = tangents(lanes.ng)
    length = np.float32(width) * np.minimum(lanes.footprint, LONGEST)
    return a * length, b * length


def tangents(n: Float32) -> tuple[Float32, Float32]:
    """Two unit tangents (3, n) that with unit normals are Cycles' frame: the first along (1, 1, 1) × n."""
    a: Float32 = np.stack([n[2] - n[1], n[0] - n[2], n[1] - n[0]])
    size = vectors.length(a)
    poor = (size < 1e-3).astype(np.float32)
    a = a * ((1 - poor) / (size + poor)) + poor * DIAGONAL
    return a, vectors.cross(n, a)


def across(lanes: Lanes, step: Float32) -> tuple[Float32, Float32]:
    """What a world-space step in the triangles' planes adds to the barycentrics, (n,) each.

    du e1 + dv e2 = step in object space, so du = (step × e2)·n / n² and dv = (e1 × step)·n / n² with
    n = e1 × e2. On back faces du and dv have the other sign, though the position has not: so it is in Cycles,
    which turns e1 and e2 around there, and a bump of attributes looks the other way.
    """
    _, e1, e2 = lanes.faces.spans("position")
    n, scale = lanes.faces.plane
    inside = lanes.to_object_vector(step)
    du = vectors.dot(vectors.cross(inside, e2), n) * scale
    return du, vectors.dot(vectors.cross(e1, inside), n) * scale


def moved(lanes: Lanes, step: Float32) -> Lanes:
    """The lanes with positions and barycentrics changed by a world-space step in their triangles' planes."""
    si = lanes.si
    du, dv = across(lanes, step)
    there = copy.copy(si)
    there.p = si.p + step
    there.moved_uv = (si.u + du, si.v + dv)
    out = copy.copy(lanes)
    for name in ("ns", "_raised_ns"):
        out.__dict__.pop(name, None)
    out.si, out.p = there, there.p
    return out
