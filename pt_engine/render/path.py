"""Path tracing with next-event estimation, MIS and Russian roulette (the lecture's Ver 0.8 and 1.0)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.lanes import Surface
from ..scene.scene import Rays, Scene
from ..scene.shading import ShadedBSDF
from .dimensions import LaneSampler
from .integrator import Integrator
from .path_state import PathState, mis
from .survivors import Wavefront

Float32 = NDArray[np.float32]


class Path(Integrator):
    """The whole estimator: paths of up to `max_depth` edges, ended early by roulette."""

    name = "path"
    label = "Path Tracing"
    description = "Next-event estimation, multiple importance sampling and Russian roulette"
    roulette = True

    def sample(self, scene: Scene, rays: Rays, sampler: LaneSampler) -> Float32:
        # Loop state, one column per living path:
        path = PathState.start(sampler, scene.tracks_history)  # β throughput 1, L radiance 0, pdf ∞ (Dirac)
        front = Wavefront(self, scene, path.size)  # keeps L of paths that have ended

        for bounce in range(self.max_depth + scene.transparent_surfaces * self.transparent_depth):
            found = scene.intersect(rays)

            # ------------------------- emission: what the last direction has run into
            for light in scene.emission(rays, found, path):
                path.gather(light)

            # ------------------------- the paths that go on, those of one material side by side
            path, lanes, spans = front.survivors(path, found)
            if path.size == 0:
                break
            si = scene.surface(rays, found, lanes)
            bsdf, random = scene.shade(si, path, spans), path.sampler(sampler)

            # ------------------------- emitter sampling: next-event estimation
            next_event(scene, path, si, bsdf, random.emitter(bounce), self)

            # ------------------------- BSDF sampling: the next direction
            scattered = bsdf.sample(random.bsdf(bounce))

            # ------------------------- Russian roulette: unbiased, so cheap paths may end early
            u = random.roulette(bounce) if self.roulette and bounce >= self.rr_depth - 2 else None
            rays = front.advance(path, si, scattered, u)
        return front.finish(path)


class PathActive(Path):
    """The same loop with batches of active paths but no roulette (Ver 0.8)."""

    name = "path_active"
    label = "Path, Active Lanes"
    description = "Paths of fixed depth; those that have ended leave the batch"
    roulette = False


def next_event(
    scene: Scene, path: PathState, si: Surface, bsdf: ShadedBSDF, u: Float32, limit: Integrator
) -> None:
    """L += β · f·cosθ · Le/pdf · mis · visibility, with one emitter sample per path.

    Only the lanes [0, m) whose BSDF has more than Dirac lobes take part; the others could never
    reach a sampled emitter (f ∝ δ needs p ∝ δ).
    """
    m = bsdf.smooth_count
    if m == 0 or not scene.has_emitters:
        return
    here, paths = si.part(slice(0, m)), path.part(slice(0, m))
    light = scene.sample_emitter(here, u[:, :m])
    value, pdf = bsdf.eval_pdf(light.wo)
    weight = mis(light.pdf, pdf * np.logical_not(light.delta))
    contribution = value * light.weight
    contribution *= paths.beta
    contribution *= weight
    if scene.transparent_surfaces:  # paths on their last edge may pass such a surface but not scatter
        contribution *= paths.depth < limit.max_depth - 1
    paths.L += scene.unoccluded(here, light, contribution, limit.transparent_depth)
