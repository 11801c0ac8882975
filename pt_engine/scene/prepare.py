"""A snapshot becomes a scene: geometry placed, Embree built, materials compiled, emitters tabulated."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..cameras import make_camera
from ..core.view import View
from ..emitters.lights import Lights
from ..emitters.many import Surfaces
from ..emitters.triangle import TriangleEmitters
from ..nodes.compile import Materials, compile_materials
from ..nodes.coverage import IGNORED, Coverage
from ..nodes.world import compile_light, compile_world
from ..textures.images import TextureStore
from .accel import Accel
from .attributes import (
    Layer,
    attribute_layer,
    color_layer,
    generated_layer,
    normal_layer,
    position_layer,
    tangent_layer,
    uv_layer,
)
from .displace import displaced
from .features import features
from .geometry import BOUND, Geometry, pack, place
from .hulls import hulls, rounds_last
from .lamp_shader import LampShader
from .own import OwnObjects, looking_at_themselves
from .round_accel import RoundAccel
from .round_lanes import strand_layer
from .rounds import rounds_of
from .scene import Scene
from .snapshot import CameraData, Snapshot, Visibility
from .world_light import environment

Int32 = NDArray[np.int32]


def prepare(snapshot: Snapshot, film_transparent: bool = False, texture_memory: int = 0) -> Scene:
    """Compile a snapshot into what integrators render.

    Parameters
    ----------
    snapshot : Snapshot
    film_transparent : bool
    texture_memory : int
        Bytes that the texels of all images together may take; 0 for no limit.

    Raises
    ------
    MemoryError
        More than 2³¹ triangles.
    """
    started = time.perf_counter()
    textures = TextureStore(snapshot.images, snapshot.ocio_config, texture_memory)
    materials = compile_materials(snapshot.materials, textures=textures)
    world = compile_world(snapshot.world, textures=textures)
    rest = snapshot = rounds_last(snapshot)
    snapshot = displaced(snapshot, materials, shading_layers)
    if snapshot.curves or snapshot.points:
        wrapped, samples = hulls(snapshot)
        rest, snapshot = (replace(s, meshes=s.meshes + wrapped) for s in (rest, snapshot))
    view = view_of(snapshot.camera)
    placed = place(snapshot)
    accel = Accel(placed.vertices, placed.triangles)
    selves = looking_at_themselves(snapshot, materials)
    own = OwnObjects(placed, selves) if selves else None
    geometry = pack(snapshot, placed)
    if snapshot.curves or snapshot.points:
        geometry.rounds = rounds_of(snapshot, geometry, samples)
    prim, triangles = emissive_triangles(geometry, materials)
    lamp_programs = [compile_light(lamp.graph, textures=textures) for lamp in snapshot.lights]
    lights = Lights(
        snapshot.lights,
        np.array([program.constant for program in lamp_programs], np.float64).reshape(-1, 3),
        geometry.origin,
        triangles,
        environment(world, view),
        geometry.radius,
        [
            LampShader(program.batch, lamp, geometry.origin, geometry.radius, view) if program.batch else None
            for program, lamp in zip(lamp_programs, snapshot.lights, strict=True)
        ],
        surfaces=to_light(geometry, materials),
    )
    geometry.release()
    layers = shading_layers(snapshot, geometry, materials.needs)
    if geometry.rounds is not None and "strand" in materials.needs:
        layers["strand", ""] = strand_layer(snapshot, geometry, samples)
    if "rest" in materials.needs:
        layers |= rest_layers(rest, geometry)
    queries = accel if geometry.rounds is None else RoundAccel(accel, geometry, geometry.rounds)
    scene = Scene(geometry, queries, snapshot.instances, layers, materials, world, lights, film_transparent)
    textures.release()
    scene.textures = textures
    scene.emissive_prim, scene.own = prim, own
    scene.material_names = tuple(graph.name for graph in snapshot.materials)
    scene.camera, scene.view = make_camera(snapshot.camera, geometry.origin), view
    scene.exposure = snapshot.exposure
    scene.lights_without_shadow = any(not lamp.cast_shadow for lamp in snapshot.lights)
    scene.coverage = coverage(snapshot, scene, [entry for p in lamp_programs for entry in p.coverage])
    scene.features = features(snapshot, scene, film_transparent)
    scene.build_seconds = time.perf_counter() - started
    return scene


def finish(scene: Scene) -> None:
    """Make now what else the first render would make, and count its time as the build's."""
    started = time.perf_counter()
    if scene.lights.by_place is not None:
        scene.lights.by_place.make_ready()
    scene.build_seconds += time.perf_counter() - started


def emissive_triangles(geometry: Geometry, materials: Materials) -> tuple[Int32, TriangleEmitters | None]:
    """The triangles whose material emits: their numbers (also put in their records), and their table."""
    none = np.zeros(0, np.int32), None
    emits = materials.emission_varies | (materials.emission_constant != 0).any(axis=1)
    surface_emits = (geometry.surface_material >= 0) & emits[geometry.surface_material]  # never the sky's
    if not surface_emits.any():
        return none
    prim = np.flatnonzero(surface_emits[geometry.surface])
    if geometry.rounds is not None:  # hulls do not shine; what is in them is found by scattered rays alone
        prim = prim[prim < geometry.rounds.first]
    if len(prim) == 0:
        return none
    geometry.set_emitters(prim)
    material = geometry.surface_material[geometry.surface[prim]]
    emitters = TriangleEmitters(
        vertices=geometry.vertices[geometry.triangles[prim]],
        radiance=materials.emission_constant[material],
        varies=materials.emission_varies[material],
        error=geometry.records[prim, BOUND].copy(),
    )
    return prim.astype(np.int32), emitters


def view_of(camera: CameraData) -> View:
    """The camera's space and image."""
    return View(camera.kind, camera.matrix, camera.frame, camera.panorama, camera.fisheye_polynomial)


def to_light(geometry: Geometry, materials: Materials) -> Surfaces:
    """What the choice among many emitters depends on."""
    # normals of what is round are not those of its hull
    opaque = geometry.rounds is None and not any(batch.transmits for batch in materials.batches)
    return Surfaces(geometry.vertices, geometry.triangles, opaque, Accel)


def shading_layers(
    snapshot: Snapshot, geometry: Geometry, needs: frozenset[str]
) -> dict[tuple[str, str], Layer]:
    """The attribute tables that some material's program reads, and the normals where anything is smooth."""
    layers: dict[tuple[str, str], Layer] = {}
    normals = normal_layer(snapshot, geometry)
    if normals is not None:
        layers["normal", ""] = normals
    for need in needs:
        kind, _, name = need.partition(":")
        if kind == "uv":
            layers["uv", name] = uv_layer(snapshot, geometry, name)
        elif kind == "tangent":
            layers["tangent", name] = tangent_layer(snapshot, geometry, name)
        elif kind == "position":
            layers["position", ""] = position_layer(snapshot, geometry)
        elif kind == "color":
            layers["color", name] = color_layer(snapshot, geometry, name)
        elif kind == "attribute":
            layers["attribute", name] = attribute_layer(snapshot, geometry, name)
        elif kind == "generated":
            layers["generated", ""] = generated_layer(snapshot, geometry)
    return layers


def rest_layers(snapshot: Snapshot, geometry: Geometry) -> dict[tuple[str, str], Layer]:
    """Positions and normals of the meshes before displacement."""
    normals = normal_layer(snapshot, geometry)
    layers = {("rest", ""): position_layer(snapshot, geometry)}
    return layers if normals is None else {**layers, ("rest_normal", ""): normals}


def coverage(snapshot: Snapshot, scene: Scene, lamps: list[Coverage]) -> list[Coverage]:
    """How each part of the file is rendered: materials in use, world, lamps, export, geometry."""
    used = {snapshot.materials[m].name for m in scene.used_materials}
    entries = [entry for entry in scene.materials.coverage if entry.material in used]
    entries += [*scene.world.coverage, *lamps]
    entries += [Coverage(where, what, IGNORED, effect) for where, what, effect in snapshot.unsupported]
    instances = snapshot.instances
    hidden = dict.fromkeys(instances.names[k] for k in np.flatnonzero(instances.visibility != Visibility.ALL))
    effect = "seen by all rays, also by those it is hidden from"
    entries += [Coverage(f"Object {name}", "ray visibility", IGNORED, effect) for name in hidden]
    if scene.geometry.dropped:
        effect = f"{scene.geometry.dropped} triangles with non-finite vertices are left out"
        entries.append(Coverage("(geometry)", "vertices", IGNORED, effect))
    return entries
