"""An integrator of your own: ambient occlusion, how much of the hemisphere above a point is open.

    A(p) = 1/π ∫ V(p, ω) |n·ω| dω         with ω drawn in proportion to |n·ω|:  Â = V

Load it in Blender under Sampling, Integrators of Your Own, or on the command line:

    python -m pt_engine render F.blend -o O.exr --plugin ambient_occlusion.py --integrator ambient_occlusion
"""

import numpy as np

from pt_engine.core import frames, warps
from pt_engine.render.integrator import Integrator
from pt_engine.scene.geometry import SKY


class AmbientOcclusion(Integrator):
    """1 where nothing is near, 0 in a closed corner; black where the ray hits nothing."""

    name = "ambient_occlusion"
    label = "Ambient Occlusion"
    description = "How much of the hemisphere above each point is open"
    distance = 1.0  # metres; what is farther away does not count

    def sample(self, scene, rays, sampler):
        found = scene.intersect(rays)
        hit = np.flatnonzero(found.surface != SKY)
        si = scene.surface(rays, found, hit)
        n = scene.shading_normal(rays, found)[:, hit]
        _, u, v = sampler.bsdf(0)[:, hit]
        s, t = frames.frame(n)
        wo = frames.to_world(s, t, n, warps.square_to_cosine_hemisphere(u, v))
        origin = si.p + si.bound * si.ng  # off the surface by its rounding error
        tfar = np.full(len(hit), self.distance, np.float32)
        radiance = np.zeros_like(rays.o)
        radiance[:, hit] = scene.accel.visible(origin, wo, tfar) != 0
        return radiance
