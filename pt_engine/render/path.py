"""Path tracing with next-event estimation, MIS and Russian roulette (the lecture's Ver 0.8 and 1.0)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.scene import Scene
from ..scene.wave import Rays
from .dimensions import LaneSampler
from .integrator import Integrator
from .next_event import next_event
from .schedule import WAVES
from .survivors import Wavefront
from .vertices import Vertices
from .waves import Waves

Float32 = NDArray[np.float32]


class PathActive(Integrator):
    """Paths of up to `max_depth` edges; those that have ended leave the batch (Ver 0.8)."""

    name = "path_active"
    label = "Path, Active Lanes"
    description = "Paths of fixed depth; those that have ended leave the batch"
    combines = True
    waves = WAVES
    roulette = False

    def sample(self, scene: Scene, rays: Rays, sampler: LaneSampler) -> Float32:
        # Loop state, one column per living path: β throughput 1, L radiance 0, pdf ∞ (Dirac)
        waves = Waves(scene, rays, sampler, self)
        front = Wavefront(self, scene, waves.size)  # keeps L of paths that have ended

        edges = range(self.max_depth + scene.transparent_surfaces * self.transparent_depth)
        for bounce, path, rays in waves.along(edges):
            found = scene.intersect(rays)

            # ------------------------- emission: what the last direction has run into
            for hit in scene.emission(rays, found, path):
                path.gather(hit)

            # ------------------------- the paths that go on, those of one material side by side
            path, lanes, spans = front.survivors(path, found)
            for at in waves.together(Vertices(path, rays, found, lanes, spans)):
                path, si = at.path, scene.surface(at.rays, at.found, at.lanes)
                bsdf, random = scene.shade(si, path, at.spans), path.sampler(sampler)

                # ------------------------- emitter sampling: next-event estimation
                next_event(scene, path, si, bsdf, random.emitter(bounce), self)

                # ------------------------- BSDF sampling: the next direction
                scattered = bsdf.sample(random.bsdf(bounce))

                # ------------------------- Russian roulette: unbiased, so cheap paths may end early
                u = random.roulette(bounce) if self.roulette and bounce >= self.rr_depth - 2 else None
                waves.go_on(path, front.advance(path, si, scattered, u))
        return front.finish(*waves.left())


class Path(PathActive):
    """The whole estimator: the same loop, and roulette ends paths of little throughput early (Ver 1.0)."""

    name = "path"
    label = "Path Tracing"
    description = "Next-event estimation, multiple importance sampling and Russian roulette"
    roulette = True
