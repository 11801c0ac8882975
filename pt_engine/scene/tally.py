"""Vertices, and the rays that leave them, by material: for the ledger, where a clock runs on the thread."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core import clock
from .geometry import Geometry

Surfaces = NDArray[np.integer]
EVERY = 8  # which vertices' rays are told apart: to count takes 10 ns, and a part of them tells as well


def vertices(geometry: Geometry, batch: int, surfaces: Surfaces) -> None:
    """Vertices of a batch of materials, on these surfaces (N,)."""
    counting = clock.counting()
    if counting is None or not counting.tells_apart(batch, surfaces.size):
        return
    counting.vertices.update(by_material(geometry, surfaces))


def senders(geometry: Geometry, surfaces: Surfaces) -> None:
    """Vertices of a wave on these surfaces, whose rays are counted, too: some of them."""
    if (looking := clock.looking()) is not None:
        looking.senders.update(by_material(geometry, surfaces[::EVERY]))


def sent(geometry: Geometry, surfaces: Surfaces, tfar: NDArray[np.float32]) -> None:
    """Rays (N,) of a wave that leave vertices on these surfaces, toward lights or onward, if they are on."""
    if (looking := clock.looking()) is not None:
        looking.sent.update(by_material(geometry, surfaces[::EVERY][tfar[::EVERY] > 0]))


def by_material(geometry: Geometry, surfaces: Surfaces) -> dict[int, int]:
    """How many of some surfaces each material has."""
    counts = np.bincount(geometry.surface_material.take(surfaces))
    return {int(material): int(counts[material]) for material in np.flatnonzero(counts)}
