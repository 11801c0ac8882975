"""Ambient occlusion: how open a point is, as a grey value.

    A(p) = 1/π ∫ V(p, ω) cosθ dω        V = 0 where a ray from p meets something within `reach`, else 1

ω is drawn in proportion to its cosine, so one sample's estimate is V itself.
"""

import numpy as np

from pt_engine.core import frames, vectors, warps
from pt_engine.render.integrator import Integrator


class AmbientOcclusion(Integrator):
    """White in the open, dark in corners, black where nothing is hit."""

    name = "ambient_occlusion"
    label = "Ambient Occlusion"
    description = "How much of the hemisphere above each point is open"
    reach = 1.0  # Blender units

    def sample(self, scene, rays, sampler):
        found = scene.intersect(rays)
        hit = np.flatnonzero(found.hits.prim >= 0)
        si = scene.surface(rays, found, hit)
        n = scene.shading_normal(rays, found)[:, hit]
        _, u, v = sampler.bsdf(0)[:, hit]
        wo = frames.to_world(*frames.frame(n), n, warps.square_to_cosine_hemisphere(u, v))
        start = si.p + np.copysign(si.bound, vectors.dot(si.ng, wo)) * si.ng  # off the surface, to wo's side
        radiance = np.zeros((3, rays.o.shape[1]), np.float32)
        radiance[:, hit] = scene.accel.visible(start, wo, np.full(len(hit), self.reach, np.float32)) != 0
        return radiance
