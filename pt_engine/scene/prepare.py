"""A snapshot becomes a scene: geometry placed, Embree built, materials compiled, emitters tabulated."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from ..cameras import make_camera
from ..core.raykind import RayKind
from ..emitters.environment import ConstantEnvironment, Environment, EnvironmentMap, texel_directions
from ..emitters.lights import Lights
from ..emitters.triangle import TriangleEmitters
from ..nodes.compile import Materials, compile_materials
from ..nodes.coverage import IGNORED, Coverage
from ..nodes.world import WorldProgram, compile_light, compile_world
from .accel import Accel
from .attributes import Layer, color_layer, generated_layer, normal_layer, position_layer, uv_layer
from .features import features
from .geometry import BOUND, Geometry, pack, place
from .lanes import SkyLanes
from .scene import Scene
from .snapshot import Snapshot, Visibility

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
ENVIRONMENT_HEIGHT = 512  # rows of the importance map; the radiance itself is never baked


def prepare(snapshot: Snapshot, film_transparent: bool = False) -> Scene:
    """Compile a snapshot into what integrators render.

    Raises
    ------
    MemoryError
        More than 2³¹ triangles.
    """
    started = time.perf_counter()
    materials = compile_materials(snapshot.materials, snapshot.images, snapshot.ocio_config)
    world = compile_world(snapshot.world, snapshot.images, snapshot.ocio_config)
    placed = place(snapshot)
    accel = Accel(placed.vertices, placed.triangles)
    geometry = pack(snapshot, placed)
    prim, triangles = emissive_triangles(geometry, materials)
    lamp_programs = [
        compile_light(lamp.graph, snapshot.images, snapshot.ocio_config) for lamp in snapshot.lights
    ]
    lights = Lights(
        snapshot.lights,
        np.array([strength for strength, _ in lamp_programs], np.float64).reshape(-1, 3),
        geometry.origin,
        triangles,
        environment(world),
        geometry.radius,
    )
    geometry.release()
    layers = shading_layers(snapshot, geometry, materials)
    scene = Scene(geometry, accel, snapshot.instances, layers, materials, world, lights, film_transparent)
    scene.emissive_prim = prim
    scene.material_names = tuple(graph.name for graph in snapshot.materials)
    scene.camera = make_camera(snapshot.camera, geometry.origin)
    scene.exposure = snapshot.exposure
    scene.lights_without_shadow = any(not lamp.cast_shadow for lamp in snapshot.lights)
    scene.coverage = coverage(snapshot, scene, [entry for _, log in lamp_programs for entry in log])
    scene.features = features(snapshot, scene, film_transparent)
    scene.build_seconds = time.perf_counter() - started
    return scene


def emissive_triangles(geometry: Geometry, materials: Materials) -> tuple[Int32, TriangleEmitters | None]:
    """The triangles whose material emits: their numbers (also put in their records), and their table."""
    none = np.zeros(0, np.int32), None
    emits = materials.emission_varies | (materials.emission_constant != 0).any(axis=1)
    surface_emits = (geometry.surface_material >= 0) & emits[geometry.surface_material]  # never the sky's
    if not surface_emits.any():
        return none
    prim = np.flatnonzero(surface_emits[geometry.surface])
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


def environment(world: WorldProgram) -> Environment | None:
    """The world as an emitter to sample; its brightness is tabulated unless it is constant."""
    if not world.emits:
        return None
    if world.constant is not None:
        return ConstantEnvironment(tuple(world.constant))

    def radiance(d: Float32) -> Float32:
        kind = np.full(d.shape[1], RayKind.DIFFUSE | RayKind.REFLECTION, np.int32)
        return world.emission(SkyLanes(d, kind))

    height = ENVIRONMENT_HEIGHT
    d = texel_directions(height, 2 * height)
    image = np.concatenate(
        [radiance(np.ascontiguousarray(part)).mean(axis=0) for part in np.array_split(d, 16, axis=1)]
    )
    return EnvironmentMap(image.reshape(height, 2 * height), radiance)


def shading_layers(
    snapshot: Snapshot, geometry: Geometry, materials: Materials
) -> dict[tuple[str, str], Layer]:
    """The attribute tables that some material's program reads, and the normals where anything is smooth."""
    layers: dict[tuple[str, str], Layer] = {}
    normals = normal_layer(snapshot, geometry)
    if normals is not None:
        layers["normal", ""] = normals
    for need in materials.needs:
        kind, _, name = need.partition(":")
        if kind in ("uv", "tangent"):
            layers["uv", name] = uv_layer(snapshot, geometry, name)
            if kind == "tangent":
                layers["position", ""] = position_layer(snapshot, geometry)
        elif kind == "position":
            layers["position", ""] = position_layer(snapshot, geometry)
        elif kind == "color":
            layers["color", name] = color_layer(snapshot, geometry, name)
        elif kind == "generated":
            layers["generated", ""] = generated_layer(snapshot, geometry)
    return layers


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
