"""What a file asks for that the snapshot can't hold: found here so that the engine can name it."""

from __future__ import annotations

import bpy

MOVING_MODIFIERS = {
    "NODES", "CLOTH", "SOFT_BODY", "FLUID", "DYNAMIC_PAINT", "OCEAN", "WAVE", "BUILD", "EXPLODE",
    "MESH_CACHE", "MESH_SEQUENCE_CACHE", "PARTICLE_SYSTEM", "PARTICLE_INSTANCE",
}  # fmt: skip


def scene_wide(depsgraph, scene) -> list[tuple[str, str, str]]:
    """Entries (where, what, effect) about the scene and its objects."""
    return [
        *motion_blur(scene),
        *shadow_caustics(depsgraph),
        *texture_settings(scene),
    ]


def motion_blur(scene):
    """Listed where it is on and something in the file may move."""
    render = scene.render
    if render.use_motion_blur and render.motion_blur_shutter > 0.0 and may_move(scene):
        yield (f"Scene {scene.name}", "motion blur", "rendered sharp, as at the frame's own time")


def shadow_caustics(depsgraph):
    """Cycles' manifold walks, which need a lamp, a caster and a receiver that are marked for them."""

    def marked(name):
        settings = [getattr(item, "cycles", None) for o in depsgraph.objects for item in (o, o.data)]
        return any(getattr(item, name, False) for item in settings)

    if marked("is_caustics_caster") and marked("is_caustics_receiver"):
        effect = "light refracted onto receivers is missing, or noisy where lamps have a size"
        yield ("Scene", "shadow caustics", effect)


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


def may_move(scene) -> bool:
    """Whether the file has anything that changes with time."""
    if len(bpy.data.actions) or scene.rigidbody_world is not None:
        return True
    for owner in scene.objects:
        animations = [getattr(item, "animation_data", None) for item in (owner, owner.data)]
        if any(animation is not None and len(animation.drivers) for animation in animations):
            return True
        if any(modifier.type in MOVING_MODIFIERS for modifier in owner.modifiers):
            return True
    return False
