"""Ray queries through Embree; the only file that knows embreex.

embreex starts every ray at t = 0, so a near clip moves the origin and a surface is left by the error
bound in `geometry`. Queries release the GIL; a built scene is only read, so threads may share it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from numpy.typing import NDArray

from ..core.clock import count_rays, stage

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]

MISS = -1
FAR = np.float32(1e37)  # what embreex itself uses for infinity


class Hits(NamedTuple):
    """Closest hits of N rays; `prim` is `MISS` where there is none.

    Attributes
    ----------
    t, u, v : (N,) float32
        Distance in units of the direction, and barycentrics of corners 1 and 2.
    prim : (N,) int32
    """

    t: Float32
    u: Float32
    v: Float32
    prim: Int32


class Accel:
    """An Embree scene of one triangle mesh, built once.

    Parameters
    ----------
    vertices : (V, 3) float32
        Finite, recentred world positions.
    triangles : (T, 3) int32
    """

    def __init__(self, vertices: Float32, triangles: Int32) -> None:
        self.empty = len(triangles) == 0
        self._scene = rtcore_scene.EmbreeScene()
        if not self.empty:
            TriangleMesh(self._scene, vertices, triangles)
            nowhere = np.zeros((1, 3), np.float32)
            self._scene.run(nowhere, nowhere + 1, np.full(1, -1, np.float32), query="OCCLUDED")  # commits

    @stage("intersect")
    def intersect(self, origin: Float32, direction: Float32, tfar: Float32) -> Hits:
        """Closest hits of (3, N) rays with t in [0, `tfar`]; a ray with `tfar` < 0 is skipped."""
        count_rays(tfar)
        if self.empty:
            n = origin.shape[1]
            zero = np.zeros(n, np.float32)
            return Hits(tfar, zero, zero, np.full(n, MISS, np.int32))
        hit = self._scene.run(origin.T, direction.T, tfar, output=True)
        return Hits(hit["tfar"], hit["u"], hit["v"], hit["primID"])

    @stage("shadow")
    def visible(self, origin: Float32, direction: Float32, tfar: Float32) -> Int32:
        """Whether nothing lies in [0, `tfar`], as the bit mask −1 (clear) or 0 (blocked).

        Skipped rays (`tfar` < 0) read as blocked: culling a shadow ray that way costs a fifth of tracing it.
        """
        count_rays(tfar)
        if self.empty:
            return -(tfar >= 0).astype(np.int32)
        mask: Int32 = self._scene.run(origin.T, direction.T, tfar, query="OCCLUDED")
        return mask
