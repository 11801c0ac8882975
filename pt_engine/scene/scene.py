"""The prepared scene: what integrators talk to.

`prepare` compiles a snapshot once; a `Scene` is then only read, so worker threads share it. Its methods
are the terms of the rendering equation over a wavefront of lanes.
"""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..core import clock, vectors
from ..core.clock import stage
from ..core.raykind import RayKind
from ..core.subset import Subset
from ..core.uniforms import Uniforms
from ..core.view import View
from ..emitters.lights import Lights, LightSample
from . import emission, nearer, reach, tally
from .accel import Accel, Hits
from .arrivals import Arrivals
from .attributes import Layer
from .catcher import Caught, catchers_of
from .evaluated import evaluated
from .geometry import SKY, Geometry
from .holdout import held, only_transparent
from .lanes import Lanes
from .light_groups import GroupLight
from .reach import Reach
from .shading import ShadedBSDF, SliceBSDF
from .sighted import Sighted, sees_apart
from .snapshot import Instances, Visibility
from .surface import Surface
from .terminator import Terminator, aimed
from .transforms import Transforms
from .transmittance import transmittance
from .wave import Found, Group, Intersection, Rays

if TYPE_CHECKING:
    from ..cameras.base import Camera
    from ..nodes.compile import Materials
    from ..nodes.coverage import Coverage
    from ..nodes.world import WorldProgram
    from ..render.path_state import PathState
    from ..textures.images import TextureStore
    from .nearer import Nearer
    from .nested import Nested
    from .own import OwnObjects
    from .round_accel import RoundAccel
    from .slices import Slices

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
BatchNumbers = NDArray[np.unsignedinteger]


EVERYONE = Reach(0, None, None, None)
DEPTHS = frozenset({"diffuse_depth", "glossy_depth", "transmission_depth", "portal_depth"})


class Scene:
    """See the module. Built by `prepare`."""

    camera: Camera
    view: View
    exposure: float = 1.0
    of_one_view: bool = False  # whether its lights or shapes depend on the camera
    pixel_angle: float = 1e-3  # width of a pixel at distance 1
    lights_without_shadow: bool
    features: dict[str, str]
    textures: TextureStore
    coverage: list[Coverage]
    build_seconds: float
    bytes: int  # that it takes, about
    emissive_prim: Int32
    clear_glass: float = -1.0  # roughness up to which a transparent film shows through glass
    alone: Scene | None = None  # with shadow catchers alone, where there are any
    unsampled_surfaces: bool = False  # whether some that emit are no lights
    slices: Slices | None = None  # where something moves while the shutter is open
    time: float | None = None  # of a slice: between the shutter's opening (0) and closing (1)
    own: OwnObjects | None = None  # where some material traces rays within its own object
    light_angles: Float32 | None = None  # of each instance, where light on some fades (`terminator_shading`)
    terminator: Terminator | None = None  # where shadow rays of smooth meshes start above their triangles
    material_names: tuple[str, ...]
    light_groups: tuple[str, ...] = ()  # whose light is kept apart

    def __init__(
        self,
        geometry: Geometry,
        accel: Accel | Nearer | Nested | RoundAccel | Sighted,
        instances: Instances,
        layers: dict[tuple[str, str], Layer],
        materials: Materials,
        world: WorldProgram,
        lights: Lights,
        film_transparent: bool = False,
        reached: Reach = EVERYONE,
    ) -> None:
        self.geometry, self.accel, self.instances = geometry, accel, instances
        self.materials, self.world, self.lights = materials, world, lights
        self.origin32 = geometry.origin.astype(np.float32)[:, None]
        self.transforms = Transforms(instances.matrix, geometry.origin)
        self.layers: dict[tuple[str, str], Layer] = {}
        self.use_layers(layers)
        self.film_transparent, self.reach = film_transparent, reached
        self.used_materials = np.unique(geometry.surface_material[1:])
        self.used_batches = [materials.batches[b] for b in np.unique(materials.batch_of[self.used_materials])]
        self.rays: Counter[str] = Counter()
        self.alpha: Float32 | None = None
        self.caught: Caught | None = None
        self.by_group: GroupLight | None = None
        self._make_groups()

    def with_pixels(self, width: int, height: int) -> Scene:
        """The same scene for an image of this size: how fine shading has to look (Bump's steps)."""
        scene, data = copy.copy(self), self.camera.data
        scene.camera = self.camera.at_resolution(width, height)
        scene.view = self.view.with_pixels(width, height)
        if data.kind == "PERSP":
            scene.pixel_angle = (data.frame[1] - data.frame[0]) / width
        elif data.kind == "PANO":
            scene.pixel_angle = 2 * np.pi / width
        return scene

    def with_compensated_lights(self) -> Scene:
        """The same scene for integrators that combine emitter and BSDF sampling (`Lights.compensated`)."""
        scene = copy.copy(self)
        scene.lights = self.lights.compensated()
        return scene

    def for_unit(self, lanes: int) -> Scene:
        """The same scene with a ray count and, where the film may be clear, a coverage per ray of its own."""
        scene = copy.copy(self)
        scene.rays = Counter()
        clear = self.film_transparent or self.holds_out or self.has_catchers
        scene.alpha = np.ones(lanes, np.float32) if clear else None
        scene.caught = Caught(lanes) if self.has_catchers else None
        if self.light_groups:
            scene.by_group = GroupLight(len(self.light_groups), lanes, scene.caught)
        return scene

    def show_through(self, roughness: float) -> None:
        """Let a transparent film show through glass of up to this roughness."""
        self.clear_glass, self.tracks_history = roughness, True

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
        self._ends = Subset(self._group_of_surface == self.dead)
        emits = self.materials.emits
        self.surface_emits = (surfaces.surface_material >= 0) & emits[surfaces.surface_material]
        self.emitting = Subset(self.surface_emits)
        holds_out = np.array([batch.has_holdout for batch in batches], np.bool_)
        self.surface_holds_out = (surfaces.surface_material >= 0) & holds_out[
            self.materials.batch_of[surfaces.surface_material]
        ]
        objects = (self.instances.visibility & Visibility.HOLDOUT) != 0
        self.catchers = catchers_of(self.instances)
        self.has_catchers = bool(self.catchers.any())
        self.held = objects if objects.any() else None
        self.holds_out = bool(self.surface_holds_out.any() or objects.any())
        passes = [batches[g.batch].has_transparency or batches[g.batch].has_portal for g in self.groups]
        self.has_portals = any(batches[g.batch].has_portal for g in self.groups)
        self.one_sided = not any(passes) and not any(batches[g.batch].transmits for g in self.groups)
        self.passes = np.array([*passes, False])
        self.transparent_surfaces = any(passes)
        needs = self.world.needs.union(*(batch.needs for batch in self.used_batches))
        self.tracked_depths = tuple(sorted(needs & DEPTHS))
        reads_path = bool(needs & {"ray_kind", "depth", "transparent_depth"} or self.tracked_depths)
        # without these, nobody asks what became of a path before
        self.extra_history = needs & {"footprint", "sharpness"}
        asks = reads_path or bool(self.extra_history) or self.lights.by_place is not None
        self.seen_apart = sees_apart(self.instances) or self.reach.apart is not None
        asks = asks or self.seen_apart or self.reach.hidden != 0
        asks = asks or self.has_catchers  # rays that see them alone are of kinds
        asks = asks or self.lights.restrictions is not None or self.reach.linking is not None
        self.tracks_history = self.transparent_surfaces or asks
        self._looks_around = bool(needs & {"traced", "random numbers"})

    def layer(self, kind: str, name: str) -> Layer:
        """A shading attribute that some program was found to need when the scene was prepared."""
        return self.layers[kind, name]

    def use_layers(self, layers: dict[tuple[str, str], Layer]) -> None:
        """Take these attribute tables in place of those of the same names."""
        self.layers = self.layers | layers
        self.normals = self.layers.get(("normal", ""))

    def history(self, rays: Rays) -> dict[str, NDArray[Any]]:
        """What somebody asks of camera paths, beside what `PathState` knows itself."""
        none = np.zeros(rays.d.shape[1], np.int32)
        rows: dict[str, NDArray[Any]] = {name: none.copy() for name in self.tracked_depths}
        if "footprint" in self.extra_history:
            rows["radius"], rows["spread"] = self.camera.footprint(rays.d)
        if "sharpness" in self.extra_history:
            rows["sharpness"] = np.full(rays.d.shape[1], np.inf, np.float32)
        if self.reach.linking is not None:
            rows["receiver"] = none - 1
        if self.clear_glass >= 0:
            rows["clear"] = none + 1
        return rows

    # ------------------------------------------------------------------ the ray's end

    @stage("surface")
    def intersect(self, rays: Rays, kind: str = "") -> Intersection:
        """Closest hits of all rays; one that is switched off misses. `kind` is for the count."""
        if not kind:
            clock.next_bounce()
        of_camera = isinstance(rays.kind, int) and rays.kind == RayKind.CAMERA
        self.rays[kind or ("camera" if of_camera else "bounce")] += int(np.count_nonzero(rays.tfar > 0))
        if self.seen_apart or rays.strand is not None:
            hits = nearer.closest(self.accel, *rays)
        else:
            hits = self.accel.intersect(rays.o, rays.d, rays.tfar)
        return Intersection(hits, self.geometry.surface.take(hits.prim, mode="wrap"))

    @stage("surface")
    def surface(self, rays: Rays, found: Intersection, lanes: NDArray[np.intp]) -> Surface:
        """The hit points of some lanes, in the order of `lanes`."""
        o, d = (row.take(lanes, axis=1, mode="wrap") for row in (rays.o, rays.d))
        return Surface(self.geometry, found.hits, lanes, o, d, found.surface)

    @stage("surface")
    def batch(self, found: Intersection) -> BatchNumbers:
        """Each lane's group number; `dead` where the ray left the scene or the surface only emits."""
        if self.dead == 1:
            return self._ends.has(found.surface).view(np.uint8)
        group: BatchNumbers = self._group_of_surface.take(found.surface, mode="wrap")
        return group

    # ------------------------------------------------------------------ emission found by a ray

    def emission(self, rays: Rays, found: Intersection, path: PathState) -> Iterator[Found]:
        """What the rays have run into: the sky, emissive surfaces, lamps."""
        return emission.found_by(self, rays, found, path)

    def came(self, path: PathState, lanes: NDArray[np.intp]) -> Arrivals:
        """How the rays of some lanes came here; all alike where nobody follows them."""
        if self.tracks_history or self._looks_around:
            return Arrivals.of(path, lanes)
        return Arrivals.by(path.kind_of_first, len(lanes))

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

    @stage("shade")
    def shade(self, si: Surface, path: PathState, spans: list[tuple[int, slice]]) -> ShadedBSDF:
        """The closures of each group on its span of lanes."""
        tally.senders(self.geometry, si.surface)
        slices = []
        smooth_count = 0
        if self.terminator is not None:
            si.ns = si.ng.copy()
        for number, span in spans:
            group = self.groups[number]
            part = path.part(span)
            bsdf = self._shade_batch(Lanes(self, si.part(span), part, group.smooth), group.batch, part)
            if self.terminator is not None and group.smooth:
                si.ns[:, span] = bsdf.normal
            slices.append((span, bsdf))
            if number < self.smooth_groups:
                smooth_count = span.stop
        return ShadedBSDF(si.size, slices, smooth_count)

    @stage("shade", batch=lambda scene, lanes, number, path: number)
    def _shade_batch(self, lanes: Lanes, number: int, path: PathState) -> SliceBSDF:
        """The closures of one batch; who runs a clock gets the vertices of each material."""
        tally.vertices(self.geometry, number, lanes.si.surface)
        closures = self.materials.batches[number].closures(lanes)
        if self.held is not None:
            closures = only_transparent(closures, held(self.held, path.clear, lanes.si.instance))
        angles = None if self.light_angles is None else self.light_angles.take(lanes.si.instance)
        return SliceBSDF(closures, lanes, self.clear_glass, angles)

    def start(self, si: Surface, wo: Float32) -> Float32:
        """(3, N) where rays from surfaces toward `wo` start.

        Where no material lets light through, what leaves on the other side brings none, and all start above.
        Only with a terminator may the caller change them.
        """
        return si.above if self.one_sided and self.terminator is None else si.start(wo)

    # ------------------------------------------------------------------ next-event estimation

    @stage("emitter")
    def sample_emitter(self, si: Surface, u: Uniforms, path: PathState) -> LightSample:
        """One emitter and a point on it per lane; the weight is Le/pdf."""
        light = reach.restricted(self, self.lights.sample(si.p, si.ng, u), si, path)
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
        before = self.came(path, lanes)
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
        return evaluated(self, at, came, self.geometry.surface_material.take(at.surface))

    def unoccluded(
        self, si: Surface, light: LightSample, contribution: Float32, limit: int, path: PathState
    ) -> Float32:
        """`contribution` where nothing lies between; dimmed by up to `limit` transparent surfaces."""
        # negative ones too; NaN is not hidden
        lit = vectors.nonzero3(contribution).astype(np.float32)
        tfar = light.distance * lit
        lit -= 1
        tfar += lit  # −1 switches a ray off
        o, wo = self.start(si, light.wo), light.wo
        if self.terminator is not None:
            wo = self.terminator.lift(self, si, wo, o, tfar)
        if self.geometry.shared is not None:
            # their bounds are larger than emitters': a parallel ray would meet the emitter before its point
            near = si.on_shared & (tfar > 0)
            if self.terminator is not None:
                near &= (o == si.start(light.wo)).all(axis=0)  # it has aimed those that it has lifted
            lanes = np.flatnonzero(near)
            wo = aimed(wo, tfar, lanes, o.take(lanes, axis=1) - si.p.take(lanes, axis=1))
        tally.sent(self.geometry, si.surface, tfar)
        free = np.flatnonzero(light.distance < 0) if self.lights_without_shadow else None
        kept = None if free is None else contribution.take(free, axis=1)
        if self.transparent_surfaces:
            kind = reach.shadow_kind(self, light)
            contribution *= transmittance(self, o, wo, tfar, limit, path, kind, si.strand)
        else:
            self.rays["shadow"] += int(np.count_nonzero(tfar > 0))
            bits = contribution.view(np.int32)
            bits &= self._clear(o, wo, light, tfar, si.strand)
        if kept is not None:
            contribution[:, free] = kept
        return contribution

    def _clear(
        self, o: Float32, wo: Float32, light: LightSample, tfar: Float32, strand: Int32 | None
    ) -> Int32:
        if not self.seen_apart and strand is None:
            return self.accel.visible(o, wo, tfar)
        return nearer.clear(self.accel, o, wo, tfar, reach.shadow_kind(self, light), strand)
