"""Direct illumination three ways (the lecture's Ver 0.3 to 0.6).

    L(p₁, ω₁₀) = Le + ∫ Le,₂₁ f(ω₁₂, ω₁₀) |n·ω₁₂| dω₁₂

One bounce, estimated from BSDF samples, from emitter samples, or from both with the power heuristic.
Dirac deltas need no special case: a Dirac direction carries the density ∞, an emitter that no ray can
hit has `light.delta`. What one strategy cannot see stays black, as on the slides: point lights with
BSDF sampling, ideal mirrors with emitter sampling. To pass a transparent surface is no bounce: p₁ is
what scatters first.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.clock import stage
from ..core.uniforms import Uniforms
from ..scene import tally
from ..scene.scene import Scene
from ..scene.shading import ShadedBSDF
from ..scene.surface import Surface
from ..scene.wave import Found, Rays
from .dimensions import LaneSampler
from .integrator import Integrator
from .next_event import add_sampled, next_event
from .path_state import PathState
from .settings import RenderSettings
from .survivors import Wavefront

Float32 = NDArray[np.float32]


class Direct(Integrator):
    """What the three have in common: emission, then one bounce, and any transparent surfaces between.

    Attributes
    ----------
    edges : int
        How many are traced: 2, or 1 where only emitter samples see the second.
    """

    edges: ClassVar[int] = 2

    def __init__(self, settings: RenderSettings) -> None:
        super().__init__(settings)
        self.max_depth = 2

    def sample(self, scene: Scene, rays: Rays, sampler: LaneSampler) -> Float32:
        path = PathState.start(sampler, scene.tracks_history, scene.history(rays), self.clamp)
        front = Wavefront(self, scene, path.size)

        for step in range(self.edges + scene.transparent_surfaces * self.transparent_depth):
            found = scene.intersect(rays)
            for hit in scene.emission(rays, found, path):
                self.arrive(path, hit)

            path, lanes, spans = front.survivors(path, found)
            if path.size == 0:
                break
            si = scene.surface(rays, found, lanes)
            bsdf, random = scene.shade(si, path, spans), path.sampler(sampler)
            self.light(scene, path, si, bsdf, random.emitter(step))

            rays = path.go_on(scene, si, bsdf.sample(random.bsdf(step)), self.edges)
            rays.tfar[vectors.max3(path.beta) <= 0] = -1
            tally.sent(scene.geometry, si.surface, rays.tfar)
        return front.finish(path)

    def arrive(self, path: PathState, hit: Found) -> None:
        """Add the emission that the camera's or the BSDF's direction has run into to `path.L`."""
        path.gather(hit._replace(pdf=np.zeros_like(hit.pdf)))  # no other strategy could have found it

    def light(self, scene: Scene, path: PathState, si: Surface, bsdf: ShadedBSDF, u: Uniforms) -> None:
        """Add the estimate from a sampled emitter to `path.L`; none here."""


class DirectBSDF(Direct):
    """L̂ = f·cosθ · Le / p_B: `arrive`, where β = f·cosθ / p_B."""

    name = "direct_bsdf"
    label = "Direct, BSDF Sampling"
    description = "One bounce toward a direction drawn from the BSDF; cannot see point lights"


class DirectEmitter(Direct):
    """L̂ = f·cosθ · Le · V / p_E."""

    name = "direct_emitter"
    label = "Direct, Emitter Sampling"
    description = "One bounce toward a point drawn on an emitter; cannot see lights in ideal mirrors"
    edges = 1

    @stage("emitter")
    def light(self, scene: Scene, path: PathState, si: Surface, bsdf: ShadedBSDF, u: Uniforms) -> None:
        m = bsdf.smooth_count
        if m == 0 or not scene.lights.description.total:
            return
        here, paths = si.part(slice(0, m)), path.part(slice(0, m))
        light = scene.sample_emitter(here, u[:, :m], paths)
        value, _ = bsdf.eval_pdf(light.wo, light.hidden)
        contribution = paths.beta * value * light.weight  # β: of transparent surfaces before p₁
        lit = scene.unoccluded(here, light, contribution, self.transparent_depth, paths)
        add_sampled(scene, paths, light, lit)


class DirectMIS(Direct):
    """Both, each weighted by p² / (p_B² + p_E²)."""

    name = "direct_mis"
    label = "Direct, MIS"
    description = "Both strategies, combined with the power heuristic"
    combines = True

    def arrive(self, path: PathState, hit: Found) -> None:
        path.gather(hit)

    def light(self, scene: Scene, path: PathState, si: Surface, bsdf: ShadedBSDF, u: Uniforms) -> None:
        next_event(scene, path, si, bsdf, u, self)
