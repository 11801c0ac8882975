"""The state of a wavefront of paths, and the steps that move it along."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bsdfs.base import Lobe
from ..core import keyed
from ..core.clock import stage
from ..core.raykind import RayKind
from ..core.rows import Rows, scatter_add
from ..scene.accel import FAR
from ..scene.scene import Scene
from ..scene.shading import Scattered
from ..scene.surface import Surface
from ..scene.wave import Found, Rays
from .clamping import Clamp
from .dimensions import LaneSampler

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


TINY = np.float32(1e-30)
HISTORY = ("kind", "depth", "passed", "travelled", "place", "place_here")


def mis(pdf: Float32, other: Float32) -> Float32:
    """Power heuristic (Veach 1997, β = 2) for a sample drawn with `pdf` that `other` could have drawn.

    By ratio, so that neither huge nor tiny densities overflow; an infinite `pdf` (Dirac) gets weight 1.
    """
    with np.errstate(over="ignore"):
        ratio = other / np.maximum(pdf, TINY)
        ratio *= ratio
        ratio += 1
    return np.reciprocal(ratio, out=ratio)


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
    place, place_here : (N,) int32
        `LightSample.place` of the last real bounce, and of the surface where the path is now.
    radius, spread : (N,) float32, or None
        Of the ray's cone where the last segment began, where it is tracked: Cycles' compact ray
        differentials (Igehy 1999). No bounce changes how it widens.
    sharpness : (N,) float32, or None
        Smallest density of the path's directions so far, where it is tracked.
    diffuse_depth, glossy_depth, transmission_depth, portal_depth : (N,) int32
        Bounces of one kind so far.
    receiver : (N,) int32
        Which instance the last real bounce was on; −1 for none.
    clear : (N,) int32 or bool
        Whether the ray still sees the film: a camera ray, or one through glass only where that is clear.

    Only scenes in which somebody asks (`Scene.tracks_history`, `Scene.history`) carry all from `travelled`
    on lane by lane.
    """

    beta: Float32
    L: Float32
    slot: Int32
    random: Int32
    pdf: Float32
    bounces: int  # of the whole wavefront
    _clamp: Clamp | None  # None: nothing is clamped
    _history: dict[str, NDArray[Any]] | None  # None: all lanes are alike

    @classmethod
    def start(
        cls,
        sampler: LaneSampler,
        tracked: bool,
        more: Mapping[str, NDArray[Any]] | None = None,
        clamp: Clamp | None = None,
    ) -> PathState:
        """Camera paths: β = 1, L = 0, and a Dirac density, since no emitter sample competes.

        `more` are those rows of the history that only some scenes have (`Scene.history`).
        """
        n = sampler.state.shape[1]
        path = cls.empty(n)
        path.beta[:], path.L[:] = 1, 0
        path.slot[:], path.random[:] = np.arange(n), sampler.state.view(np.int32)
        path.pdf = np.full(n, np.inf, np.float32)
        path.bounces, path._clamp, path._history = 0, clamp, None
        if tracked:
            path._history = {name: path._column(name).copy() for name in HISTORY}
            path._history |= more or {}
        return path

    def _column(self, name: str) -> NDArray[Any]:
        """Lane by lane where it is tracked; else the same number on all, without the memory."""
        if self._history is not None and name in self._history:
            return self._history[name]
        kind = RayKind.REFLECTION if self.bounces else RayKind.CAMERA
        values = {"kind": np.int32(kind), "depth": np.int32(self.bounces), "travelled": np.float32(0)}
        return np.broadcast_to(values.get(name, np.int32(0)), self.size)

    @property
    def kind(self) -> Int32:
        return self._column("kind")

    @property
    def kind_of_first(self) -> int:
        """`kind` of the first path: of all, where nobody tracks them."""
        if self._history is not None:
            return int(self._history["kind"][0]) if self.size else 0
        return RayKind.REFLECTION if self.bounces else RayKind.CAMERA

    @property
    def depth(self) -> Int32:
        return self._column("depth")

    @property
    def passed(self) -> Int32:
        return self._column("passed")

    @property
    def travelled(self) -> Float32:
        return self._column("travelled")

    @property
    def place(self) -> Int32:
        return self._column("place")

    def places(self, lanes: NDArray[np.intp] | slice) -> Int32 | None:
        """`place` of some lanes; None where it is not tracked, for then nobody asks."""
        return self.place[lanes] if self._history is not None else None

    def chooses_light_at(self, place: Int32 | None) -> None:
        """Note where the first lanes, those that sample an emitter, are; None where that does not matter."""
        if self._history is not None and place is not None:
            self._history["place_here"][: len(place)] = place

    @property
    def radius(self) -> Float32 | None:
        return (self._history or {}).get("radius")

    @property
    def spread(self) -> Float32 | None:
        return (self._history or {}).get("spread")

    @property
    def sharpness(self) -> Float32 | None:
        return (self._history or {}).get("sharpness")

    @property
    def noise(self) -> NDArray[np.uint32]:
        """(2, N) for the random numbers of nodes (see `core.keyed`), new after each bounce."""
        return keyed.noise(self.random.view(np.uint32), self.bounces)

    @property
    def diffuse_depth(self) -> Int32:
        return self._column("diffuse_depth")

    @property
    def glossy_depth(self) -> Int32:
        return self._column("glossy_depth")

    @property
    def clear(self) -> NDArray[np.integer | np.bool_]:
        if self._history is not None and "clear" in self._history:
            return self._history["clear"]
        seen: NDArray[np.bool_] = (self.kind & RayKind.CAMERA) != 0
        return seen

    @property
    def receiver(self) -> Int32:
        return self._column("receiver")

    @property
    def transmission_depth(self) -> Int32:
        return self._column("transmission_depth")

    @property
    def portal_depth(self) -> Int32:
        return self._column("portal_depth")

    def take(self, index: NDArray[np.intp]) -> PathState:
        """The paths at `index`, in that order. The density is not carried: it was for this hit."""
        return self._with_history(super().take(index), lambda row: row.take(index))

    def part(self, span: slice) -> PathState:
        """A view of consecutive paths."""
        return self._with_history(super().part(span), lambda row: row[span])

    @classmethod
    def joined(cls, parts: Sequence[PathState]) -> PathState:
        """All paths of some parts that have made equally many bounces, with their density if all carry it."""
        first = parts[0]
        path = super().joined(parts)
        if all("pdf" in vars(part) for part in parts):
            path.pdf = np.concatenate([part.pdf for part in parts])
        path.bounces, path._clamp, path._history = first.bounces, first._clamp, None
        if first._history is not None:
            path._history = {
                name: np.concatenate([(part._history or {})[name] for part in parts])
                for name in first._history
            }
        return path

    def _with_history(self, path: PathState, pick: Callable[[NDArray[Any]], NDArray[Any]]) -> PathState:
        path.bounces, path._clamp, path._history = self.bounces, self._clamp, None
        if self._history is not None:
            path._history = {name: pick(row) for name, row in self._history.items()}
            path.pdf = pick(self.pdf)  # a ray that passes a transparent surface keeps it
        return path

    def sampler(self, base: LaneSampler) -> LaneSampler:
        """The random numbers of the paths that are alive."""
        return base.with_state(self.random.view(np.uint32))

    @stage("emission")
    def gather(self, found: Found) -> None:
        """L += β · mis · Le on the lanes that found an emitter."""
        lanes = found.lanes
        weight = mis(self.pdf.take(lanes), found.pdf)
        light = self.clamped(self.beta.take(lanes, axis=1) * found.radiance * weight, lanes)
        scatter_add(self.L, lanes, light)
        if found.by_group is not None:
            found.by_group.add(found.group, self.slot.take(lanes), light)

    def clamped(self, radiance: Float32, lanes: NDArray[np.intp] | slice, sampled: int = 0) -> Float32:
        """What the clamp leaves of light that some paths have found, or, with `sampled` 1, have sampled."""
        return self._clamp.applied(radiance, self.depth[lanes] + sampled) if self._clamp else radiance

    def scatter(self, si: Surface, to: Scattered, start: Float32 | None = None) -> Rays:
        """Go on toward the sampled directions, from `si.start` or `start`; returns the next rays."""
        beta = self.beta
        beta *= to.weight
        self.pdf = to.pdf
        self.bounces += 1
        if self._history is not None:
            self._history["kind"] = KIND_OF_LOBE.take(to.lobe)
            self._history["depth"] = self._history["depth"] + 1
            self._history["travelled"] = np.zeros(self.size, np.float32)
            self._history["place"] = self._history["place_here"].copy()
            if "radius" in self._history:
                self._history["radius"] = self._history["radius"] + self._history["spread"] * si.t
            if "sharpness" in self._history:
                self._history["sharpness"] = np.minimum(self._history["sharpness"], to.pdf)
            for name in DEPTH_OF_LOBE.keys() & self._history.keys():
                self._history[name] = self._history[name] + DEPTH_OF_LOBE[name].take(to.lobe)
            if "receiver" in self._history:
                self._history["receiver"] = si.instance
            if "clear" in self._history:
                self._history["clear"] = self._history["clear"] * ((to.lobe & Lobe.CLEAR) != 0)
        o = si.start(to.wo) if start is None else start
        tfar = np.full(self.size, FAR, np.float32)
        return Rays(o, to.wo, tfar, 0 if self._history is None else self.kind, si.strand)

    def go_on(self, scene: Scene, si: Surface, to: Scattered, max_depth: int) -> Rays:
        """`scatter`, or pass a transparent surface as if it were not there.

        Passing is no bounce: density, kind and depth stay those of the last one. A path on its last
        edge may only pass.
        """
        if not scene.transparent_surfaces:
            return self.scatter(si, to, scene.start(si, to.wo))
        passing = np.flatnonzero(to.lobe & Lobe.TRANSPARENT)
        before = self.take(passing)
        travelled = before.travelled + si.t.take(passing)
        self.beta *= (self.depth < max_depth - 1) | ((to.lobe & Lobe.TRANSPARENT) != 0)
        rays = self.scatter(si, to)
        self.pdf[passing], self.kind[passing] = before.pdf, before.kind
        self.depth[passing], self.passed[passing] = before.depth, before.passed + 1
        self.travelled[passing], self.place[passing] = travelled, before.place
        for name in KEPT & (self._history or {}).keys():
            getattr(self, name)[passing] = getattr(before, name)
        if scene.has_portals:  # no emitter sample reaches through them
            away = np.flatnonzero(to.lobe & Lobe.PORTAL)
            self.pdf[away], self.travelled[away] = np.inf, 0
            if "portal_depth" in (self._history or {}):
                self.portal_depth[away] += 1
        return rays

    def ride_along(self, moved: PathState, rays: Rays) -> Rays:
        """Take over what became of the first paths (`moved`, a part of these); the others' rays are off."""
        n, m = self.size, moved.size
        self.beta[:, m:] = 0
        self.pdf = np.ones(n, np.float32)
        self.pdf[:m] = moved.pdf
        for name, row in (moved._history or {}).items():
            column = np.zeros(n, row.dtype)
            column[:m] = row
            self._history = {**(self._history or {}), name: column}
        self.bounces = moved.bounces
        o, d = np.zeros((3, n), np.float32), np.ones((3, n), np.float32)
        tfar = np.full(n, -1, np.float32)
        o[:, :m], d[:, :m], tfar[:m] = rays[:3]
        strand = None if rays.strand is None else np.full(n, -1, np.int32)
        if strand is not None:
            strand[:m] = rays.strand
        return Rays(o, d, tfar, self.kind, strand)


def _kind_of_lobe(lobe: int) -> int:
    side = RayKind.TRANSMISSION if lobe & Lobe.TRANSMIT else RayKind.REFLECTION
    if lobe & Lobe.DIFFUSE:
        return side | RayKind.DIFFUSE
    return side | RayKind.GLOSSY | (RayKind.SINGULAR if lobe & Lobe.DELTA else 0)


KIND_OF_LOBE = np.array([_kind_of_lobe(lobe) for lobe in range(128)], np.int32)


def _counted(kind: int, but: int = 0) -> Int32:
    """(lobes,) 1 where a bounce is of a kind and not of another."""
    counts: Int32 = (((KIND_OF_LOBE & kind) != 0) & ((KIND_OF_LOBE & but) == 0)).astype(np.int32)
    return counts


DEPTH_OF_LOBE = {
    "diffuse_depth": _counted(RayKind.DIFFUSE, but=RayKind.TRANSMISSION),
    "glossy_depth": _counted(RayKind.GLOSSY, but=RayKind.TRANSMISSION),
    "transmission_depth": _counted(RayKind.TRANSMISSION),
}
KEPT = {*DEPTH_OF_LOBE, "receiver", "clear"}  # by rays that pass a transparent surface
