"""Direct illumination three ways (the lecture's Ver 0.3 to 0.6).

    L(p₁, ω₁₀) = Le + ∫ Le,₂₁ f(ω₁₂, ω₁₀) |n·ω₁₂| dω₁₂

One bounce, estimated from BSDF samples, from emitter samples, or from both with the power heuristic.
Dirac deltas need no special case: a Dirac direction carries the density ∞, an emitter that no ray can
hit has `light.mis` 0. What one strategy cannot see stays black, as on the slides: point lights with
BSDF sampling, ideal mirrors with emitter sampling.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.rows import scatter_add
from ..scene.scene import Scene
from ..scene.shading import ShadedBSDF
from ..scene.surface import Surface
from ..scene.wave import Rays
from .dimensions import LaneSampler
from .integrator import Integrator
from .path_state import PathState, mis
from .survivors import sorted_by_batch

Float32 = NDArray[np.float32]


class Direct(Integrator):
    """What the three have in common: emission at p₁, then one bounce."""

    def sample(self, scene: Scene, rays: Rays, sampler: LaneSampler) -> Float32:
        path = PathState.start(sampler, scene.tracks_history, scene.history(rays), self.clamp)
        found = scene.intersect(rays)
        for hit in scene.emission(rays, found, path):
            path.gather(hit)
        radiance = path.L.copy()

        order, spans = sorted_by_batch(scene.batch(found), scene.dead)
        if not spans:
            return radiance
        lit = order[: spans[-1][1].stop]
        path, si = path.take(lit), scene.surface(rays, found, lit)
        bsdf = scene.shade(si, path, spans)
        path.L[:] = 0
        self.reflected(scene, path, si, bsdf, path.sampler(sampler))
        scatter_add(radiance, path.slot, path.L)
        return radiance

    def reflected(
        self, scene: Scene, path: PathState, si: Surface, bsdf: ShadedBSDF, random: LaneSampler
    ) -> None:
        """Add one estimate of the reflected integral to `path.L`."""
        raise NotImplementedError


class DirectBSDF(Direct):
    """L̂ = f·cosθ · Le / p_B."""

    name = "direct_bsdf"
    label = "Direct, BSDF Sampling"
    description = "One bounce toward a direction drawn from the BSDF; cannot see point lights"

    def reflected(
        self, scene: Scene, path: PathState, si: Surface, bsdf: ShadedBSDF, random: LaneSampler
    ) -> None:
        rays = path.scatter(si, bsdf.sample(random.bsdf(0)))
        for hit in scene.emission(rays, scene.intersect(rays), path):
            light = path.beta.take(hit.lanes, axis=1) * hit.radiance
            scatter_add(path.L, hit.lanes, path.clamped(light, hit.lanes))


class DirectEmitter(Direct):
    """L̂ = f·cosθ · Le · V / p_E."""

    name = "direct_emitter"
    label = "Direct, Emitter Sampling"
    description = "One bounce toward a point drawn on an emitter; cannot see lights in ideal mirrors"

    def reflected(
        self, scene: Scene, path: PathState, si: Surface, bsdf: ShadedBSDF, random: LaneSampler
    ) -> None:
        m = bsdf.smooth_count
        if m == 0 or not scene.has_emitters:
            return
        here, paths = si.part(slice(0, m)), path.part(slice(0, m))
        light = scene.sample_emitter(here, random.emitter(0)[:, :m], path)
        value, _ = bsdf.eval_pdf(light.wo, light.hidden)
        lit = scene.unoccluded(here, light, value * light.weight, self.transparent_depth, paths)
        paths.L += paths.clamped(lit, slice(None), sampled=1)


class DirectMIS(Direct):
    """Both, each weighted by p² / (p_B² + p_E²)."""

    name = "direct_mis"
    label = "Direct, MIS"
    description = "Both strategies, combined with the power heuristic"
    combines = True

    def reflected(
        self, scene: Scene, path: PathState, si: Surface, bsdf: ShadedBSDF, random: LaneSampler
    ) -> None:
        m = bsdf.smooth_count
        if m and scene.has_emitters:
            here, paths = si.part(slice(0, m)), path.part(slice(0, m))
            light = scene.sample_emitter(here, random.emitter(0)[:, :m], path)
            value, pdf = bsdf.eval_pdf(light.wo, light.hidden)
            weight = mis(light.pdf, pdf * np.logical_not(light.delta))
            asked = value * light.weight * weight
            lit = scene.unoccluded(here, light, asked, self.transparent_depth, paths)
            paths.L += paths.clamped(lit, slice(None), sampled=1)
        rays = path.scatter(si, bsdf.sample(random.bsdf(0)))
        for hit in scene.emission(rays, scene.intersect(rays), path):
            path.gather(hit)
