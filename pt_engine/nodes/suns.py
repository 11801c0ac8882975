"""Where in the sky the suns of a world's sky textures stand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .probe import ProbeLanes
from .program import ConstantTable, Entry, linearise
from .sky_nodes import SunDisc

Float64 = NDArray[np.float64]
TOLERANCE = 1e-4  # of a direction's components


class Sun(NamedTuple):
    """A disc in the sky: unit direction of its centre (3,), and half its angle in radians."""

    toward: Float64
    half_angle: float


def find_suns(discs: Sequence[SunDisc]) -> tuple[Sun, ...] | None:
    """The suns, each once; None where one cannot be told.

    A sky texture's vector is the ray's direction, turned by mappings: a matrix, which its values at the three
    axes are. Where a fourth direction does not agree, or the matrix is no rotation, its sun may be anywhere
    and of any shape.
    """
    if not discs:
        return ()
    structure, constants = linearise([disc.direction for disc in discs])
    entry = Entry(structure, ConstantTable([constants], [0]), range(len(discs)))
    tried = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.48, -0.6, 0.64]], np.float32).T
    lanes = ProbeLanes(np.zeros(4, np.int32), np.ascontiguousarray(tried))
    with np.errstate(all="ignore"):
        values = entry.run(lanes)
    suns: list[Sun] = []
    for value, disc in zip(values, discs, strict=True):
        matrix = np.broadcast_to(value, (3, 4)).astype(np.float64)
        turned, check = matrix[:, :3], matrix[:, 3]
        rotates = np.abs((turned[:, :, None] * turned[:, None]).sum(axis=0) - np.eye(3)).max() < TOLERANCE
        if not rotates or np.abs((turned * tried[:, 3]).sum(axis=1) - check).max() > TOLERANCE:
            return None
        toward = (turned * disc.sky.toward_sun[:, None]).sum(axis=0)
        sun = Sun(toward / np.sqrt((toward * toward).sum()), disc.sky.half_angle)
        if not any(same(sun, other) for other in suns):
            suns.append(sun)
    return tuple(suns)


def same(a: Sun, b: Sun) -> bool:
    """One disc, drawn by two nodes."""
    return a.half_angle == b.half_angle and float(np.abs(a.toward - b.toward).max()) < 1e-6
