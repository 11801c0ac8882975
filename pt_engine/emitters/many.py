"""Of many emitters the sampled one is chosen by where light is asked for (cuts.py); of few by power."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .base import Float32, Float64, Lamp
from .crowd import CROWD, Crowd
from .cuts import LocalChoice
from .faces import Faces
from .met import Accelerate
from .outline import joined, of_lamps
from .parts import LampPart
from .places import NO_BOXES, Bounds, Int32, Places

MANY = 8  # emitters that are somewhere; of fewer each gets a good share of the samples anyway
ENTRIES = 2 << 20  # of all tables of a grid together, about: 40 MiB
LIKELY = 192  # entries of a place's table, usually


def crowd(
    lamps: Sequence[Lamp],
    parts: Sequence[LampPart],
    first: Sequence[int],
    size: float,
    surfaces: Surfaces | None,
) -> Crowd | None:
    """The lamps that rays find through boxes; None where they are few, or overlap in crowds."""
    some = [k for k, part in enumerate(parts) if part.boxed]
    if surfaces is None or sum(parts[k].count for k in some) < CROWD:
        return None
    outlines = of_lamps(lamps, np.zeros(len(lamps)))
    chosen = [parts[k] for k in some], [first[k] for k in some]
    found = Crowd(*chosen, outlines.low, outlines.high, size, surfaces.accel)
    return None if found.boxes.crowded else found


class Surfaces(NamedTuple):
    """What there is to light.

    Attributes
    ----------
    vertices : (V, 3) float32
    triangles : (T, 3) int32
    opaque : bool
        No light comes through them from behind.
    accel : callable
        Makes something to send rays at of vertices and triangles.
    boxes : (low, high), each (B, 3) float64
        Those of instances whose triangles are not among the others.
    """

    vertices: Float32
    triangles: Int32
    opaque: bool
    accel: Accelerate
    boxes: Bounds = NO_BOXES

    @property
    def empty(self) -> bool:
        return not len(self.triangles) and not len(self.boxes[0])


def local_choice(
    lamps: Sequence[Lamp],
    faces: Faces | None,
    power: Float64,
    chance: Float64,
    scene_radius: float,
    surfaces: Surfaces | None,
) -> LocalChoice | None:
    """The choice by place; None where power is all that matters. Numbers: lamps, faces, the world."""
    of_faces = len(faces.power) if faces is not None else 0
    near = np.array([k for k, lamp in enumerate(lamps) if lamp.data.kind != "SUN"], np.intp)
    numbers = np.concatenate([near, len(lamps) + np.arange(of_faces)])
    numbers = numbers[power[numbers] > 0.0]
    if len(numbers) < MANY or surfaces is None or surfaces.empty:
        return None
    outlines = of_lamps([lamps[k] for k in near], power[near])
    if faces is not None:
        outlines = joined(outlines, faces.outlines())
    outlines = outlines.take(np.flatnonzero(outlines.intensity > 0.0))
    far = np.setdiff1d(np.arange(len(power)), [*near, *(len(lamps) + np.arange(of_faces))])
    irradiance = power[far] / (np.pi * scene_radius**2)
    irradiance[far >= len(lamps)] *= 0.25  # the world's power counts what comes from all around
    bounds = outlines.low.min(axis=0), outlines.high.max(axis=0)
    limit = ENTRIES // LIKELY
    places = Places(surfaces.vertices, surfaces.triangles, limit, surfaces.opaque, bounds, surfaces.boxes)
    return LocalChoice(places, outlines, numbers, far, chance, irradiance)
