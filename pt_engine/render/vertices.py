"""Where the paths of a wave scatter, those of one group of materials side by side; several waves' as one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from ..scene.wave import Intersection, Rays, intersections_joined, rays_joined
from .path_state import PathState
from .survivors import Spans


class Vertices(NamedTuple):
    """Paths at the surfaces where they scatter.

    Attributes
    ----------
    path : PathState
        Sorted by group.
    rays, found : Rays, Intersection
        How they came there, among others.
    lanes : (N,) intp
        Which of the rays are theirs.
    spans : list of (group, slice)
        In the order of groups.
    """

    path: PathState
    rays: Rays
    found: Intersection
    lanes: NDArray[np.intp]
    spans: Spans

    @property
    def size(self) -> int:
        """How many there are."""
        return self.path.size

    @stage("roulette")
    def compact(self) -> Vertices:
        """The same without the rays of others."""
        rays, found = self.rays.take(self.lanes), self.found.take(self.lanes)
        return Vertices(self.path, rays, found, np.arange(self.size), self.spans)


@stage("roulette")
def vertices_joined(parts: Sequence[Vertices]) -> Vertices:
    """All of some compact parts, sorted by group."""
    if len(parts) == 1:
        return parts[0]
    pieces = sorted(
        ((group, k, span) for k, part in enumerate(parts) for group, span in part.spans),
        key=lambda piece: piece[:2],
    )
    spans: Spans = []
    end = 0
    for group, _, span in pieces:
        start, end = end, end + span.stop - span.start
        if spans and spans[-1][0] == group:
            start = spans.pop()[1].start
        spans.append((group, slice(start, end)))
    return Vertices(
        PathState.joined([parts[k].path.part(span) for _, k, span in pieces]),
        rays_joined([parts[k].rays.part(span) for _, k, span in pieces]),
        intersections_joined([parts[k].found.part(span) for _, k, span in pieces]),
        np.arange(end),
        spans,
    )
