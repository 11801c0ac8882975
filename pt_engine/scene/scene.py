"""The prepared scene: what integrators talk to.

`prepare` compiles a snapshot once; a `Scene` is then only read, so worker threads share it. Its methods
are the terms of the rendering equation over a wavefront of lanes.
"""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Iterator
from itertools import starmap
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.raykind import RayKind
from ..core.uniforms import Uniforms
from ..core.view import View
from ..emitters.lights import Lights, LightSample
from .accel import FAR, Accel, Hits
from .arrivals import Arrivals
from .attributes import Layer
from .geometry import SKY, Geometry
from .holdout import cut_holes
from .lanes import Lanes, Surface
from .shading import ShadedBSDF, SliceBSDF
from .sky_lanes import SkyLanes
from .snapshot import Instances
from .transforms import Transforms
from .transmittance import transmittance

if TYPE_CHECKING:
    from ..cameras.base import Camera
    from ..nodes.compile import Materials
    from ..nodes.coverage import Coverage
    from ..nodes.world import WorldProgram
    from ..render.path_state import PathState
    from ..textures.images import TextureStore
    from .own import OwnObjects

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
BatchNumbers = NDArray[np.unsignedinteger]


DEPTHS = frozenset({"diffuse_depth", "glossy_depth", "transmission_depth", "portal_depth"})


class Rays(NamedTuple):
    """N rays. `tfar` < 0 switches one off.

    Attributes
    ----------
    o, d : (3, N) float32
        Origin (recentred world) and unit direction.
    tfar : (N,) float32
    """

    o: Float32
    d: Float32
    tfar: Float32


class Found(NamedTuple):
    """Lanes whose ray found an emitter.

    Attributes
    ----------
    lanes : (K,) intp
    radiance : (3, K) float32
    pdf : (K,) float32
        Density per solid angle with which emitter sampling would have chosen this direction.
    source : str
        "sky", "surface" or "lamp".
    """

    lanes: NDArray[np.intp]
    radiance: Float32
    pdf: Float32
    source: str = "lamp"


class Intersection(NamedTuple):
    """What N rays have hit: `accel.Hits`, and the surface number (the sky's for a miss).

    Attributes
    ----------
    hits : Hits
    surface : (N,) unsigned int
    """

    hits: Hits
    surface: NDArray[np.integer]


class Group(NamedTuple):
    """Lanes that are shaded together: a batch of materials, on flat or on smooth geometry."""

    batch: int
    smooth: bool


class Scene:
    """See the module. Built by `prepare`."""

    camera: Camera
    view: View
    exposure: float = 1.0
    pixel_angle: float = 1e-3  # width of a pixel at distance 1
    lights_without_shadow: bool
    features: dict[str, str]
    textures: TextureStore
    coverage: list[Coverage]
    build_seconds: float
    emissive_prim: Int32
    own: OwnObjects | None = None  # where some material traces rays within its own object
    material_names: tuple[str, ...]

    def __init__(
        self,
        geometry: Geometry,
        accel: Accel,
        instances: Instances,
        layers: dict[tuple[str, str], Layer],
        materials: Materials,
        world: WorldProgram,
        lights: Lights,
        film_transparent: bool = False,
    ) -> None:
        self.geometry, self.accel, self.instances = geometry, accel, instances
        self.materials, self.world, self.lights = materials, world, lights
        self.origin32 = geometry.origin.astype(np.float32)[:, None]
        self.transforms = Transforms(instances.matrix, geometry.origin)
        self._layers = layers
        self.normals = layers.get(("normal", ""))
        self.film_transparent = film_transparent
        self.has_emitters = lights.description.total > 0
        self.used_materials = np.unique(geometry.surface_material[1:])
        self.used_batches = [materials.batches[b] for b in np.unique(materials.batch_of[self.used_materials])]
        self.rays: Counter[str] = Counter()
        self.alpha: Float32 | None = None
        self._make_groups()

    def with_pixels(self, width: int, height: int) -> Scene:
        """The same scene for an image of this size: how fine shading has to look (Bump's steps)."""
        scene, data = copy.copy(self), self.camera.data
        scene.camera = self.camera.at_resolution(width, height)
        if data.kind == "PERSP":
            scene.pixel_angle = (data.frame[1] - data.frame[0]) / width
        elif data.kind == "PANO":
            scene.pixel_angle = 2 * np.pi / width
        return scene

    def for_unit(self, lanes: int) -> Scene:
        """The same scene with a ray count and, where the film may be clear, a coverage per ray of its own."""
        scene = copy.copy(self)
        scene.rays = Counter()
        scene.alpha = np.ones(lanes, np.float32) if self.film_transparent or self.holds_out else None
        return scene

    def _make_groups(self) -> None:
        """Number the groups, those with more than Dirac lobes first, and the surfaces that belong to each."""
        batches, surfaces = self.materials.batches, self.geometry
        pairs = {
            Group(int(self.materials.batch_of[m]), bool(s))
            for m, s in zip(surfaces.surface_material, surfaces.surface_smooth, strict=True)
            if m >= 0 and batches[self.materials.batch_of[m]].has_bsdf
        }
        self.groups = sorted(pairs, key=lambda g: (batches[g.batch].delta_only, g.batch, g.smooth))
        self.dead = len(self.groups)  # the group of lanes that go no further
        self.smooth_groups = sum(not batches[g.batch].delta_only for g in self.groups)
        number = {g: k for k, g in enumerate(self.groups)}
        self._group_of_surface: BatchNumbers = np.array(
            [
                self.dead if m < 0 else number.get(Group(int(self.materials.batch_of[m]), bool(s)), self.dead)
                for m, s in zip(surfaces.surface_material, surfaces.surface_smooth, strict=True)
            ],
            np.uint8 if self.dead < 255 else np.uint16,
        )
        emits = self.materials.emission_varies | (self.materials.emission_constant != 0).any(axis=1)
        self._surface_emits = (surfaces.surface_material >= 0) & emits[surfaces.surface_material]
        holds_out = np.array([batch.has_holdout for batch in batches], np.bool_)
        self.surface_holds_out = (surfaces.surface_material >= 0) & holds_out[
            self.materials.batch_of[surfaces.surface_material]
        ]
        self.holds_out = bool(self.surface_holds_out.any())
        passes = [batches[g.batch].has_transparency or batches[g.batch].has_portal for g in self.groups]
        self.has_portals = any(batches[g.batch].has_portal for g in self.groups)
        self.passes = np.array([*passes, False])
        self.transparent_surfaces = any(passes)
        needs = self.world.needs.union(*(batch.needs for batch in self.used_batches))
        self.tracked_depths = tuple(sorted(needs & DEPTHS))
        reads_path = bool(needs & {"ray_kind", "depth", "transparent_depth"} or self.tracked_depths)
        # without these, nobody asks what became of a path before
        self.extra_history = needs & {"footprint", "sharpness"}
        asks = reads_path or bool(self.extra_history) or self.lights.by_place is not None
        self.tracks_history = self.transparent_surfaces or asks
        self._looks_around = "traced" in needs

    def layer(self, kind: str, name: str) -> Layer:
        """A shading attribute that some program was found to need when the scene was prepared."""
        return self._layers[kind, name]

    def history(self, rays: Rays) -> dict[str, NDArray[Any]]:
        """What somebody asks of camera paths, beside what `PathState` knows itself."""
        none = np.zeros(rays.d.shape[1], np.int32)
        rows: dict[str, NDArray[Any]] = {name: none.copy() for name in self.tracked_depths}
        if "footprint" in self.extra_history:
            rows["radius"], rows["spread"] = self.camera.footprint(rays.d)
        if "sharpness" in self.extra_history:
            rows["sharpness"] = np.full(rays.d.shape[1], np.inf, np.float32)
        return rows

    # ------------------------------------------------------------------ the ray's end

    def intersect(self, rays: Rays, kind: str = "") -> Intersection:
        """Closest hits of all rays; one that is switched off misses. `kind` is for the count."""
        self.rays[kind or ("bounce" if self.rays else "camera")] += int(np.count_nonzero(rays.tfar > 0))
        hits = self.accel.intersect(rays.o, rays.d, rays.tfar)
        return Intersection(hits, self.geometry.surface.take(hits.prim, mode="wrap"))

    def surface(self, rays: Rays, found: Intersection, lanes: NDArray[np.intp]) -> Surface:
        """The hit points of some lanes, in the order of `lanes`."""
        o, d = rays.o.take(lanes, axis=1), rays.d.take(lanes, axis=1)
        return Surface(self.geometry, found.hits, lanes, o, d)

    def batch(self, found: Intersection) -> BatchNumbers:
        """Each lane's group number; `dead` where the ray left the scene or the surface only emits."""
        group: BatchNumbers = self._group_of_surface.take(found.surface)
        return group

    # ------------------------------------------------------------------ emission found by a ray

    def emission(self, rays: Rays, found: Intersection, path: PathState) -> Iterator[Found]:
        """What the rays have run into: the sky, emissive surfaces, lamps."""
        if self.world.emits or self.film_transparent:
            escaped = np.flatnonzero(found.surface == SKY)
            escaped = escaped[rays.tfar.take(escaped) > 0]
            if self.film_transparent:
                escaped = self._leave_film_clear(escaped, path)
            if len(escaped):
                d = rays.d.take(escaped, axis=1)
                o = rays.o.take(escaped, axis=1) + self.origin32 if self.view.kind == "ORTHO" else None
                sky = self.world.emission(SkyLanes(d, self._came(path, escaped), self.view, o))
                yield Found(escaped, sky, self.lights.environment_pdf(d, path.places(escaped)), "sky")
        if self.lights.description.meets_lamps or self.lights.description.camera_meets_lamps:
            yield from self._lamp_emission(rays, found, path)
        if self.holds_out:  # after the lamps before a holdout, ahead of what it covers
            cut_holes(self, rays, found, path)
        if self.lights.description.has_triangles:
            lit = np.flatnonzero(self._surface_emits.take(found.surface))
            if len(lit):
                yield self._surface_emission(lit, self.surface(rays, found, lit), path)

    def _came(self, path: PathState, lanes: NDArray[np.intp]) -> Arrivals:
        """How the rays of some lanes came here; all alike where nobody follows them."""
        if self.tracks_history or self._looks_around:
            return Arrivals.of(path, lanes)
        return Arrivals.by(int(path.kind[0]), len(lanes))

    def _leave_film_clear(self, escaped: NDArray[np.intp], path: PathState) -> NDArray[np.intp]:
        """Camera rays that reach the sky take their share off the film's coverage and bring no light."""
        seen = (path.kind.take(escaped) & RayKind.CAMERA) != 0
        clear = escaped[seen]
        if self.alpha is not None:
            self.alpha[path.slot.take(clear)] -= vectors.mean3(path.beta.take(clear, axis=1))
        others: NDArray[np.intp] = escaped[~seen]
        return others

    def _surface_emission(self, lit: NDArray[np.intp], hit: Surface, path: PathState) -> Found:
        distance = hit.t + path.travelled.take(lit) if self.transparent_surfaces else hit.t
        pdf = self.lights.pdf_triangle(hit.emitter, distance, np.abs(hit.facing), path.places(lit))
        return Found(lit, self._radiance(hit, path, lit), pdf, "surface")

    def _radiance(self, hit: Surface, path: PathState, lanes: NDArray[np.intp]) -> Float32:
        """(3, K) emitted toward `wi`: a table where it is constant, else the materials' programs."""
        material = self.geometry.surface_material.take(hit.surface)
        radiance = np.ascontiguousarray(self.materials.emission_constant.take(material, axis=0).T)
        varying = np.flatnonzero(self.materials.emission_varies.take(material))
        if len(varying):
            radiance[:, varying] = self._evaluated(
                hit.take(varying), self._came(path, lanes.take(varying)), material.take(varying)
            )
        return radiance

    def evaluated_holdout(self, hit: Surface, path: PathState, lanes: NDArray[np.intp]) -> Float32:
        """(3, K) share of what the camera sees that the materials make a hole in the film."""
        material = self.geometry.surface_material.take(hit.surface)
        return self._evaluated(hit, Arrivals.of(path, lanes), material, "holdout")

    def _evaluated(self, hit: Surface, came: Arrivals, material: Int32, what: str = "emission") -> Float32:
        """(3, K) what the materials' programs give for `emission` or `holdout`."""
        radiance = np.zeros((3, hit.size), np.float32)
        smooth = self.geometry.surface_smooth.take(hit.surface)
        key = self.materials.batch_of.take(material) * 2 + smooth
        for k in np.unique(key):
            lanes = np.flatnonzero(key == k)
            here = Lanes(self, hit.take(lanes), came.take(lanes), bool(k & 1))
            value = getattr(self.materials.batches[int(k) >> 1], what)(here)
            if value is not None:
                radiance[:, lanes] = value
        return radiance

    def _lamp_emission(self, rays: Rays, found: Intersection, path: PathState) -> Iterator[Found]:
        """Lamps of any size that lie on the ray before its hit; they don't hide what is behind them."""
        t = np.where(found.surface == SKY, FAR, found.hits.t)
        t[rays.tfar < 0] = -1
        seen = (path.kind & RayKind.CAMERA) != 0
        if not self.transparent_surfaces:
            camera: bool | NDArray[np.bool_] = bool(seen[:1].any())  # all lanes are of one generation
            met = self.lights.intersect(rays.o, rays.d, t, camera, path.places(slice(None)))
            yield from starmap(Found, met)
            return
        # densities count from the last real bounce, but only what lies beyond the surfaces passed is new
        back = path.travelled
        o = rays.o - back * rays.d
        yield from starmap(Found, self.lights.intersect(o, rays.d, t + back, seen, path.place))

    def shading_normal(self, rays: Rays, found: Intersection) -> Float32:
        """(3, N) unit shading normals on the viewer's side; 0 where a ray has missed."""
        normal = np.zeros(rays.o.shape, np.float32)
        hit = np.flatnonzero(found.surface != SKY)
        smooth = self.geometry.surface_smooth.take(found.surface.take(hit))
        for part, curved in ((hit[~smooth], False), (hit[smooth], True)):
            if len(part):
                came = Arrivals.by(RayKind.CAMERA, len(part))
                normal[:, part] = Lanes(self, self.surface(rays, found, part), came, curved).ns
        return normal

    # ------------------------------------------------------------------ scattering

    def shade(self, si: Surface, path: PathState, spans: list[tuple[int, slice]]) -> ShadedBSDF:
        """The closures of each group on its span of lanes."""
        slices = []
        smooth_count = 0
        for number, span in spans:
            group = self.groups[number]
            lanes = Lanes(self, si.part(span), path.part(span), group.smooth)
            closures = self.materials.batches[group.batch].closures(lanes)
            slices.append((span, SliceBSDF(closures, lanes)))
            if number < self.smooth_groups:
                smooth_count = span.stop
        return ShadedBSDF(si.size, slices, smooth_count)

    # ------------------------------------------------------------------ next-event estimation

    def sample_emitter(self, si: Surface, u: Uniforms, path: PathState) -> LightSample:
        """One emitter and a point on it per lane; the weight is Le/pdf."""
        light = self.lights.sample(si.p, si.ng, u)
        path.chooses_light_at(light.place)
        if len(light.varying):
            light.weight[:, light.varying] *= self._radiance_at(light, si, path)
        return light

    def _radiance_at(self, light: LightSample, si: Surface, path: PathState) -> Float32:
        """Le of sampled points on triangles whose emission varies, toward the reference points."""
        lanes = light.varying
        wo = light.wo.take(lanes, axis=1)
        distance = light.distance.take(lanes)
        prim = self.emissive_prim.take(light.triangle)
        hits = Hits(distance, light.barycentric[0], light.barycentric[1], prim)
        at = Surface(self.geometry, hits, np.arange(len(lanes)), si.p.take(lanes, axis=1), wo)
        before = self._came(path, lanes)
        through = vectors.dot(si.ng.take(lanes, axis=1), wo) < 0
        point = np.zeros(len(lanes), np.float32)  # a sampled place has no width; nodes trace nothing there
        side = np.where(through, np.int32(RayKind.TRANSMISSION), np.int32(RayKind.REFLECTION))
        came = before._replace(  # the ray stands for all closures; it is taken as a diffuse one
            kind=side | RayKind.DIFFUSE,
            depth=before.depth + 1,
            diffuse_depth=before.diffuse_depth + ~through,
            transmission_depth=before.transmission_depth + through,
            travelled=point,
            radius=point,
            spread=point,
            sharpness=None,
            noise=None,
        )
        return self._evaluated(at, came, self.geometry.surface_material.take(at.surface))

    def unoccluded(
        self, si: Surface, light: LightSample, contribution: Float32, limit: int, path: PathState
    ) -> Float32:
        """`contribution` where nothing lies between; dimmed by up to `limit` transparent surfaces."""
        lit = vectors.max3(np.abs(contribution)) != 0  # negative ones too; NaN is not hidden
        tfar = light.distance * lit - ~lit  # −1 switches a ray off
        side = np.copysign(si.bound, vectors.dot(si.ng, light.wo))
        o = si.p + side * si.ng
        free = np.flatnonzero(light.distance < 0) if self.lights_without_shadow else None
        kept = None if free is None else contribution.take(free, axis=1)
        if self.transparent_surfaces:
            contribution *= transmittance(self, o, light.wo, tfar, limit, path)
        else:
            self.rays["shadow"] += int(np.count_nonzero(tfar > 0))
            contribution.view(np.int32)[:] &= self.accel.visible(o, light.wo, tfar)
        if kept is not None:
            contribution[:, free] = kept
        return contribution
