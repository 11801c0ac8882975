"""A small room, and changes of it by who sees whom: ray visibility, holdouts, overrides, links.

A cube stands on a floor between a mirror wall, a rough one and a sheet of glass, under a lamp with a size, a
sun and a sky.
"""

import bpy
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, cube, empty_scene, mesh

KINDS = ("camera", "diffuse", "glossy", "transmission", "shadow")


def material(name, kind, **inputs):
    made = bpy.data.materials.new(name)
    tree = with_nodes(made)
    shader, end = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], end.inputs["Surface"])
    for socket, value in inputs.items():
        shader.inputs[socket].default_value = value
    return made


def color(r, g, b):
    return (r, g, b, 1.0)


def put(data, name, made, **settings):
    data.materials.append(made)
    return add(data, name, **settings)


def sheet(name, corners, made):
    return put(mesh(corners, [(0, 1, 2, 3)], name), name, made)


def room():
    """The stage; objects by name."""
    scene = empty_scene()
    scene.camera.location, scene.camera.rotation_euler = (0, -7, 2.6), (1.25, 0, 0)
    sheet("Floor", [(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], material("Grey", "BsdfDiffuse"))
    mirror = material("Mirror", "BsdfGlossy", Color=color(0.9, 0.9, 0.9), Roughness=0.0)
    sheet("Mirror", [(-3, 3, 0), (0, 3, 0), (0, 3, 3), (-3, 3, 3)], mirror)
    rough = material("Rough", "BsdfGlossy", Color=color(0.9, 0.9, 0.9), Roughness=0.4)
    sheet("Rough", [(0, 3, 0), (3, 3, 0), (3, 3, 3), (0, 3, 3)], rough)
    refraction = material("Glass", "BsdfRefraction", Roughness=0.0, IOR=1.1)
    sheet("Glass", [(0.6, -2, 0.2), (2.4, -2, 0.2), (2.4, -2, 1.8), (0.6, -2, 1.8)], refraction)
    red = material("Red", "BsdfDiffuse", Color=color(0.8, 0.2, 0.1))
    put(cube("Cube", 1.2), "Cube", red, location=(0.4, 0.6, 0.6))
    blue = material("Blue", "BsdfPrincipled", **{"Base Color": color(0.1, 0.3, 0.8), "Roughness": 0.35})
    put(cube("Box", 0.8), "Box", blue, location=(-1.4, -0.4, 0.4))
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 300.0, 3.0
    add(lamp, "Lamp", location=(-1.5, -0.5, 5.0))
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 1.0, 0.8
    add(sun, "Sun", rotation_euler=(0.1, 0.8, 0))
    sky = scene.world = bpy.data.worlds.new("Sky")
    tree = with_nodes(sky)
    background, end = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = color(0.3, 0.4, 0.6)
    tree.links.new(background.outputs[0], end.inputs["Surface"])
    return scene


def of(name):
    return bpy.data.objects[name]


def shining(name, strength=4.0):
    """An object becomes a lamp."""
    of(name).data.materials[0] = material("Shines", "Emission", Color=color(1, 0.7, 0.4), Strength=strength)


def hides(name, *kinds):
    def change(scene):
        for kind in kinds:
            setattr(of(name), f"visible_{kind}", False)

    return change


def shines_and_hides(name, *kinds):
    def change(scene):
        shining(name)
        hides(name, *kinds)(scene)

    return change


def world_hides(kind):
    def change(scene):
        setattr(scene.world.cycles_visibility, kind, False)

    return change


def in_collection(name, *owners):
    """A collection of the scene that these objects are in, and its place in the view layer."""
    made = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(made)
    for owner in owners:
        bpy.context.scene.collection.objects.unlink(of(owner))
        made.objects.link(of(owner))
    return made, bpy.context.view_layer.layer_collection.children[name]


def held_out(scene):
    of("Cube").is_holdout = True


def veiled(scene):
    """The cube's faces let half of the light through, and shine."""
    made = of("Cube").data.materials[0] = material("Veil", "Emission", Color=color(1, 0.7, 0.4), Strength=2.0)
    tree = made.node_tree
    mix, clear = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfTransparent")
    clear.inputs["Color"].default_value = color(0.9, 0.6, 0.3)
    shine, end = tree.nodes["Emission"], tree.nodes["Material Output"]
    for source, target in ((shine, mix.inputs[1]), (clear, mix.inputs[2]), (mix, end.inputs["Surface"])):
        tree.links.new(source.outputs[0], target)


def veiled_and_held_out(scene):
    veiled(scene)
    of("Cube").location.z += 0.01  # on the floor itself, which of the two is met first is nobody's to say
    held_out(scene)


def collection_held_out(scene):
    in_collection("Held", "Cube", "Box")[1].holdout = True


def indirect_only(scene):
    in_collection("Indirect", "Cube", "Lamp")[1].indirect_only = True


def instanced_and_held_out(scene):
    """An instance is held out where its instancer is."""
    made, layer = in_collection("Source", "Cube")
    layer.exclude = True
    add(None, "Empty", instance_type="COLLECTION", location=(0.3, 0, 0)).instance_collection = made
    of("Empty").is_holdout = True


def overridden(scene):
    bpy.context.view_layer.material_override = material("Over", "BsdfDiffuse", Color=color(0.2, 0.7, 0.3))


def other_world(scene):
    other = bpy.data.worlds.new("Other")
    tree = with_nodes(other)
    background, end = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = color(0.7, 0.2, 0.2)
    tree.links.new(background.outputs[0], end.inputs["Surface"])
    bpy.context.view_layer.world_override = other


def without_sky(scene):
    bpy.context.view_layer.use_sky = False


def clear_film(change=lambda scene: None, roughness=None, glass=None):
    """With a transparent film; `roughness` up to which glass shows it, and the pane's own."""

    def both(scene):
        scene.render.film_transparent = True
        if roughness is not None:
            scene.cycles.film_transparent_glass, scene.cycles.film_transparent_roughness = True, roughness
        if glass is not None:
            bpy.data.materials["Glass"].node_tree.nodes["Refraction BSDF"].inputs[
                "Roughness"
            ].default_value = glass
        change(scene)

    return both


def few_bounces(limit):
    """A lamp that no ray meets shines on surfaces of few bounces."""

    def change(scene):
        bpy.data.lights["Sun"].angle, bpy.data.lights["Sun"].energy = 0.0, 4.0
        bpy.data.lights["Sun"].cycles.max_bounces = limit

    return change


def never_sampled(scene):
    shining("Cube")
    of("Cube").data.materials[0].cycles.emission_sampling = "NONE"


def portal(scene):
    pane = bpy.data.lights.new("Portal", "AREA")
    pane.energy, pane.size, pane.cycles.is_portal = 500.0, 2.0, True
    add(pane, "Portal", location=(0, 0, 6))


def linked(emitter, what, **states):
    """A collection of receivers or blockers of an emitter: object -> INCLUDE or EXCLUDE."""

    def change(scene):
        made = bpy.data.collections.new(f"{emitter} {what}")
        for name, state in states.items():
            made.objects.link(of(name))
            made.collection_objects[-1].light_linking.link_state = state
        setattr(of(emitter).light_linking, f"{what}_collection", made)

    return change


def nested(scene):
    """What lies in a collection within counts as that is marked."""
    inner, outer = bpy.data.collections.new("Inner"), bpy.data.collections.new("Outer")
    inner.objects.link(of("Box"))
    outer.children.link(inner)
    outer.objects.link(of("Floor"))
    outer.collection_children[0].light_linking.link_state = "EXCLUDE"
    of("Lamp").light_linking.receiver_collection = outer


def shining_and(change):
    def both(scene):
        shining("Cube", 8.0)
        change(scene)

    return both


def alone(name, change):
    """With no other light than this."""

    def both(scene):
        for light in bpy.data.lights:
            if light.name != name:
                light.energy = 0.0
        scene.world = None
        change(scene)

    return both


def many(change):
    """With so many lamps that they are chosen by place."""

    def both(scene):
        for k in range(12):
            light = bpy.data.lights.new("Bulb", "POINT")
            light.energy, light.shadow_soft_size = 12.0, 0.25
            add(light, f"Bulb {k}", location=(k % 4 * 2 - 3, k // 4 * 2 - 2.5, 2.5))
        change(scene)

    return both


def bulbs(scene):
    for k in range(0, 12, 2):
        linked(f"Bulb {k}", "receiver", Floor="INCLUDE", Box="INCLUDE")(scene)
    for k in range(1, 12, 2):
        linked(f"Bulb {k}", "receiver", Floor="EXCLUDE")(scene)


def catching(*names, real=True):
    """Shadow catchers; a lamp that isn't real shines on other objects only."""

    def change(scene):
        for name in names:
            of(name).is_shadow_catcher = True
        of("Lamp").is_shadow_catcher = real

    return change


CASES = {
    "as it is": lambda scene: None,
    **{f"cube unseen by {kind}": hides("Cube", kind) for kind in KINDS},
    "box unseen by all but the camera": hides("Box", "diffuse", "glossy", "transmission", "shadow"),
    "box unseen by all but shadows": hides("Box", "camera", "diffuse", "glossy", "transmission"),
    **{f"lamp unseen by {kind}": hides("Lamp", kind) for kind in KINDS[1:4]},
    "sun unseen by diffuse": hides("Sun", "diffuse"),
    **{f"shining cube unseen by {kind}": shines_and_hides("Cube", kind) for kind in KINDS},
    "shining cube unseen by what scatters": shines_and_hides("Cube", *KINDS[1:4]),
    **{f"world unseen by {kind}": world_hides(kind) for kind in KINDS[:4]},
    "cube held out": held_out,
    "cube held out of a clear film": clear_film(held_out),
    "veil": veiled,
    "veil held out": veiled_and_held_out,
    "collection held out": collection_held_out,
    "instance held out": instanced_and_held_out,
    "collection for indirect light only": indirect_only,
    "one material": overridden,
    "another world": other_world,
    "no sky": without_sky,
    "clear film": clear_film(),
    "clear film behind glass": clear_film(roughness=0.1),
    "clear film behind rough glass": clear_film(roughness=0.3, glass=0.29),
    "clear film not behind rougher glass": clear_film(roughness=0.3, glass=0.31),
    **{f"sun for {limit} bounces": few_bounces(limit) for limit in (0, 1)},
    "shining cube not sampled": never_sampled,
    "portal": portal,
    "lamp on cube and mirror": linked("Lamp", "receiver", Cube="INCLUDE", Mirror="INCLUDE"),
    "lamp not on floor": linked("Lamp", "receiver", Floor="EXCLUDE"),
    "lamp on floor but not on cube": linked("Lamp", "receiver", Floor="INCLUDE", Cube="EXCLUDE"),
    "lamp on an empty collection": linked("Lamp", "receiver"),
    "lamp on collections within": nested,
    "sun not on box": alone("Sun", linked("Sun", "receiver", Box="EXCLUDE")),
    "shining cube on floor": shining_and(linked("Cube", "receiver", Floor="INCLUDE")),
    "many lamps on some": many(bulbs),
    "floor catches shadows": catching("Floor"),
    "floor catches shadows on a clear film": clear_film(catching("Floor")),
    "floor and cube catch shadows": clear_film(catching("Floor", "Cube")),
    "floor catches no shadow of a lamp": clear_film(catching("Floor", real=False)),
    "floor catches light": clear_film(shining_and(catching("Floor"))),
    "mirror catches shadows": clear_film(catching("Mirror", "Floor"), roughness=0.1),
    "lamp not shaded by cube": alone("Lamp", linked("Lamp", "blocker", Cube="EXCLUDE")),
    "lamp shaded by box alone": alone("Lamp", linked("Lamp", "blocker", Box="INCLUDE")),
    "sun not shaded by cube": alone("Sun", linked("Sun", "blocker", Cube="EXCLUDE")),
    "shining cube not shaded by box": alone("", shining_and(linked("Cube", "blocker", Box="EXCLUDE"))),
}
