"""The paths of many camera rays on their way: in waves of a size that suits memory, joined as they shrink.

After some bounces few paths of a wave are left, and what Python and numpy ask for each call weighs more than
the paths themselves; and while they ask, the other threads wait. So a unit of work is several waves that go
from bounce to bounce in step. Those that together are no larger than one fly on as one, and where so many
rays have left the scene that at most half a wave scatters, it waits for others to scatter with.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ..core.clock import before_bounce
from ..scene.scene import Scene
from ..scene.wave import Rays, rays_joined
from .dimensions import LaneSampler
from .integrator import Integrator
from .path_state import PathState
from .vertices import Vertices, vertices_joined

Wave = tuple[PathState, Rays]


class Waves:
    """Paths and their next rays.

    Parameters
    ----------
    scene : Scene
    rays : Rays
        N camera rays.
    sampler : LaneSampler
        The random numbers of these N lanes.
    integrator : Integrator
        For its largest wave, and its clamp.
    """

    def __init__(self, scene: Scene, rays: Rays, sampler: LaneSampler, integrator: Integrator) -> None:
        self._lanes, self._clamp = integrator.lanes, integrator.clamp
        self._now = self._camera_waves(scene, rays, sampler)
        self._next: list[Wave] = []
        self._waiting: list[Vertices] = []
        self._is_last = False  # wave of this bounce
        self.size = rays.tfar.size

    def _camera_waves(self, scene: Scene, rays: Rays, sampler: LaneSampler) -> Iterator[Wave]:
        edges = np.linspace(0, self.size, max(1, -(-self.size // self._lanes)) + 1).astype(int)
        for first, end in pairwise(edges.tolist()):
            span = slice(first, end)
            part = rays.part(span)
            numbers = sampler.with_state(sampler.state[:, span])
            path = PathState.start(numbers, scene.tracks_history, scene.history(part), self._clamp)
            slot = path.slot
            slot += first
            self._is_last = end == self.size
            yield path, part

    def along(self, bounces: range) -> Iterator[tuple[int, PathState, Rays]]:
        """One wave after the other, first all that have made no bounce, then those that have made one ..."""
        for bounce in bounces:
            for path, rays in self._now:
                before_bounce(bounce)
                yield bounce, path, rays
            self._now, self._next = self._joined(self._next), []

    def together(self, arrived: Vertices) -> Iterator[Vertices]:
        """What of the wave that has arrived, and of those before it, scatters now; the rest waits."""
        has_company = bool(self._waiting) or not self._is_last
        if has_company and 0 < 2 * arrived.size <= self._lanes:
            if arrived.size + sum(each.size for each in self._waiting) > self._lanes:
                yield self._gathered()
            self._waiting.append(arrived.compact())
        elif arrived.size:
            yield arrived
        if self._waiting and self._is_last:
            yield self._gathered()

    def _gathered(self) -> Vertices:
        """All that wait, as one."""
        waiting, self._waiting = self._waiting, []
        return vertices_joined(waiting)

    def go_on(self, path: PathState, rays: Rays) -> None:
        """Let a wave that has scattered go on to the next bounce."""
        self._next.append((path, rays))

    def _joined(self, waves: list[Wave]) -> Iterator[Wave]:
        """Neighbours as one where they fit; each is forgotten when it is handed out."""
        while waves:
            count, size = 1, waves[0][0].size
            while count < len(waves) and size + waves[count][0].size <= self._lanes:
                size += waves[count][0].size
                count += 1
            self._is_last = count == len(waves)
            if count == 1:
                yield waves.pop(0)
                continue
            paths, rays = zip(*waves[:count], strict=True)
            del waves[:count]
            yield PathState.joined(paths), rays_joined(rays)

    def left(self) -> list[PathState]:
        """The paths that nobody has ended."""
        return [path for path, _ in self._now]
