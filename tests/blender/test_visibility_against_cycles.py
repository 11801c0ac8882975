"""Who sees whom: ray visibility, holdouts, overrides, links. Each case is a change of one small room.

A cube stands on a floor between a mirror wall, a rough one and a sheet of glass, under a lamp with a size, a
sun and a sky. Both renderers' pictures have to agree, colour and alpha, within their noise.
"""

import bpy
import numpy as np
import pytest
from support import ztest
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, cube, empty_scene, mesh
from support.cycles import by_cycles, by_engine

SIZE, SAMPLES, CELLS = (36, 24), 64, (6, 4)
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
    lamp.energy, lamp.size = 120.0, 1.0
    add(lamp, "Lamp", location=(-1.5, -1.0, 4.0))
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 1.5, 0.05
    add(sun, "Sun", rotation_euler=(0.6, 0.5, 0))
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
}


@pytest.mark.parametrize("name", CASES)
def test_the_room_looks_as_in_cycles(name, tmp_path):
    scene = room()
    CASES[name](scene)
    theirs, ours = by_cycles(SAMPLES, SIZE, tmp_path), by_engine(SAMPLES, SIZE)
    found = ztest.compare(ours, theirs, CELLS)
    assert found.agrees(), f"{name}: {found}"
    assert np.isfinite(ours[0]).all()
