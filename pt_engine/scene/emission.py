"""Emission that rays run into: the sky, emissive surfaces, lamps; what a film leaves clear."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.clock import stage
from ..core.raykind import RayKind
from .accel import FAR
from .catcher import catch, note_sky
from .evaluated import evaluated
from .geometry import SKY
from .holdout import cut_holes, held
from .reach import lit_by_surfaces, sees_world, ways
from .sky_lanes import SkyLanes
from .surface import Surface
from .wave import Found, Intersection, Rays

if TYPE_CHECKING:
    from ..render.path_state import PathState
    from .scene import Scene

Float32 = NDArray[np.float32]


@stage("emission")
def found_by(scene: Scene, rays: Rays, found: Intersection, path: PathState) -> Iterator[Found]:
    """What the rays have run into: the sky, emissive surfaces, lamps."""
    if scene.world.emits or scene.film_transparent:
        escaped = np.flatnonzero(found.surface == SKY)
        escaped = escaped[rays.tfar.take(escaped) > 0]
        if scene.film_transparent:
            escaped = _leave_film_clear(scene, escaped, path)
        if len(escaped):
            d = rays.d.take(escaped, axis=1)
            o = rays.o.take(escaped, axis=1) + scene.origin32 if scene.view.kind == "ORTHO" else None
            sky = scene.world.emission(SkyLanes(d, scene.came(path, escaped), scene.view, o))
            if scene.reach.hidden:
                sky = sky * sees_world(scene, path, escaped)
            pdf = scene.lights.environment_pdf(d, path.places(escaped))
            reached = Found(escaped, sky, pdf, scene.reach.world_group, "sky", scene.by_group)
            if scene.caught is not None:
                note_sky(scene.caught, reached, path)
            yield reached
    if scene.lights.description.meets_lamps or scene.lights.description.camera_meets_lamps:
        yield from _lamp_emission(scene, rays, found, path)
    if scene.holds_out:  # after the lamps before a holdout, ahead of what it covers
        cut_holes(scene, rays, found, path)
    if scene.caught is not None:
        catch(scene, scene.caught, rays, found, path)
    if not scene.emitting.empty:
        lit = np.flatnonzero(scene.emitting.has(found.surface))
        if scene.held is not None:
            lit = lit[~held(scene.held, path.clear.take(lit), scene.geometry.instance_of(found.hits, lit))]
        if len(lit):
            yield _surface_emission(scene, lit, scene.surface(rays, found, lit), path)


def _leave_film_clear(scene: Scene, escaped: NDArray[np.intp], path: PathState) -> NDArray[np.intp]:
    """Camera rays that reach the sky take their share off the film's coverage and bring no light."""
    seen = path.clear.take(escaped) != 0
    clear = escaped[seen]
    if scene.alpha is not None:
        scene.alpha[path.slot.take(clear)] -= vectors.mean3(path.beta.take(clear, axis=1))
    others: NDArray[np.intp] = escaped[~seen]
    return others


def _surface_emission(scene: Scene, lit: NDArray[np.intp], hit: Surface, path: PathState) -> Found:
    distance = hit.t + path.travelled.take(lit) if scene.transparent_surfaces else hit.t
    pdf = scene.lights.pdf_triangle(hit.emitter, distance, np.abs(hit.facing), path.places(lit))
    if scene.unsampled_surfaces:
        pdf *= hit.emitter >= 0
    radiance = _radiance(scene, hit, path, lit)
    if scene.reach.group is not None:
        radiance *= lit_by_surfaces(scene, hit, path, lit)
    groups = scene.instances.light_group
    group = 0 if groups is None else groups.take(hit.instance)
    return Found(lit, radiance, pdf, group, "surface", scene.by_group)


def _radiance(scene: Scene, hit: Surface, path: PathState, lanes: NDArray[np.intp]) -> Float32:
    """(3, K) emitted toward `wi`: a table where it is constant, else the materials' programs."""
    material = scene.geometry.surface_material.take(hit.surface)
    radiance = np.ascontiguousarray(scene.materials.emission_constant.take(material, axis=0).T)
    varying = np.flatnonzero(scene.materials.emission_varies.take(material))
    if len(varying):
        radiance[:, varying] = evaluated(
            scene, hit.take(varying), scene.came(path, lanes.take(varying)), material.take(varying)
        )
    return radiance


@stage("emission", "lamps met by rays")
def _lamp_emission(scene: Scene, rays: Rays, found: Intersection, path: PathState) -> Iterator[Found]:
    """Lamps of any size that lie on the ray before its hit; they don't hide what is behind them."""
    camera = bool(path.kind_of_first & RayKind.CAMERA)  # so are all, unless surfaces are transparent
    if not scene.transparent_surfaces and not scene.lights.description.are_met(camera):
        return
    t = np.maximum(found.hits.t, (found.surface == SKY) * FAR)
    np.copysign(t, rays.tfar, out=t)  # rays that are off meet nothing
    came = ways(scene, path, slice(None))
    if not scene.transparent_surfaces:
        met = scene.lights.intersect(rays.o, rays.d, t, camera, path.places(slice(None)), came)
        yield from (Found(*hits, by_group=scene.by_group) for hits in met)
        return
    # densities count from the last real bounce, but only what lies beyond the surfaces passed is new
    back = path.travelled
    o = rays.o - back * rays.d
    seen = (path.kind & RayKind.CAMERA) != 0
    met = scene.lights.intersect(o, rays.d, t + back, seen, path.place, came)
    yield from (Found(*hits, by_group=scene.by_group) for hits in met)
