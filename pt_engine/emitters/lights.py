"""All that shines, as one: choose an emitter, sample it, and say how likely that was.

Lamps do not occlude: a ray passes through them and gathers all that lie before its hit, as in Cycles.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from ..core.distributions import AliasTable
from ..core.uniforms import Uniforms
from ..scene.snapshot import LightData
from . import select
from .base import FAR, NO_BARYCENTRIC, NO_LANES, Draw, Float32, Float64, Hits, Index, Lamp, LampShader
from .cuts import LocalChoice
from .description import Description
from .environment import Environment
from .faces import Faces
from .many import Surfaces, crowd, local_choice
from .parts import EnvironmentPart, Part, lamp_parts, traits
from .restricted import Restrictions, Shown, Ways, restrictions
from .triangle import TriangleEmitters

LAMPS = ("point", "spot", "sun", "area")
Places: TypeAlias = NDArray[np.int32] | None


class LightSample(NamedTuple):
    """One direction per lane toward some emitter.

    Attributes
    ----------
    wo : (3, N) float32
        Unit, world space, from the reference point.
    distance : (N,) float32
        tfar of the shadow ray; −1 where none is to be traced, 10³⁰ toward what lies at infinity.
    weight : (3, N) float32
        Le / pdf; 0 where the sample failed. On the lanes `varying` it is 1 / pdf: multiply by Le.
    pdf : (N,) float32
        Per solid angle, times the probability of the choice; of a delta light, that probability.
    delta : bool or (N,) bool
        No ray meets this light by chance, so that its MIS weight is 1.
    emitter : int or (N,) int32
        Number of the emitter: lamps as in `Lights.names`, then emissive faces, then the environment.
    varying : (M,) int
        Lanes on triangles whose emission varies.
    triangle : (M,) int
        Their row of `TriangleEmitters`.
    barycentric : (2, M) float32
        Their b1, b2: x = p0 + b1·e1 + b2·e2.
    place : (N,) int32 or None
        Where the emitter was chosen for; whoever meets an emitter by chance says it to learn the pdf there.
        None where the choice is the same everywhere.
    hidden : (N,) uint8 or None
        `Visibility` bits of the kinds of scattering that do not see the emitter; None where all see all.
    """

    wo: Float32
    distance: Float32
    weight: Float32
    pdf: Float32
    delta: bool | NDArray[np.bool_]
    emitter: int | NDArray[np.int32]
    varying: Index = NO_LANES
    triangle: Index = NO_LANES
    barycentric: Float32 = NO_BARYCENTRIC
    place: Places = None
    hidden: NDArray[np.uint8] | None = None


class Lights:
    """Every emitter of a scene.

    Parameters
    ----------
    lamps : sequence of LightData
    lamp_strength : (L, 3) float or None
        Constant factor of each lamp's node tree; None for ones.
    origin : (3,) float64
        What is subtracted from world positions (recentring).
    triangles : TriangleEmitters or None
    environment : Environment or None
    scene_radius : float
        Of a sphere around all there is to light: weighs suns and environment against the rest.
    shaders : sequence of LampShader or None
        Of each lamp whose node tree varies; () where none does.
    surfaces : Surfaces or None
        What there is to light, for a choice that depends on where; None for one by power alone.
    shown : Shown
    """

    def __init__(
        self,
        lamps: Sequence[LightData] = (),
        lamp_strength: NDArray[np.floating] | None = None,
        origin: NDArray[np.floating] | Sequence[float] = (0.0, 0.0, 0.0),
        triangles: TriangleEmitters | None = None,
        environment: Environment | None = None,
        scene_radius: float = 1.0,
        shaders: Sequence[LampShader | None] = (),
        surfaces: Surfaces | None = None,
        shown: Shown | None = None,
    ) -> None:
        factors = np.ones((len(lamps), 3)) if lamp_strength is None else np.asarray(lamp_strength, np.float64)
        centre, radius = np.asarray(origin, np.float64), max(float(scene_radius), 1e-6)
        shaders = shaders or [None] * len(lamps)
        resolved = [_resolve(*row, centre) for row in zip(lamps, factors, shaders, strict=True)]
        shining = [lamp for lamp in resolved if select.lamp_power(lamp, radius) > 0.0]
        shining.sort(key=traits)  # stable; equal ones become neighbours
        of_lamps = [select.lamp_power(lamp, radius) for lamp in shining]
        faces = Faces(triangles) if triangles is not None else None
        of_faces = faces.power if faces is not None else np.empty(0)
        of_world = [np.pi * radius**2 * environment.irradiance] if environment is not None else []
        if not of_faces.any():
            faces, of_faces = None, np.empty(0)
        if not any(of_world):
            environment, of_world = None, []
        self.power: Float64 = np.concatenate([of_lamps, of_faces, of_world]).astype(np.float64)
        self.chance = select.probabilities(self.power)
        self.names = tuple(lamp.data.name for lamp in shining)
        self.real = np.array([lamp.data.real for lamp in shining], np.bool_)
        self.lamps = len(shining)
        self.may_take_light = any(lamp.shader or (lamp.strength < 0.0).any() for lamp in shining)

        self._lamps = lamp_parts(shining, self.chance)
        self._parts: list[Part] = [*self._lamps]
        self._faces = faces
        if faces is not None:
            faces.choose_with(self.chance[self.lamps : self.lamps + len(of_faces)])
            self._parts += faces.parts
        self._environment: EnvironmentPart | None = None
        self._without_sky: Lights | None = None
        if environment is not None:
            self._environment = EnvironmentPart(environment, float(self.chance[-1]))
            self._parts.append(self._environment)
            if environment.constant is not None:
                more = scene_radius, shaders, surfaces, shown
                self._without_sky = Lights(lamps, lamp_strength, origin, triangles, None, *more)
        self._prepare_choice()
        self.by_place = local_choice(shining, faces, self.power, self.chance, radius, surfaces)
        self._crowd = crowd(shining, self._lamps, self._first.tolist(), radius, surfaces)
        self.description = self._describe(shining)
        shown = shown or Shown()
        of_lamps_and_faces = [lamp.data.light_group for lamp in shining], self.whose_faces() >> 32
        groups = np.concatenate([*of_lamps_and_faces, [shown.world_group] * len(of_world)]).astype(np.int32)
        self.light_group = groups if groups.any() else None
        world = shown.world if environment is not None else None
        self.restrictions: Restrictions | None = restrictions(
            shining, faces, world, shown.linking, shown.apart
        )

    def whose_faces(self) -> NDArray[np.int64]:
        """(F,) `TriangleEmitters.whose` of each emissive face."""
        return np.zeros(0, np.int64) if self._faces is None else self._faces.whose()

    def compensated(self) -> Lights:
        """The same lights for estimators that also find them by BSDF sampling and weigh both by MIS.

        Of a sky that is the same everywhere nothing exceeds the mean: it is left to BSDFs, as in Cycles.
        """
        if self._without_sky is not None:
            return self._without_sky
        if self._environment is None:
            return self
        lights = copy.copy(self)
        part = EnvironmentPart(self._environment.environment.compensated, self._environment.chance)
        lights._environment, lights._parts = part, [*self._parts[:-1], part]
        return lights

    def make_ready(self) -> None:
        """Make now the tables of the choice by place; most estimators combine."""
        if (choice := self.compensated().by_place) is not None:
            choice.make_ready()

    def changed(self, change: Callable[[Lights], None]) -> Lights:
        """A copy that was changed, also as estimators that combine see it."""
        lights = copy.copy(self)
        change(lights)
        if self._without_sky is not None:
            lights._without_sky = self._without_sky.changed(change)
        return lights

    def _prepare_choice(self) -> None:
        """The alias table over all emitters, and where each part's numbers begin."""
        count = [part.count for part in self._parts]
        self._first = np.cumsum([0, *count])[:-1]
        self._part_of = np.repeat(np.arange(len(count), dtype=np.uint8), count)
        self._alias = AliasTable(self.chance) if self.power.size > 1 else None

    def _describe(self, lamps: Sequence[Lamp]) -> Description:
        """What there is."""
        kinds = [lamp.data.kind.lower() for lamp in lamps]
        counts: dict[str, int] = {kind: kinds.count(kind) for kind in LAMPS if kind in kinds}
        if self._faces is not None:
            counts["triangle"] = self._faces.triangles
        if self._environment is not None:
            counts["environment"] = 1
        delta = [part.delta for part in self._parts]
        return Description(
            counts=counts,
            has_delta=any(delta),
            all_delta=bool(delta) and all(delta),
            has_triangles=self._faces is not None,
            meets_lamps=any(not part.delta for part in self._lamps),
            camera_meets_lamps=any(any(part.camera) for part in self._lamps),
        )

    def sample(self, p: Float32, n: Float32, u: Uniforms) -> LightSample:
        """Choose an emitter for each reference point and draw a direction toward it.

        Parameters
        ----------
        p : (3, N) float32
            Reference points, where shadow rays start.
        n : (3, N) float32
            Normals that face the viewer; used where the choice is by place.
        u : (3, N) float32
            Uniforms in [0, 1): the choice, then two for the emitter.
        """
        if not self._parts:
            return _nothing(p)
        if self._alias is None:
            part = self._parts[0]
            return _light_sample(part.sample(None, p, u[1], u[2]), part.delta, 0)
        if self.by_place is not None:
            return self._sample_by_place(self.by_place, p, n, u)
        chosen = self._alias.sample(u[0])[0]
        return self._sample_chosen(chosen, p, u)

    @stage("", "light choice by place")
    def _sample_by_place(self, local: LocalChoice, p: Float32, n: Float32, u: Uniforms) -> LightSample:
        """The parts' tables hold each emitter's probability by power; what it is here corrects that."""
        place = local.place(p, n)
        chosen, ratio = local.sample(place, u[0])
        light = self._sample_chosen(chosen, p, u)
        return light._replace(weight=light.weight / ratio, pdf=light.pdf * ratio, place=place)

    def _sample_chosen(self, chosen: NDArray[np.int32], p: Float32, u: Uniforms) -> LightSample:
        """A direction toward emitter `chosen` (N,) of each lane."""
        if len(self._parts) == 1:
            part = self._parts[0]
            return _light_sample(part.sample(chosen.astype(np.intp), p, u[1], u[2]), part.delta, chosen)
        return self._sample_mixed(chosen, p, u)

    def _sample_mixed(self, chosen: NDArray[np.int32], p: Float32, u: Uniforms) -> LightSample:
        """Each part samples the lanes that have chosen it."""
        lanes_total = p.shape[1]
        wo, weight = np.empty_like(p), np.empty_like(p)
        distance, pdf = np.empty(lanes_total, np.float32), np.empty(lanes_total, np.float32)
        delta = np.zeros(lanes_total, np.bool_)
        extras: list[tuple[Index, Index, Float32]] = []
        part_of = self._part_of.take(chosen, mode="clip")
        for number, part in enumerate(self._parts):
            lanes = np.flatnonzero(part_of == number)
            if not lanes.size:
                continue
            row = None if part.count == 1 else chosen.take(lanes) - self._first[number]
            draw = part.sample(row, p.take(lanes, axis=1), u[1].take(lanes), u[2].take(lanes))
            for axis in range(3):
                wo[axis][lanes], weight[axis][lanes] = draw.wo[axis], draw.weight[axis]
            distance[lanes], pdf[lanes] = draw.distance, draw.pdf
            if part.delta:
                delta[lanes] = True
            if draw.varying.size:
                extras.append((lanes.take(draw.varying), draw.triangle, draw.barycentric))
        mixed = self.description.has_delta and not self.description.all_delta
        is_delta = delta if mixed else self.description.all_delta
        varying = extras[0] if extras else (NO_LANES, NO_LANES, NO_BARYCENTRIC)
        return LightSample(wo, distance, weight, pdf, is_delta, chosen, *varying)

    def pdf_triangle(
        self, triangle: NDArray[np.integer], t: Float32, cos_light: Float32, place: Places = None
    ) -> Float32:
        """(N,) density with which `sample` draws the ray that met emissive triangle `triangle`.

        Parameters
        ----------
        triangle : (N,) int
            Row of `TriangleEmitters`.
        t : (N,) float32
            Distance from the reference point.
        cos_light : (N,) float32
            |cos| between the ray and the triangle's geometric normal.
        place : (N,) int32 or None
            `LightSample.place` of the reference points.
        """
        if self._faces is None:
            return np.zeros(t.shape, np.float32)
        pdf = self._faces.pdf(triangle, t, cos_light)
        if self.by_place is not None and place is not None:
            pdf *= self.by_place.ratio(place, self.lamps + self._faces.number(triangle))
        return pdf

    def environment_pdf(self, d: Float32, place: Places = None) -> Float32:
        """(N,) density with which `sample` draws directions d (3, N) toward the environment."""
        if self._environment is None:
            return np.zeros(d.shape[1], np.float32)
        pdf = self._environment.pdf(d)
        if self.by_place is not None and place is not None:
            pdf = pdf * self.by_place.ratio(place, np.full(len(place), len(self.power) - 1))
        return pdf

    def intersect(
        self,
        o: Float32,
        d: Float32,
        t: Float32,
        camera: bool | NDArray[np.bool_] | None = None,
        place: Places = None,
        ways: Ways | None = None,
    ) -> Iterator[Hits]:
        """What rays o + s·d, 0 < s < t, gather of lamps; suns only where t ≥ 10³⁰ (nothing was hit).

        Parameters
        ----------
        o, d : (3, N) float32
            World space, d unit.
        t : (N,) float32
            Distance of the hit, inf where there is none.
        camera : bool, (N,) bool or None
            Which rays are the camera's: they see the lamps that are visible to it (with MIS weight 1,
            for nothing else could have found them), all others those that have MIS.
        place : (N,) int32 or None
            `LightSample.place` of the reference points.
        ways : Ways or None
            How the rays came, where `restrictions` ask.

        Yields
        ------
        Hits : lanes (k,), all different, radiance (3, k), pdf (k,).
        """
        if camera is None or isinstance(camera, bool):
            if self.description.are_met(bool(camera)):
                yield from self._met(o, d, t, bool(camera), place, ways)
            return
        for of_camera in (True, False):
            wanted = self.description.are_met(of_camera)
            lanes = np.flatnonzero(camera if of_camera else ~camera) if wanted else NO_LANES
            if not lanes.size:
                continue
            subset = o.take(lanes, axis=1), d.take(lanes, axis=1), t.take(lanes)
            there = None if place is None else place.take(lanes)
            came = None if ways is None else ways.take(lanes)
            for hits in self._met(*subset, of_camera, there, came):
                yield hits._replace(lanes=lanes.take(hits.lanes))

    def _met(
        self, o: Float32, d: Float32, t: Float32, of_camera: bool, place: Places, ways: Ways | None
    ) -> Iterator[Hits]:
        """What camera rays, or all others, meet of all lamps."""
        for part, first in zip(self._lamps, self._first, strict=False):
            if self._crowd is None or not part.boxed:
                for row, hits in zip(part.rows(of_camera), part.hits(o, d, t, of_camera), strict=True):
                    if hits.lanes.size:
                        yield self._here(hits, int(first) + row, place, ways)
        if self._crowd is not None:
            for number, hits in self._crowd.hits(o, d, t, of_camera):
                yield self._here(hits, number, place, ways)

    def _here(self, hits: Hits, number: int | Index, place: Places, ways: Ways | None) -> Hits:
        """What of it reaches the rays, with the density of a choice by place."""
        if self.restrictions is not None and ways is not None and hits.lanes.size:
            lit = self.restrictions.met(number, ways.take(hits.lanes))
            hits = hits._replace(radiance=hits.radiance * lit)
        if self.light_group is not None:
            hits = hits._replace(group=self.light_group[number])
        if self.by_place is None or place is None or not hits.lanes.size:
            return hits
        ratio = self.by_place.ratio(place.take(hits.lanes), np.broadcast_to(number, hits.lanes.shape))
        return hits._replace(pdf=hits.pdf * ratio)


def _resolve(data: LightData, factor: Float64, shader: LampShader | None, origin: Float64) -> Lamp:
    """A lamp with its strength and its place."""
    strength = np.asarray(data.color, np.float64) * float(data.power) * factor
    return Lamp(data, strength, np.asarray(data.matrix, np.float64)[:3, 3] - origin, shader)


def _light_sample(draw: Draw, delta: bool, emitter: int | NDArray[np.int32]) -> LightSample:
    """A draw that needed no dispatch."""
    return LightSample(*draw[:4], delta, emitter, *draw[4:])


def _nothing(p: Float32) -> LightSample:
    """Samples of a scene without emitters."""
    up = np.zeros_like(p)
    up[2] = 1.0
    zero = np.zeros(p.shape[1], np.float32)
    return LightSample(up, np.full_like(zero, FAR), np.zeros_like(p), zero, False, -1)
