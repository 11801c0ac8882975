"""What a file asks for that the snapshot can't hold: found here so that the engine can name it."""

from __future__ import annotations

import bpy
import numpy as np

from ...scene.snapshot import UNLIMITED
from .curves import hair_systems
from .lost import lost

UNEVEN = 1.01  # one axis is scaled by so much more than another


def scene_wide(depsgraph, scene) -> list[tuple[str, str, str]]:
    """Entries (where, what, effect) about the scene and its objects."""
    return [
        *caustics_off(scene),
        *shadow_caustics(depsgraph),
        *texture_settings(scene),
        *world_bounces(depsgraph, scene),
        *(entry for owner in depsgraph.objects for entry in of_object(owner)),
        *lost(depsgraph),
    ]


def caustics_off(scene):
    """Cycles' switches that leave light out; here all of it counts."""
    cycles = getattr(scene, "cycles", None)
    off = [kind for kind in ("reflective", "refractive") if not getattr(cycles, f"caustics_{kind}", True)]
    if off:
        yield (f"Scene {scene.name}", f"no {' and '.join(off)} caustics", "they are rendered all the same")


def shadow_caustics(depsgraph):
    """Cycles' manifold walks, which need a lamp, a caster and a receiver that are marked for them."""

    def marked(name):
        settings = [getattr(item, "cycles", None) for o in depsgraph.objects for item in (o, o.data)]
        return any(getattr(item, name, False) for item in settings)

    if marked("is_caustics_caster") and marked("is_caustics_receiver"):
        effect = "light refracted onto receivers is missing, or noisy where lamps have a size"
        yield ("Scene", "shadow caustics", effect)


def world_bounces(depsgraph, scene):
    """A world that is to light only what few bounces lead to."""
    world = getattr(depsgraph.view_layer, "world_override", None) or scene.world
    if getattr(getattr(world, "cycles", None), "max_bounces", UNLIMITED) < UNLIMITED:
        yield (f"World {world.name}", "max bounces", "its light counts after any number of bounces")


def texture_settings(scene):
    """What the file does to all image textures: another working space, smaller images, mip maps."""
    where, cycles = f"Scene {scene.name}", getattr(scene, "cycles", None)
    space = getattr(getattr(bpy.data, "colorspace", None), "working_space", "Linear Rec.709")
    if space != "Linear Rec.709":
        yield (where, f"working space {space}", "colours of lamps, nodes and images are taken as Rec.709")
    if scene.render.use_simplify and len(bpy.data.images):
        limit = getattr(cycles, "texture_limit_render", "OFF")
        if limit != "OFF" or getattr(cycles, "texture_resolution_render", 1.0) < 1.0:
            yield (where, "smaller textures", "images keep their full size")
    if getattr(scene.render, "use_auto_generate_texture_cache", False) and len(bpy.data.images):
        yield (where, "texture cache", "images are looked up in full size, not in mip maps")


def of_object(owner):
    """Strands whose light is to fade before the shadow terminator."""
    if owner.type != "CURVES" and not hair_systems(owner, viewport=False):
        return
    if owner.shadow_terminator_shading_offset > 0.0:
        where = f"Object {owner.name}"
        yield (where, "shadow terminator shading offset", "light on its strands fades with its own cosine")


def uneven_rounds(instances, meshes: int) -> list[tuple[str, str, str]]:
    """Strands and points whose instances are scaled more along one axis than another.

    `meshes` is the number of meshes, after which strands and points are counted.
    """
    rows = np.flatnonzero(instances.mesh >= meshes)
    matrices = instances.matrix[rows, :3, :3]
    scales = np.linalg.svd(np.where(np.isfinite(matrices), matrices, 0.0), compute_uv=False)
    uneven = rows[scales[:, 0] > UNEVEN * scales[:, 2]]
    effect = "its strands and points stay round, as thick as the mean of the scales makes them"
    return [
        (f"Object {name}", "uneven scale", effect)
        for name in dict.fromkeys(instances.names[row] for row in uneven)
    ]
