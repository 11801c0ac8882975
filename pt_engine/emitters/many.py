"""Of many emitters the sampled one is chosen by where light is asked for (cuts.py); of few by power."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .balls import Balls
from .base import Float32, Float64, Lamp
from .crowd import Crowd, lamp_numbers
from .cuts import LocalChoice
from .faces import Faces
from .met import Accelerate, Boxes
from .outline import joined, of_lamps
from .parts import LampPart
from .places import NO_BOXES, Bounds, Int32, Places

CROWD = 16  # lamps with a size; of fewer each is tested for every ray
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
    """What rays find through boxes or balls; None where none has a size, or they overlap in crowds."""
    some = [k for k, part in enumerate(parts) if part.boxed]
    chosen = [parts[k] for k in some], [first[k] for k in some]
    if not some:
        return None
    which = lamp_numbers(*chosen)
    if len(which) < CROWD:
        return Crowd(*chosen, Balls([lamps[k] for k in which], size))
    if surfaces is None:
        return None
    outlines = of_lamps(lamps, np.zeros(len(lamps)))
    boxes = Boxes(outlines.low[which], outlines.high[which], size, surfaces.accel)
    return None if boxes.crowded else Crowd(*chosen, boxes)


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
