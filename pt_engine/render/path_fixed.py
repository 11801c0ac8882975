"""Path tracing with fixed depth (the lecture's Ver 0.7): every path walks on to the last edge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.rows import scatter
from ..scene import tally
from ..scene.scene import Scene
from ..scene.wave import Rays
from .dimensions import LaneSampler
from .integrator import Integrator
from .next_event import next_event
from .path_state import PathState
from .survivors import sorted_by_batch

Float32 = NDArray[np.float32]


class PathFixed(Integrator):
    """Throughput β and a fixed number of bounces; ended paths ride along with β = 0."""

    name = "path_fixed"
    label = "Path, Fixed Depth"
    description = "Every path has max_depth edges; nothing leaves the batch"
    combines = True

    def sample(self, scene: Scene, rays: Rays, sampler: LaneSampler) -> Float32:
        path = PathState.start(sampler, scene.tracks_history, scene.history(rays), self.clamp)
        edges = self.max_depth + scene.transparent_surfaces * self.transparent_depth
        for bounce in range(edges):
            found = scene.intersect(rays)
            for hit in scene.emission(rays, found, path):
                path.gather(hit)
            order, spans = sorted_by_batch(scene.batch(found), scene.dead)
            if not spans or bounce == edges - 1:
                break
            alive = spans[-1][1].stop
            path, si = path.take(order), scene.surface(rays, found, order[:alive])
            here = path.part(slice(0, alive))
            bsdf, random = scene.shade(si, here, spans), here.sampler(sampler)
            next_event(scene, here, si, bsdf, random.emitter(bounce), self)
            rays = here.go_on(scene, si, bsdf.sample(random.bsdf(bounce)), self.max_depth)
            tally.sent(scene.geometry, si.surface, rays.tfar)
            rays = path.ride_along(here, rays)
        radiance = np.empty((3, path.size), np.float32)
        scatter(radiance, path.slot, path.L)
        return radiance
