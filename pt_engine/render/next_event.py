"""Next-event estimation: one sampled emitter per path, weighed against the BSDF's chance of finding it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from ..core.uniforms import Uniforms
from ..emitters.lights import LightSample
from ..scene.scene import Scene
from ..scene.shading import ShadedBSDF
from ..scene.surface import Surface
from .integrator import Integrator
from .path_state import PathState, mis

Float32 = NDArray[np.float32]


@stage("emitter")
def next_event(
    scene: Scene, path: PathState, si: Surface, bsdf: ShadedBSDF, u: Uniforms, limit: Integrator
) -> None:
    """L += β · f·cosθ · Le/pdf · mis · visibility, with one emitter sample per path.

    Only the lanes [0, m) whose BSDF has more than Dirac lobes take part; the others could never
    reach a sampled emitter (f ∝ δ needs p ∝ δ).
    """
    m = bsdf.smooth_count
    if m == 0 or not scene.lights.description.total:
        return
    here, paths = si.part(slice(0, m)), path.part(slice(0, m))
    light = scene.sample_emitter(here, u[:, :m], paths)
    value, pdf = bsdf.eval_pdf(light.wo, light.hidden)
    if light.delta is not False:
        pdf = pdf * np.logical_not(light.delta)
    weight = mis(light.pdf, pdf)
    contribution = value
    contribution *= light.weight
    contribution *= paths.beta
    contribution *= weight
    if scene.transparent_surfaces:  # paths on their last edge may pass such a surface but not scatter
        contribution *= paths.depth < limit.max_depth - 1
    lit = scene.unoccluded(here, light, contribution, limit.transparent_depth, paths)
    add_sampled(scene, paths, light, lit)


def add_sampled(scene: Scene, paths: PathState, light: LightSample, lit: Float32) -> None:
    """L += what sampled emitters send (3, N), after any clamping; noted under their light groups."""
    lit = paths.clamped(lit, slice(None), sampled=1)
    L = paths.L
    L += lit
    if scene.by_group is not None:
        groups = scene.lights.light_group
        scene.by_group.add(0 if groups is None else groups[light.emitter], paths.slot, lit)
