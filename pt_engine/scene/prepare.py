"""A snapshot becomes a scene: geometry placed, Embree built, materials compiled, emitters tabulated."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..cameras import make_camera
from ..emitters.lights import Lights
from ..emitters.many import Surfaces
from ..emitters.restricted import SCATTERED
from ..emitters.triangle import TriangleEmitters
from ..nodes.compile import Materials, compile_materials
from ..nodes.coverage import APPROXIMATE, IGNORED, Coverage
from ..nodes.world import compile_light, compile_world
from ..textures.images import TextureStore
from .accel import Accel
from .alone import normals_in_world
from .another_view import made_for_one_view, view_of
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
from .catcher import catchers_of, catchers_tree, with_catchers_alone
from .displace import displaced
from .features import ON, features
from .geometry import BOUND, INSTANCE, Geometry, world_boxes
from .hulls import Hulls
from .instancing import PLAIN, Sharing
from .lamp_shader import LampShader
from .memory import need, sharing_that_fits, snapshot_bytes
from .movement import moving_last
from .own import OwnObjects, looking_at_themselves
from .placing import build, may_share
from .reach import reach_of
from .round_accel import through_hulls
from .round_lanes import across_layer, strand_layer
from .rounds import rounds_among, rounds_of
from .scene import Scene
from .sighted import standing_out
from .slices import Slices
from .snapshot import UNLIMITED, Snapshot, Visibility
from .terminator import Terminator
from .terminator_shading import angles_of
from .world_light import environment

Int32 = NDArray[np.int32]


def prepare(
    snapshot: Snapshot, film_transparent: bool = False, texture_memory: int = 0, memory: int | None = None
) -> Scene:
    """Compile a snapshot into what integrators render.

    Parameters
    ----------
    snapshot : Snapshot
    film_transparent : bool
    texture_memory : int
        Bytes that the texels of all images together may take; 0 for no limit.
    memory : int, optional
        Bytes that there are for the scene: instances that would not fit are not placed, which is slower.

    Raises
    ------
    TooLarge
        It does not fit however it is placed.
    MemoryError
        More than 2³¹ triangles with records of their own.
    """
    started = time.perf_counter()
    textures = TextureStore(snapshot.images, snapshot.ocio_config, texture_memory)
    materials = compile_materials(snapshot.materials, textures=textures)
    world = compile_world(snapshot.world, textures=textures)
    rest = moving_last(snapshot)
    snapshot, alone = normals_in_world(displaced(rest, materials, shading_layers), materials)
    hulls, bare = Hulls(snapshot), (rest, snapshot)
    rest, snapshot = (replace(s, meshes=s.meshes + hulls.outlines()) for s in bare)
    motion = snapshot.motion
    slices = Slices(motion, snapshot, rest, materials, shading_layers, hulls) if motion is not None else None
    view = view_of(snapshot.camera)
    selves = looking_at_themselves(snapshot, materials)
    in_slices = 0 if slices is None else slices.bytes
    in_hulls = snapshot_bytes(snapshot) - snapshot_bytes(bare[1])
    room = None if memory is None else memory - textures.statistics()["bytes"] - in_slices
    apart = [*selves, *apart_from_others(snapshot), *([] if slices is None else slices.moving)]
    apart += rounds_among(snapshot).tolist()
    terminator = Terminator.of(snapshot, alone)
    lifts = terminator is not None and terminator.lifts
    needs = materials.needs | ({"position"} if lifts else frozenset())
    may = may_share(snapshot, materials, apart)
    sharing = sharing_that_fits(snapshot, may, needs, room, in_hulls)
    rest, snapshot = (replace(s, meshes=s.meshes + hulls.meshes) for s in bare)
    placed, accel, geometry = build(snapshot, sharing, slices)
    own = OwnObjects(placed, selves) if selves else None
    geometry.rounds = rounds_of(snapshot, geometry, hulls)
    prim, triangles = emissive_triangles(geometry, materials, snapshot)
    reached = reach_of(snapshot)
    lamp_programs = [compile_light(lamp.graph, textures=textures) for lamp in snapshot.lights]
    make_lights = partial(
        Lights,
        snapshot.lights,
        np.array([program.constant for program in lamp_programs], np.float64).reshape(-1, 3),
        geometry.origin,
        environment=environment(world, view),
        scene_radius=geometry.radius,
        shaders=[
            LampShader(program.batch, lamp, geometry.origin, geometry.radius, view) if program.batch else None
            for program, lamp in zip(lamp_programs, snapshot.lights, strict=True)
        ],
        surfaces=to_light(geometry, materials, snapshot, sharing),
        shown=reached.shown(),
    )
    lights = make_lights(triangles=triangles)
    geometry.release()
    layers = shading_layers(snapshot, geometry, needs)
    for name, layer_of in (("strand", strand_layer), ("strand normal", across_layer)):
        if geometry.rounds is not None and name in materials.needs:
            layers[name, ""] = layer_of(snapshot, geometry, hulls.samples)
    if "rest" in materials.needs:
        layers |= rest_layers(rest, geometry)
    queries = through_hulls(accel, geometry)
    parts = geometry, queries, snapshot.instances, layers, materials, world, lights
    scene = Scene(*parts, film_transparent, reached)
    textures.release()
    scene.textures = textures
    scene.emissive_prim, scene.own, scene.terminator = prim, own, terminator
    scene.light_angles = angles_of(snapshot)
    scene.unsampled_surfaces = bool(scene.surface_emits[geometry.surface].sum() > len(prim))
    scene.material_names = tuple(graph.name for graph in snapshot.materials)
    scene.camera, scene.view = make_camera(snapshot.camera, geometry.origin), view
    scene.of_one_view = made_for_one_view(materials, world, lamp_programs)
    scene.exposure, scene.light_groups = snapshot.exposure, snapshot.light_groups
    if film_transparent and snapshot.clear_glass >= 0:
        scene.show_through(snapshot.clear_glass)
    scene.lights_without_shadow = any(not lamp.cast_shadow for lamp in snapshot.lights)
    if scene.has_catchers:
        tree = catchers_tree(placed, snapshot.instances, scene.catchers)
        scene.alone = with_catchers_alone(scene, tree)
    scene.features = features(snapshot, scene, film_transparent)
    scene.coverage = coverage(snapshot, scene, [entry for p in lamp_programs for entry in p.coverage])
    scene.bytes = snapshot_bytes(snapshot) + need(snapshot, sharing, needs).kept
    scene.bytes += textures.statistics()["bytes"] + in_slices
    if slices is not None:
        scene.slices = slices
        slices.start(scene, make_lights, triangles)
    scene.build_seconds = time.perf_counter() - started
    return scene


def finish(scene: Scene) -> None:
    """Make now what else the first samples would make."""
    scene.lights.make_ready()


def emissive_triangles(
    geometry: Geometry, materials: Materials, snapshot: Snapshot
) -> tuple[Int32, TriangleEmitters | None]:
    """The triangles to sample light from: their numbers (also put in their records), and their table.

    Left out are those whose material asks for it, and objects that no scattered ray sees.
    """
    none = np.zeros(0, np.int32), None
    emits = materials.emits & np.array([graph.sampled for graph in snapshot.materials], np.bool_)
    surface_emits = (geometry.surface_material >= 0) & emits[geometry.surface_material]  # never the sky's
    if not surface_emits.any():
        return none
    prim = np.flatnonzero(surface_emits[geometry.surface])
    if geometry.rounds is not None:  # hulls do not shine; what is in them is found by scattered rays alone
        prim = prim[~geometry.rounds.held(prim)]
    instance = geometry.integer(INSTANCE, prim.astype(np.int32))
    seen = np.flatnonzero(snapshot.instances.visibility[instance] & SCATTERED)
    prim, instance = prim[seen], instance[seen]
    if len(prim) == 0:
        return none
    geometry.set_emitters(prim)
    material = geometry.surface_material[geometry.surface[prim]]
    emitters = TriangleEmitters(
        vertices=geometry.vertices[geometry.triangles[prim]],
        radiance=materials.emission_constant[material],
        varies=materials.emission_varies[material],
        error=geometry.records[prim, BOUND].copy(),
        whose=whose(snapshot, instance),
    )
    return prim.astype(np.int32), emitters


def apart_from_others(snapshot: Snapshot) -> list[int]:
    """The instances that some rays do not see, and shadow catchers: they have trees of their own."""
    return np.flatnonzero(standing_out(snapshot) | catchers_of(snapshot.instances)).tolist()


def whose(snapshot: Snapshot, instance: Int32) -> NDArray[np.int64] | None:
    """(T,) `TriangleEmitters.whose` of triangles of each `instance`."""
    links = snapshot.linking
    bits, groups = snapshot.instances.visibility.astype(np.int64), snapshot.instances.light_group
    if links is not None:
        bits += links.emitter.astype(np.int64) << 8
    if groups is not None:
        bits += groups.astype(np.int64) << 32
    return bits[instance] if (bits != Visibility.ALL).any() else None


def to_light(
    geometry: Geometry, materials: Materials, snapshot: Snapshot, sharing: Sharing | None
) -> Surfaces:
    """What the choice among many emitters depends on."""
    # normals of what is round are not those of its hull
    opaque = geometry.rounds is None and not any(batch.transmits for batch in materials.batches)
    found = Surfaces(geometry.vertices, geometry.triangles, opaque, Accel)
    if sharing is None:
        return found
    shared = sharing.prototype != PLAIN
    low, high = world_boxes(snapshot.meshes, snapshot.instances)
    return found._replace(boxes=(low[shared] - geometry.origin, high[shared] - geometry.origin))


def shading_layers(
    snapshot: Snapshot, geometry: Geometry, needs: frozenset[str]
) -> dict[tuple[str, str], Layer]:
    """The attribute tables that some material's program reads, and the normals where anything is smooth."""
    layers: dict[tuple[str, str], Layer] = {}
    normals = normal_layer(snapshot, geometry)
    if normals is not None:
        layers["normal", ""] = normals
    for wanted in needs:
        kind, _, name = wanted.partition(":")
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


def linked_mirrors(snapshot: Snapshot, scene: Scene) -> list[Coverage]:
    """Lights in which some objects cast no shadow, where ideal mirrors or glass may show them."""
    apart = scene.reach.apart
    if apart is None or scene.features["ideal specular"] != ON:
        return []
    names = [lamp.name for lamp in snapshot.lights if apart[lamp.group]]
    if snapshot.linking is not None:
        rows = np.flatnonzero(apart[snapshot.linking.emitter])
        names += [snapshot.instances.names[k] for k in rows]
    effect = "in ideal mirrors and glass it is hidden also by what casts no shadow in its light"
    return [Coverage(f"Light {name}", "shadow linking", APPROXIMATE, effect) for name in dict.fromkeys(names)]


def few_bounces(snapshot: Snapshot) -> list[Coverage]:
    """Lamps with a size that are to light only what few bounces lead to, which rays may meet as well."""
    effect = "beyond that its light is left out altogether; Cycles lets rays that meet the lamp keep a share"
    return [
        Coverage(f"Light {lamp.name}", "max bounces", APPROXIMATE, effect)
        for lamp in snapshot.lights
        if lamp.max_bounces < UNLIMITED and lamp.use_mis and lamp.cast_shadow
        if lamp.kind == "AREA" or lamp.radius > 0 or lamp.angle > 0
    ]


def coverage(snapshot: Snapshot, scene: Scene, lamps: list[Coverage]) -> list[Coverage]:
    """How each part of the file is rendered: materials in use, world, lamps, export, geometry."""
    used = {snapshot.materials[m].name for m in scene.used_materials}
    entries = [entry for entry in scene.materials.coverage if entry.material in used]
    entries += [*scene.world.coverage, *lamps]
    entries += [Coverage(where, what, IGNORED, effect) for where, what, effect in snapshot.unsupported]
    entries += [*linked_mirrors(snapshot, scene), *few_bounces(snapshot)]
    if scene.geometry.dropped:
        effect = f"{scene.geometry.dropped} triangles with non-finite vertices are left out"
        entries.append(Coverage("(geometry)", "vertices", IGNORED, effect))
    return entries
