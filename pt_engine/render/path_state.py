"""The state of a wavefront of paths, and the steps that move it along."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..bsdfs.base import Lobe
from ..core import vectors
from ..core.raykind import RayKind
from ..core.rows import Rows
from ..scene.lanes import Surface
from ..scene.scene import Found, Rays
from ..scene.shading import Scattered
from .dimensions import LaneSampler

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


def mis(pdf: Float32, other: Float32 | float) -> Float32:
    """Power heuristic (Veach 1997, β = 2) for a sample drawn with `pdf` that `other` could have drawn.

    By ratio, so that neither huge nor tiny densities overflow; an infinite `pdf` (Dirac) gets weight 1.
    """
    ratio = other / pdf
    weight: Float32 = 1 / (1 + ratio * ratio)
    return weight


class PathState(
    Rows,
    float_rows=(("beta", 3), ("L", 3), ("pdf", 1), ("travelled", 1)),
    int_rows=(("slot", 1), ("random", 2), ("kind", 1), ("depth", 1), ("passed", 1)),
):
    """One column per path that is still alive.

    Attributes
    ----------
    beta : (3, N) float32
        Throughput: product of f·cosθ/pdf along the path so far.
    L : (3, N) float32
        Radiance gathered so far.
    pdf : (N,) float32
        Density of the last direction; ∞ for a camera ray or after a Dirac bounce.
    travelled : (N,) float32
        Distance since the last real bounce, through transparent surfaces.
    slot : (N,) int32
        Which of the camera rays this is.
    random : (2, N) int32
        The sampler's state.
    kind, depth, passed : (N,) int32
        `RayKind` bits; real bounces and transparent surfaces so far.
    """

    beta: Float32
    L: Float32
    pdf: Float32
    travelled: Float32
    slot: Int32
    random: Int32
    kind: Int32
    depth: Int32
    passed: Int32

    @classmethod
    def start(cls, sampler: LaneSampler) -> PathState:
        """Camera paths: β = 1, L = 0, and a Dirac density, since no emitter sample competes."""
        n = sampler.state.shape[1]
        path = cls.empty(n)
        path.beta, path.L, path.pdf, path.travelled = 1, 0, np.inf, 0
        path.slot, path.kind, path.depth, path.passed = np.arange(n), RayKind.CAMERA, 0, 0
        path.random = sampler.state.view(np.int32)
        return path

    def sampler(self, base: LaneSampler) -> LaneSampler:
        """The random numbers of the paths that are alive."""
        return base.with_state(self.random.view(np.uint32))

    def gather(self, found: Found) -> None:
        """L += β · mis · Le on the lanes that found an emitter."""
        lanes = found.lanes
        weight = mis(self.pdf.take(lanes), found.pdf)
        self.L[:, lanes] += self.beta.take(lanes, axis=1) * found.radiance * weight

    def scatter(self, si: Surface, to: Scattered) -> Rays:
        """Go on toward the sampled directions; returns the next rays."""
        self.beta *= to.weight
        self.pdf = to.pdf
        self.kind = KIND_OF_LOBE.take(to.lobe)
        self.depth += 1
        self.travelled = 0
        return leave(si, to.wo, alive=vectors.max3(self.beta) > 0)

    def scatter_or_pass(self, si: Surface, to: Scattered, max_depth: int) -> Rays:
        """`scatter` in a scene with transparent surfaces, which a ray passes as if they were not there.

        Passing is no bounce: density, kind and depth stay those of the last one. A path on its last
        edge may only pass.
        """
        passing = np.flatnonzero(to.lobe & Lobe.TRANSPARENT)
        before = self.take(passing)
        travelled = before.travelled + si.t.take(passing)
        self.beta *= (self.depth < max_depth - 1) | ((to.lobe & Lobe.TRANSPARENT) != 0)
        rays = self.scatter(si, to)
        self.pdf[passing], self.kind[passing] = before.pdf, before.kind
        self.depth[passing], self.passed[passing] = before.depth, before.passed + 1
        self.travelled[passing] = travelled
        return rays


def leave(si: Surface, wo: Float32, alive: NDArray[np.bool_] | None = None) -> Rays:
    """Rays that start at the surface, offset to wo's side by the error bound of the hit."""
    side = np.copysign(si.bound, vectors.dot(si.ng, wo))
    tfar = np.full(si.size, 1e37, np.float32)
    if alive is not None:
        tfar[~alive] = -1
    return Rays(si.p + side * si.ng, wo, tfar)


def _kind_of_lobe(lobe: int) -> int:
    side = RayKind.TRANSMISSION if lobe & Lobe.TRANSMIT else RayKind.REFLECTION
    if lobe & Lobe.DIFFUSE:
        return side | RayKind.DIFFUSE
    return side | RayKind.GLOSSY | (RayKind.SINGULAR if lobe & Lobe.DELTA else 0)


KIND_OF_LOBE = np.array([_kind_of_lobe(lobe) for lobe in range(32)], np.int32)
