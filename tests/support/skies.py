"""Sky Textures, and a box outdoors."""

import bpy
import numpy as np
from mathutils import Euler
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, cube, mesh


def sky(scene, **settings):
    """The scene's world becomes a Sky Texture."""
    world = scene.world = bpy.data.worlds.new("sky")
    tree = with_nodes(world)
    texture, background, out = (
        tree.nodes.new("ShaderNode" + kind) for kind in ("TexSky", "Background", "OutputWorld")
    )
    for name, value in settings.items():
        if name == "turned":
            texture.texture_mapping.rotation = value
        else:
            setattr(texture, name, value)
    tree.links.new(texture.outputs[0], background.inputs["Color"])
    tree.links.new(background.outputs[0], out.inputs["Surface"])


def box_outdoors(scene):
    """On the ground, seen from above."""
    grey = bpy.data.materials.new("grey")
    tree = with_nodes(grey)
    lambert, out = (tree.nodes.new("ShaderNode" + kind) for kind in ("BsdfDiffuse", "OutputMaterial"))
    tree.links.new(lambert.outputs[0], out.inputs["Surface"])
    for data, height in (
        (mesh([(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0)], [(0, 1, 2, 3)]), 0),
        (cube(size=1.0), 0.5),
    ):
        data.materials.append(grey)
        add(data, location=(0, 0, height))
    scene.camera.location, scene.camera.rotation_euler = (4, -4, 4), Euler((np.pi / 3.4, 0, np.pi / 4))
