"""The state of a wavefront of paths, and the steps that move it along."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bsdfs.base import Lobe
from ..core import vectors
from ..core.raykind import RayKind
from ..core.rows import Rows
from ..scene.accel import FAR
from ..scene.lanes import Surface
from ..scene.scene import Found, Rays
from ..scene.shading import Scattered
from .dimensions import LaneSampler

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


TINY = np.float32(1e-30)
HISTORY = ("pdf", "kind", "travelled", "depth", "passed")


def mis(pdf: Float32, other: Float32) -> Float32:
    """Power heuristic (Veach 1997, β = 2) for a sample drawn with `pdf` that `other` could have drawn.

    By ratio, so that neither huge nor tiny densities overflow; an infinite `pdf` (Dirac) gets weight 1.
    """
    with np.errstate(over="ignore"):
        ratio = other / np.maximum(pdf, TINY)
        weight: Float32 = 1 / (1 + ratio * ratio)
    return weight


class PathState(Rows, float_rows=(("beta", 3), ("L", 3)), int_rows=(("slot", 1), ("random", 2))):
    """One column per path that is still alive.

    Attributes
    ----------
    beta : (3, N) float32
        Throughput: product of f·cosθ/pdf along the path so far.
    L : (3, N) float32
        Radiance gathered so far.
    slot : (N,) int32
        Which of the camera rays this is.
    random : (2, N) int32
        The sampler's state.
    pdf : (N,) float32
        Density of the last direction; ∞ for a camera ray or after a Dirac bounce.
    travelled : (N,) float32
        Distance since the last real bounce, through transparent surfaces.
    kind, depth, passed : (N,) int32
        `RayKind` bits; real bounces and transparent surfaces so far.

    Only scenes in which somebody asks (`Scene.tracks_history`) carry the last four lane by lane.
    """

    beta: Float32
    L: Float32
    slot: Int32
    random: Int32
    pdf: Float32
    travelled: Float32
    kind: Int32
    depth: Int32
    passed: Int32
    tracked: bool
    bounces: int  # of the whole wavefront

    @classmethod
    def start(cls, sampler: LaneSampler, tracked: bool) -> PathState:
        """Camera paths: β = 1, L = 0, and a Dirac density, since no emitter sample competes."""
        n = sampler.state.shape[1]
        path = cls.empty(n)
        path.beta, path.L = 1, 0
        path.slot, path.random = np.arange(n), sampler.state.view(np.int32)
        path.pdf = np.full(n, np.inf, np.float32)
        path.tracked, path.bounces = tracked, 0
        path._reset_history()
        if tracked:
            for name in HISTORY:
                setattr(path, name, getattr(path, name).copy())
        return path

    def _reset_history(self) -> None:
        """All paths alike: on camera rays, or one bounce further on."""
        n, kind = self.size, RayKind.REFLECTION if self.bounces else RayKind.CAMERA
        self.kind, self.depth, self.passed = same(kind, n), same(self.bounces, n), same(0, n)
        self.travelled = np.broadcast_to(np.float32(0), n)

    def take(self, index: NDArray[np.intp]) -> PathState:
        """The paths at `index`, in that order."""
        return self._with_history(super().take(index), lambda row: row.take(index))

    def part(self, span: slice) -> PathState:
        """A view of consecutive paths."""
        return self._with_history(super().part(span), lambda row: row[span])

    def _with_history(self, path: PathState, pick: Callable[[NDArray[Any]], NDArray[Any]]) -> PathState:
        path.tracked, path.bounces = self.tracked, self.bounces
        if self.tracked:
            for name in HISTORY:
                setattr(path, name, pick(getattr(self, name)))
        else:
            path._reset_history()
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
        self.bounces += 1
        if self.tracked:
            self.kind, self.depth = KIND_OF_LOBE.take(to.lobe), self.depth + 1
            self.travelled = np.zeros(self.size, np.float32)
        else:
            self._reset_history()
        return leave(si, to.wo)

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

    def ride_along(self, moved: PathState, rays: Rays) -> Rays:
        """Take over what became of the first paths (`moved`, a part of these); the others' rays are off."""
        n, m = self.size, moved.size
        self.beta[:, m:] = 0
        history = {name: np.zeros(n, getattr(moved, name).dtype) for name in HISTORY}
        for name, row in history.items():
            row[:m] = getattr(moved, name)
            setattr(self, name, row)
        self.bounces = moved.bounces
        o, d = np.zeros((3, n), np.float32), np.ones((3, n), np.float32)
        tfar = np.full(n, -1, np.float32)
        o[:, :m], d[:, :m], tfar[:m] = rays
        return Rays(o, d, tfar)


def same(value: int, n: int) -> Int32:
    """The same number on all lanes, without the memory."""
    return np.broadcast_to(np.int32(value), n)


def leave(si: Surface, wo: Float32) -> Rays:
    """Rays that start at the surface, offset to wo's side by the error bound of the hit."""
    side = np.copysign(si.bound, vectors.dot(si.ng, wo))
    return Rays(si.p + side * si.ng, wo, np.full(si.size, FAR, np.float32))


def _kind_of_lobe(lobe: int) -> int:
    side = RayKind.TRANSMISSION if lobe & Lobe.TRANSMIT else RayKind.REFLECTION
    if lobe & Lobe.DIFFUSE:
        return side | RayKind.DIFFUSE
    return side | RayKind.GLOSSY | (RayKind.SINGULAR if lobe & Lobe.DELTA else 0)


KIND_OF_LOBE = np.array([_kind_of_lobe(lobe) for lobe in range(32)], np.int32)
