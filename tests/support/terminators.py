"""Coarse smooth meshes where light grazes."""

import bmesh
import bpy
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, empty_scene

SIDE = {"location": (3.2, -0.6, 0.7), "rotation_euler": (0, 1.3, -0.2)}
FRONT = {"location": (2, -3.2, 1), "rotation_euler": (1.2, 0, 0.6)}
LAMPS = {
    "SUN": {"energy": 3.0, "angle": 0.0},
    "POINT": {"energy": 300.0, "shadow_soft_size": 0.0},
    "AREA": {"energy": 300.0, "size": 2.0},
}


def material(kind):
    made = bpy.data.materials.new(kind)
    tree = with_nodes(made)
    shader, end = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], end.inputs["Surface"])
    return made


def shape(kind):
    """A ball of few faces, its open half, or a cone."""
    data, work = bpy.data.meshes.new(kind), bmesh.new()
    if kind == "cone":
        bmesh.ops.create_cone(work, segments=7, radius1=1, radius2=0.3, depth=1.6, cap_ends=True)
    else:
        bmesh.ops.create_uvsphere(work, u_segments=8, v_segments=6, radius=1)
    if kind == "half":
        bmesh.ops.delete(work, geom=[v for v in work.verts if v.co.y < -0.3], context="VERTS")
    work.to_mesh(data)
    work.free()
    data.shade_smooth()
    return data


def build(kind="ball", lamp="SUN", offset=0.1, shader="BsdfDiffuse", place=SIDE, **settings):
    scene = empty_scene()
    data = shape(kind)
    data.materials.append(material(shader))
    owner = add(data, "Shape", **settings)
    owner.shadow_terminator_geometry_offset = offset
    light = bpy.data.lights.new("Lamp", lamp)
    for name, value in LAMPS[lamp].items():
        setattr(light, name, value)
    add(light, "Lamp", **place)
    scene.camera.location, scene.camera.rotation_euler = (0, -4, 0.6), (1.42, 0, 0)
    scene.camera.data.lens = 60
    return owner
