"""Which of a few lamps rays may meet: balls around them, tested for every ray."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core.vectors import dot
from .base import Float32, Index, Lamp, columns
from .outline import half_extent

MARGIN = 1e-5  # of its distance from the origin or of the scene: how far a ball reaches beyond its lamp
SLACK = np.float32(1e-5)  # of a squared distance; the test's rounding is a tenth of it


class Balls:
    """Balls around K lamps.

    Parameters
    ----------
    lamps : sequence of Lamp
    size : float
        Of the scene around them.
    """

    def __init__(self, lamps: Sequence[Lamp], size: float) -> None:
        self._centre = columns([lamp.centre for lamp in lamps])
        far = np.maximum(size, np.sqrt((self._centre.astype(np.float64) ** 2).sum(axis=0)))
        radius = np.array([ball_radius(lamp) for lamp in lamps]) + MARGIN * far
        self._radius_squared = np.asarray(radius**2, np.float32)

    def pairs(self, o: Float32, d: Float32, t: Float32) -> tuple[Index, Index]:
        """Lanes and lamps, sorted by lamp, such that lane's ray may meet the lamp, however far.

        A ball is met where |c|² − max(0, c·d)² ≤ r² for the way c to its centre, which is below r² inside.
        """
        near = np.empty((len(self._radius_squared), t.size), np.bool_)
        way = np.empty_like(o)
        for row, centre, radius_squared in zip(near, self._centre.T, self._radius_squared, strict=True):
            np.subtract(centre[:, None], o, out=way)
            along = dot(way, d)
            np.maximum(along, 0, out=along)
            along *= along
            off = dot(way, way)
            off *= 1 - SLACK
            off -= along
            np.less_equal(off, radius_squared, out=row)
        lamp, lane = np.divmod(np.flatnonzero(near), max(t.size, 1))
        return lane, lamp


def ball_radius(lamp: Lamp) -> float:
    """Of a ball around the lamp."""
    half = half_extent(lamp)
    return float(np.sqrt((half**2).sum()) if lamp.data.kind == "AREA" else half[0])
