"""Who goes on after a bounce: one sort drops dead paths and brings each batch's paths together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.clock import stage
from ..core.rows import scatter
from ..scene import tally
from ..scene.scene import BatchNumbers, Scene
from ..scene.shading import Scattered
from ..scene.surface import Surface
from ..scene.wave import Intersection, Rays
from .integrator import Integrator
from .path_state import PathState

Float32 = NDArray[np.float32]
Spans = list[tuple[int, slice]]
RR_LEAST, RR_LIMIT = np.float32(0.01), np.float32(0.95)  # no path is lost for good, and none immortal


class Wavefront:
    """Keeps the radiance of paths that have ended, and decides which go on.

    Parameters
    ----------
    integrator : Integrator
        For its depths.
    scene : Scene
    size : int
        Number of camera rays.
    """

    def __init__(self, integrator: Integrator, scene: Scene, size: int) -> None:
        self._integrator, self._scene = integrator, scene
        self._radiance = np.full((3, size), np.float32(0))  # zeros would keep other threads waiting

    @stage("roulette")
    def survivors(self, path: PathState, found: Intersection) -> tuple[PathState, NDArray[np.intp], Spans]:
        """The paths that scatter where they are, sorted by group; the others' radiance is kept.

        Returns
        -------
        path : PathState
        order : (M,) intp
            Which of the given lanes they were.
        spans : list of (group, slice)
        """
        limit, scene = self._integrator, self._scene
        batch = scene.batch(found)  # `dead` where the ray left the scene or the surface only emits
        if scene.transparent_surfaces:
            last_edge = path.depth >= limit.max_depth - 1
            kill(batch, last_edge & ~scene.passes.take(batch), scene.dead)
            kill(batch, path.passed >= limit.transparent_depth, scene.dead)
        elif path.bounces >= limit.max_depth - 1:
            batch[:] = scene.dead
        order, spans = sorted_by_batch(batch, scene.dead)
        alive = spans[-1][1].stop if spans else 0
        self._keep(path, order[alive:])
        order = order[:alive]
        return (path if alive == path.size and len(spans) == 1 else path.take(order)), order, spans

    def _keep(self, path: PathState, ended: NDArray[np.intp]) -> None:
        slots = path.slot.take(ended, mode="wrap")
        scatter(self._radiance, slots, path.L.take(ended, axis=1, mode="wrap"))

    @stage("bsdf")
    def advance(self, path: PathState, si: Surface, to: Scattered, u: Float32 | None) -> Rays:
        """Scatter every path, or let it pass a transparent surface; with `u`, roulette may end it."""
        rays = path.go_on(self._scene, si, to, self._integrator.max_depth)
        strength = vectors.max3(path.beta)
        if u is not None:
            roulette(path, strength, u)
        off = (strength <= 0).astype(np.float32)  # NaN goes on, to be found in the film
        tfar = rays.tfar
        tfar *= 1 - off
        tfar -= off  # −1 switches a ray off
        tally.sent(self._scene.geometry, si.surface, tfar)
        return rays

    @stage("roulette")
    def finish(self, *left: PathState) -> Float32:
        """Radiance of all camera rays, when these paths end too."""
        for path in left:
            scatter(self._radiance, path.slot, path.L)
        return self._radiance


@stage("roulette")
def roulette(path: PathState, strength: Float32, u: Float32) -> None:
    """Let a path survive with probability q = max β, within [0.01, 0.95], and divide its β by q: unbiased.

    Below 2⁻²⁴ no random number but 0 could tell q from nothing, hence the least. Blender's materials refract
    without the η² of radiance, so β needs no correction for it. `strength`, max β, becomes 0 where the path
    ends.
    """
    q = np.minimum(np.maximum(strength, RR_LEAST), RR_LIMIT)
    survives = (u < q).astype(np.float32)
    strength *= survives
    survives /= q
    beta = path.beta
    beta *= survives


def kill(batch: BatchNumbers, dead: NDArray[np.bool_], number: int) -> None:
    """Mark lanes as dead, whose group number is the highest."""
    batch[dead] = number


def sorted_by_batch(batch: BatchNumbers, dead: int) -> tuple[NDArray[np.intp], Spans]:
    """Stable order that brings groups together, the dead last, and each living group's span."""
    if dead == 1:
        over = batch.astype(np.bool_)  # numpy finds those of booleans faster
        living, ended = np.flatnonzero(~over), np.flatnonzero(over)
        spans = [(0, slice(0, len(living)))] if len(living) else []
        return np.concatenate([living, ended]), spans
    order = np.argsort(batch, kind="stable")  # radix sort: 1.5 ns per lane of 8 bits
    counts = np.bincount(batch, minlength=dead + 1)
    ends = np.cumsum(counts)
    spans = [(int(k), slice(int(ends[k] - counts[k]), int(ends[k]))) for k in np.flatnonzero(counts[:dead])]
    return order, spans
