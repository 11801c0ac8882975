"""The BSDF of a whole wavefront: each batch's closures on its slice of lanes, summed.

Lanes arrive sorted by batch, so a batch's closures own a contiguous slice and nothing is masked. One
closure needs no choice; with several, `sample` picks one in proportion to what it is likely to scatter,
and pdf and value are those of the sum, so multiple importance sampling stays exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, reduce
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..bsdfs.base import BSDF, Lobe, gather
from ..core import frames, vectors
from ..core.clock import stage
from ..core.rows import scatter
from ..core.uniforms import Uniforms
from .bump_shadow import bump_shadow
from .clear_glass import clear
from .hidden_light import sees
from .lanes import Lanes
from .terminator_shading import fade

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
UInt8 = NDArray[np.uint8]
GRAZING = np.float32(1e-6)


class ClosureLike(Protocol):
    """What a program yields (see `nodes`): a scattering model, its parameters and its share."""

    @property
    def bsdf(self) -> BSDF: ...
    @property
    def params(self) -> tuple: ...  # type: ignore[type-arg]
    @property
    def weight(self) -> Float32: ...
    @property
    def normal(self) -> Float32 | None: ...
    @property
    def tangent(self) -> Float32 | None: ...
    @property
    def base(self) -> Float32 | None: ...


class Scattered(NamedTuple):
    """Sampled continuations of N paths.

    Attributes
    ----------
    wo : (3, N) float32
        World space.
    weight : (3, N) float32
        f·|cosθo|/pdf of the summed closures.
    pdf : (N,) float32
        Density per solid angle; infinite after a Dirac lobe, so that its MIS weight is 1.
    lobe : (N,) uint8
        Bits of `Lobe`.
    """

    wo: Float32
    weight: Float32
    pdf: Float32
    lobe: NDArray[np.uint8]


class LocalFrame:
    """A shading frame per lane, with `wi` in it; computed only for models that need one."""

    def __init__(self, normal: Float32, wi: Float32, tangent: Float32 | None) -> None:
        self.n, self._wi, self._tangent = normal, wi, tangent

    @cached_property
    def axes(self) -> tuple[Float32, Float32]:
        """The two tangents, (3, N) each."""
        if self._tangent is None:
            return frames.frame(self.n)
        return frames.from_tangent(self.n, self._tangent)

    @cached_property
    def wi(self) -> Float32:
        """(3, N) the viewer's direction in the frame."""
        wi = self.local(self._wi)
        # an interpolated normal may turn away from the viewer by a hair: look along the surface then
        np.maximum(wi[2], GRAZING, out=wi[2])
        return wi

    def local(self, w: Float32) -> Float32:
        """World to frame."""
        return frames.to_local(*self.axes, self.n, w)

    def world(self, w: Float32) -> Float32:
        """Frame to world."""
        return frames.to_world(*self.axes, self.n, w)

    def world_at(self, w: Float32, index: NDArray[np.intp]) -> Float32:
        """Frame to world, of some lanes."""
        s, t, n = (axis.take(index, axis=1) for axis in (*self.axes, self.n))
        return frames.to_world(s, t, n, w)


def _batch(bsdf: SliceBSDF, *_: object, **__: object) -> int:
    return bsdf.lanes.batch


class SliceBSDF:
    """The closures of one batch on its lanes."""

    def __init__(
        self,
        closures: Sequence[ClosureLike],
        lanes: Lanes,
        clear_glass: float = -1.0,
        angles: Float32 | None = None,
    ) -> None:
        """`angles` (N,) are for `terminator_shading.fade`, where light fades."""
        self.closures, self.angles = list(closures), angles
        self.lanes, self._clear_glass = lanes, clear_glass
        # with the geometric normal as the shading normal, no direction is on two sides at once
        self.bent = lanes.smooth or any(c.normal is not None for c in self.closures)
        self._frames: dict[tuple[int, int, bool], LocalFrame] = {}
        self.frames = [self._frame(c) for c in self.closures]
        self.shares = self._shares()

    @property
    def normal(self) -> Float32:
        """(3, N) or (3, 1) of the surface, bent where displacement is shaded; bumps are a closure's own."""
        base = self.closures[0].base if self.closures else None
        return self.lanes.ns if base is None else base

    def _frame(self, closure: ClosureLike) -> LocalFrame:
        specular = self.bent and getattr(closure.bsdf, "SPECULAR", False)
        key = (id(closure.normal), id(closure.tangent), specular)
        if key not in self._frames:
            normal = self.lanes.ns if closure.normal is None else closure.normal
            if specular:
                normal = self.lanes.raised(closure.normal)
            self._frames[key] = LocalFrame(normal, self.lanes.wi, closure.tangent)
        return self._frames[key]

    def _shares(self) -> list[Float32]:
        """Probability with which each closure is sampled, (N,) or (1,) each; they sum to 1 or to 0."""
        if len(self.closures) == 1:
            return [np.ones(1, np.float32)]
        raw = [
            vectors.mean3(c.weight) * c.bsdf.albedo(c.params, frame.wi[2])
            for c, frame in zip(self.closures, self.frames, strict=True)
        ]
        total: Float32 = sum(raw[1:], start=raw[0])
        scale: Float32 = np.reciprocal(np.maximum(total, np.float32(1e-20)))
        return [share * scale for share in raw]

    @stage("eval", batch=_batch)
    def eval_pdf(
        self, wo: Float32, hidden: UInt8 | None = None, chosen: Int32 | None = None
    ) -> tuple[Float32, Float32]:
        """f·|cosθo| and pdf of world directions `wo`, of all closures together.

        `hidden` (N,) are `Visibility` bits of kinds of scattering that see no light from there; `chosen` (N,)
        are the closures that have drawn `wo`, if any has: theirs end at the true surface's horizon.
        """
        local: dict[int, Float32] = {}
        parts = [self._eval_closure(k, wo, local, chosen) for k in range(len(self.closures))]
        if hidden is not None:
            seen = [sees(closure.bsdf, hidden) for closure in self.closures]
            parts = [(f * s, p) for (f, p), s in zip(parts, seen, strict=True)]
        if len(parts) == 1:
            return parts[0]
        value = np.zeros((3, self.lanes.n), np.float32)
        pdf = np.zeros(self.lanes.n, np.float32)
        for (f, p), share in zip(parts, self.shares, strict=True):
            value += f
            pdf += share * p
        return value, pdf

    def _eval_closure(
        self, k: int, wo: Float32, local: dict[int, Float32], chosen: Int32 | None
    ) -> tuple[Float32, Float32]:
        closure, frame = self.closures[k], self.frames[k]
        if hasattr(closure.bsdf, "eval_pdf_about"):
            cos_o = vectors.dot(frame.n, wo)
            f, p = closure.bsdf.eval_pdf_about(closure.params, cos_o)
        else:
            if id(frame) not in local:
                local[id(frame)] = frame.local(wo)
            cos_o = local[id(frame)][2]
            f, p = closure.bsdf.eval_pdf(closure.params, frame.wi, local[id(frame)])
        if self.bent:
            valid, shadow = self._valid(k, wo, cos_o, chosen), self._shadow(k, wo)
            f, p = f * valid * shadow, p * valid * (shadow > 0)
        if self.angles is not None:
            f = f * fade(cos_o, self.angles)
        return closure.weight * f, p

    def _valid(self, k: int, wo: Float32, cos_o: Float32, chosen: Int32 | None) -> NDArray[np.bool_]:
        """Whether `wo` is on one side of the surface and of the shading frame.

        As in Cycles the surface is the smooth one for emitters' light, the one that displacement bends to
        bumps on it, and the true one where the closure has drawn `wo` itself: so its rays leave the surface,
        and none is lost between the two horizons.
        """
        horizon = self.lanes.horizon
        if horizon is not self.lanes.ng and self.closures[k].normal is not self.normal:
            horizon = self.normal
        valid = self._same_side(wo, cos_o, horizon)
        if chosen is None or horizon is self.lanes.ng:
            return valid
        return np.where(chosen == k, self._same_side(wo, cos_o), valid)

    def _shadow(self, k: int, wo: Float32) -> Float32 | float:
        """What bumps leave of a diffuse closure's light (`bump_shadow`)."""
        closure = self.closures[k]
        smooth = self.normal
        if closure.normal is None or closure.normal is smooth or getattr(closure.bsdf, "SPECULAR", False):
            return 1.0
        return bump_shadow(smooth, closure.normal, wo)

    def _same_side(self, wo: Float32, cos_o: Float32, ng: Float32 | None = None) -> NDArray[np.bool_]:
        """Whether wo leaves on the side of the true surface that the shading frame says it does."""
        ng = self.lanes.ng if ng is None else ng
        same: NDArray[np.bool_] = vectors.dot(ng, wo) * cos_o > 0
        return same

    @stage("bsdf", batch=_batch)
    def sample(self, u: Uniforms, out: Scattered) -> None:
        """Fill `out` with one direction per lane from uniforms `u` (3, N)."""
        if len(self.closures) > 1:
            self._sample_among(u, out)
            return
        only = self.sample_only(u)
        out.wo[:], out.weight[:], out.pdf[:], out.lobe[:] = only

    def sample_only(self, u: Uniforms) -> Scattered:
        """One direction per lane, where there is but one closure."""
        closure, frame = self.closures[0], self.frames[0]
        if hasattr(closure.bsdf, "sample_about"):
            s, cos_o = closure.bsdf.sample_about(closure.params, frame.n, u[1], u[2])
            wo = s.wo
        else:
            s = closure.bsdf.sample(closure.params, frame.wi, u[0], u[1], u[2])
            wo, cos_o = frame.world(s.wo), s.wo[2]
            self._lead_away(closure)
        weight = s.weight * closure.weight
        lobe = self._lobe(closure, slice(None), s.lobe)
        if self.bent:
            weight = weight * (self._same_side(wo, cos_o) | _passes(s.lobe))
            weight *= np.maximum(self._shadow(0, wo), _passes(s.lobe))  # portals have no bumps
        if self.angles is not None:
            weight *= np.maximum(fade(cos_o, self.angles), _passes(s.lobe))
        lobes = np.empty(self.lanes.n, np.uint8)
        lobes[:] = lobe
        if np.ndim(lobe) == 0 and not lobe & Lobe.DELTA:
            return Scattered(wo, weight, s.pdf, lobes)
        out = Scattered(wo, weight, np.array(s.pdf), lobes)
        _mark_dirac(out)
        return out

    def _sample_among(self, u: Uniforms, out: Scattered) -> None:
        """One closure per lane by its share; then weight and pdf of the sum, except for Dirac lobes."""
        choice, u0 = choose(self.shares, u[0])
        dirac_weight = np.zeros_like(out.weight)
        for k, (closure, frame) in enumerate(zip(self.closures, self.frames, strict=True)):
            index = np.flatnonzero(choice == k)
            if len(index) == 0:
                continue
            params = gather(closure.params, index)
            wi = frame.wi.take(index, axis=1)
            s = closure.bsdf.sample(params, wi, u0.take(index), u[1].take(index), u[2].take(index))
            wo = frame.world_at(s.wo, index)
            share = np.maximum(_at(self.shares[k], index), np.float32(1e-20))
            weight = s.weight * _at(closure.weight, index) / share
            if self.bent:
                ng = self.lanes.ng.take(index, axis=1)
                weight = weight * (self._same_side(wo, s.wo[2], ng) | _passes(s.lobe))
            if self.angles is not None:
                weight = weight * np.maximum(fade(s.wo[2], self.angles.take(index)), _passes(s.lobe))
            self._lead_away(closure, index)
            scatter(out.wo, index, wo)
            scatter(dirac_weight, index, weight)
            out.lobe[index] = self._lobe(closure, index, s.lobe)
        value, pdf = self.eval_pdf(out.wo, chosen=choice)
        dirac = (out.lobe & Lobe.DELTA) != 0
        smooth = (pdf > 0) & ~dirac & (vectors.max3(dirac_weight) > 0)
        np.multiply(dirac_weight, dirac, out=out.weight)
        np.divide(value, pdf, out=out.weight, where=smooth)
        out.pdf[:] = pdf
        _mark_dirac(out)

    def _lobe(self, closure: ClosureLike, index: NDArray[np.intp] | slice, lobe: UInt8 | int) -> UInt8 | int:
        limit = self._clear_glass
        return lobe if limit < 0 else clear(closure, index, lobe, limit)

    def _lead_away(self, closure: ClosureLike, index: NDArray[np.intp] | None = None) -> None:
        """Through a portal rays leave from somewhere else; `index` None means all lanes."""
        if not getattr(closure.bsdf, "LEADS_AWAY", False):
            return
        if index is None:
            index = np.arange(self.lanes.n)
        position = gather(closure.params, index).position  # type: ignore[attr-defined]
        if position is not None:
            place = position - self.lanes.scene.origin32
            self.lanes.si.relocate(index, np.broadcast_to(place, (3, len(index))))


def _passes(lobe: NDArray[np.uint8] | int) -> NDArray[np.bool_] | bool:
    return (lobe & Lobe.TRANSPARENT) != 0


def _mark_dirac(out: Scattered) -> None:
    dirac = np.flatnonzero(out.lobe & Lobe.DELTA)
    if len(dirac):
        out.pdf[dirac] = np.inf


def _at(value: Float32, index: NDArray[np.intp]) -> Float32:
    return value if value.shape[-1] == 1 else value.take(index, axis=-1)


def choose(shares: Sequence[Float32], u: Float32) -> tuple[NDArray[np.int32], Float32]:
    """Index drawn from (N,) or (1,) shares that sum to 1, and the uniform that is left over in [0, 1).

    Rounding may leave the sum below `u`: the last share that is not 0 has what is left.
    """
    total: Float32 = reduce(np.add, shares)
    if u.size and np.max(u) >= np.min(total):  # hardly ever
        u = np.minimum(u, np.nextafter(total, np.float32(0)))
    choice = np.zeros(u.shape, np.int32)
    before = np.zeros_like(u)
    upto = np.zeros_like(u)
    width = np.zeros_like(u) + shares[0]
    for k, share in enumerate(shares[:-1]):
        upto = upto + share
        beyond = u >= upto
        choice += beyond
        before += beyond * (upto - before)
        width += beyond * (shares[k + 1] - width)
    left = (u - before) / np.maximum(width, np.float32(1e-20))
    return choice, np.minimum(np.maximum(left, 0), np.float32(1 - 2**-24))


class ShadedBSDF:
    """The BSDFs of a wavefront sorted by batch: `slices` of lanes, each with its closures."""

    def __init__(self, size: int, slices: Sequence[tuple[slice, SliceBSDF]], smooth_count: int) -> None:
        self.size, self.slices = size, slices
        self.smooth_count = smooth_count  # lanes [0, smooth_count) have more than Dirac lobes

    @stage("eval")
    def eval_pdf(self, wo: Float32, hidden: UInt8 | None = None) -> tuple[Float32, Float32]:
        """f·|cosθo| (3, M) and pdf (M,) toward `wo` (3, M), for the first M = `smooth_count` lanes.

        `hidden` (M,) is as in `LightSample`.
        """
        if len(self.slices) == 1:
            return self.slices[0][1].eval_pdf(wo, hidden)
        value = np.zeros(wo.shape, np.float32)
        pdf = np.zeros(wo.shape[1], np.float32)
        for span, bsdf in self.slices:
            if span.stop <= self.smooth_count:
                here = None if hidden is None else hidden[span]
                value[:, span], pdf[span] = bsdf.eval_pdf(np.ascontiguousarray(wo[:, span]), here)
        return value, pdf

    @stage("bsdf")
    def sample(self, u: Uniforms) -> Scattered:
        """One continuation per lane from uniforms `u` (3, N)."""
        if len(self.slices) == 1 and len(self.slices[0][1].closures) == 1:
            return self.slices[0][1].sample_only(u)
        n = self.size
        wo, weight = np.empty((3, n), np.float32), np.empty((3, n), np.float32)
        out = Scattered(wo, weight, np.empty(n, np.float32), np.zeros(n, np.uint8))
        for span, bsdf in self.slices:
            part = Scattered(wo[:, span], weight[:, span], out.pdf[span], out.lobe[span])
            bsdf.sample(u[:, span], part)
        return out
