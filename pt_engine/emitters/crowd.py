"""Lamps with a size, met by rays: candidates from boxes (met.py) or balls, then each sort's exact test."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .balls import Balls
from .base import Float32, Hits, Index
from .met import Boxes
from .parts import LampPart


class Met(NamedTuple):
    """What some lanes, all different, have met: the lamps' numbers (k,), and `Hits`."""

    number: Index
    hits: Hits


def lamp_numbers(parts: Sequence[LampPart], first: Sequence[int]) -> Index:
    """Of the lamps of some parts, each of which begins at `first`."""
    return np.concatenate([start + np.arange(part.count) for part, start in zip(parts, first, strict=True)])


class Crowd:
    """All lamps that are `boxed`.

    Parameters
    ----------
    parts : sequence of LampPart
    first : sequence of int
        The number of each part's first lamp.
    around : Boxes or Balls
        Of these lamps, in their order.
    """

    def __init__(self, parts: Sequence[LampPart], first: Sequence[int], around: Boxes | Balls) -> None:
        self._parts = list(zip(parts, first, strict=True))
        self._numbers = lamp_numbers(parts, first)
        self._around = around
        self._met_by = {
            of_camera: np.concatenate(
                [np.isin(np.arange(p.count), p.rows(of_camera)) for p, _ in self._parts]
            )
            for of_camera in (False, True)
        }

    def hits(self, o: Float32, d: Float32, t: Float32, of_camera: bool) -> Iterator[Met]:
        """What camera rays, or all others, meet; a lane's first lamp comes first, then the second ones."""
        lanes, lamps = self._around.pairs(o, d, t)
        seen = np.flatnonzero(self._met_by[of_camera].take(lamps))
        lanes, numbers = lanes.take(seen), self._numbers.take(lamps.take(seen))
        found = [self._tested(part, first, lanes, numbers, (o, d, t)) for part, first in self._parts]
        lane = np.concatenate([met.hits.lanes for met in found])
        order = np.argsort(lane, kind="stable")
        lane = lane.take(order)
        number = np.concatenate([met.number for met in found]).take(order)
        radiance = np.concatenate([met.hits.radiance for met in found], axis=1).take(order, axis=1)
        pdf = np.concatenate([met.hits.pdf for met in found]).take(order)
        rank = np.arange(len(lane)) - np.searchsorted(lane, lane)
        for k in range(int(np.max(rank)) + 1 if len(rank) else 0):
            nth = np.flatnonzero(rank == k)
            hits = Hits(lane.take(nth), radiance.take(nth, axis=1), pdf.take(nth))
            yield Met(number.take(nth), hits)

    def _tested(
        self, part: LampPart, first: int, lanes: Index, numbers: Index, rays: tuple[Float32, Float32, Float32]
    ) -> Met:
        """The pairs of a part that do meet."""
        own = np.flatnonzero((numbers >= first) & (numbers < first + part.count))
        lanes, number = lanes.take(own), numbers.take(own)
        o, d, t = (a.take(lanes, axis=-1) for a in rays)
        hits = part.kind.hits(number - first, o, d, t)
        return Met(number.take(hits.lanes), hits._replace(lanes=lanes.take(hits.lanes)))
