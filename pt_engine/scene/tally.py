"""Vertices, and the rays that leave them, by material: for the ledger, where a clock runs on the thread."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core import clock
from .geometry import Geometry

Surfaces = NDArray[np.integer]


def vertices(geometry: Geometry, batch: int, surfaces: Surfaces) -> None:
    """Vertices of a batch of materials, on these surfaces (N,)."""
    counting = clock.counting()
    if counting is None or not counting.tells_apart(batch, surfaces.size):
        return
    counts = by_material(geometry, surfaces)
    counting.vertices.update(counts)
    if clock.looks():
        counting.senders.update(counts)


def sent(geometry: Geometry, surfaces: Surfaces, tfar: NDArray[np.float32]) -> None:
    """Rays (N,) that leave vertices on these surfaces, toward lights or onward; those that are on."""
    if (counting := clock.counting()) is not None and clock.looks():
        counting.sent.update(by_material(geometry, surfaces[tfar > 0]))


def by_material(geometry: Geometry, surfaces: Surfaces) -> dict[int, int]:
    """How many of some surfaces each material has."""
    counts = np.bincount(geometry.surface_material.take(surfaces))
    return {int(material): int(counts[material]) for material in np.flatnonzero(counts)}
