"""A floor under a grey sky and a sun, and what moves on it between frames 1 and 3."""

from itertools import pairwise

import bpy
from mathutils import Euler
from support import tufts
from support.bpy_motion import animate
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, cube, empty_scene, mesh


def material(name, color):
    """Diffuse."""
    made = bpy.data.materials.new(name)
    tree = with_nodes(made)
    bsdf, out = (tree.nodes.new("ShaderNode" + kind) for kind in ("BsdfDiffuse", "OutputMaterial"))
    bsdf.inputs["Color"].default_value = (*color, 1)
    tree.links.new(bsdf.outputs[0], out.inputs["Surface"])
    return made


def stage():
    """A floor under a grey sky and a sun, seen at an angle; the shutter is open for a frame about frame 2."""
    made = empty_scene()
    world = made.world = bpy.data.worlds.new("sky")
    tree = with_nodes(world)
    background, out = (tree.nodes.new("ShaderNode" + kind) for kind in ("Background", "OutputWorld"))
    background.inputs["Color"].default_value = (0.3, 0.35, 0.4, 1)
    tree.links.new(background.outputs[0], out.inputs["Surface"])
    floor = mesh([(-9, -9, -1), (9, -9, -1), (9, 9, -1), (-9, 9, -1)], [(0, 1, 2, 3)], "Floor")
    floor.materials.append(material("Floor", (0.6, 0.6, 0.6)))
    add(floor)
    sun = add(bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2.0, (0.7, 0.3, 0)
    made.camera.location, made.camera.rotation_euler = (0, -8, 3), (1.25, 0, 0)
    made.render.use_motion_blur, made.render.motion_blur_shutter = True, 1.0
    made.frame_start, made.frame_end = 1, 3
    return made


def box(name="Box", size=2.0):
    data = cube(name, size)
    data.materials.append(material(name, (0.8, 0.3, 0.1)))
    return add(data, name)


def moving_box(scene):
    """It moves, turns and grows."""
    owner = box()
    owner.cycles.motion_steps = 3
    animate(owner, "location", [(-2, 0, 0), (0, 0, 0.5), (2, 1, 1)])
    animate(owner, "rotation_euler", [(0, 0, 0), (0, 0, 1), (0.5, 0, 2)])
    animate(owner, "scale", [(1, 1, 1), (1, 1, 0.5), (0.5, 1, 1)])


def moving_camera(scene):
    """It goes along, turns and zooms."""
    box()
    camera = scene.camera
    animate(camera, "location", [(-0.5, -8, 3), (0, -8, 3), (0.5, -7, 3)])
    animate(camera, "rotation_euler", [Euler((1.25, 0, -0.05)), Euler((1.25, 0, 0)), Euler((1.2, 0.1, 0))])
    animate(camera.data, "lens", [40, 50, 60])


def changing_shape(scene):
    """A shape key, on a smooth mesh under a shutter that opens slowly."""
    owner = box()
    owner.data.shade_smooth()
    owner.shape_key_add(name="Basis")
    other = owner.shape_key_add(name="other")
    for point in other.data:
        point.co.x += 4 * (point.co.x > 0)
        point.co.z += 3 * (point.co.y > 0)
    animate(other, "value", [-0.4, 0.4, 1])
    points = scene.render.motion_blur_shutter_curve.curves[0].points
    points[0].location, points[2].location = (0, 0.1), (1, 0.6)
    scene.render.motion_blur_shutter_curve.update()


def moving_lights(scene):
    """A lamp, and a mesh that shines."""
    lamp = add(bpy.data.lights.new("Lamp", "POINT"))
    lamp.data.energy, lamp.data.shadow_soft_size = 300, 0.2
    animate(lamp, "location", [(-3, -2, 1), (0, -2, 2), (3, -2, 1)])
    glow = add(cube("Glow", 0.4), "Glow")
    made = bpy.data.materials.new("Glow")
    tree = with_nodes(made)
    emission, out = (tree.nodes.new("ShaderNode" + kind) for kind in ("Emission", "OutputMaterial"))
    emission.inputs["Strength"].default_value = 15
    tree.links.new(emission.outputs[0], out.inputs["Surface"])
    glow.data.materials.append(made)
    animate(glow, "location", [(-3, 1, 1), (0, 0, 0.5), (2, -1, 0)])
    box("Box", 0.8)


def turning_collection(scene):
    """Instances of a collection by an empty that turns."""
    collection = bpy.data.collections.new("Boxes")
    for k in range(3):
        owner = box(f"Box {k}", 1.0)
        owner.location = (1.5 * k - 1.5, 0, 0.3 * k)
        scene.collection.objects.unlink(owner)
        collection.objects.link(owner)
    empty = add(None, "Empty", instance_type="COLLECTION")
    empty.instance_collection = collection
    animate(empty, "rotation_euler", [(0, 0, -0.4), (0, 0, 0), (0, 0, 0.6)])


def moving_nodes(scene):
    """Instances on the points of a plane that turns, and moved by the nodes themselves."""
    grain = box("Grain", 0.5)
    grain.location = (0, 50, 0)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=2, size=4)
    owner = bpy.context.object
    tree = bpy.data.node_groups.new("On points", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    start, end, place, info, along = (
        tree.nodes.new(kind)
        for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints",
                     "GeometryNodeObjectInfo", "GeometryNodeTransform")
    )  # fmt: skip
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = grain, True
    for source, target in (
        (start.outputs[0], place.inputs["Points"]),
        (info.outputs["Geometry"], place.inputs["Instance"]),
        (place.outputs[0], along.inputs[0]),
        (along.outputs[0], end.inputs[0]),
    ):
        tree.links.new(source, target)
    owner.modifiers.new("On points", "NODES").node_group = tree
    animate(owner, "rotation_euler", [(0, 0, -0.3), (0, 0, 0), (0, 0, 0.3)])
    animate(along.inputs["Translation"], "default_value", [(0, 0, 0), (0, 0, 0.7), (0, 0, 1.4)])


def particles(scene):
    """Boxes thrown up from a plane."""
    grain = box("Grain", 0.5)
    grain.location = (0, 50, 0)
    bpy.ops.mesh.primitive_plane_add(size=4, location=(0, 0, -0.9))
    emitter = bpy.context.object
    emitter.modifiers.new("Particles", "PARTICLE_SYSTEM")
    system = emitter.particle_systems[0].settings
    system.count, system.frame_start, system.frame_end, system.lifetime = 30, -8, 4, 50
    system.normal_factor, system.factor_random = 6.0, 1.0
    system.render_type, system.instance_object = "OBJECT", grain
    system.particle_size, system.effector_weights.gravity = 1.0, 0.0
    for frame in range(-8, 3):
        scene.frame_set(frame)


def shaped_by_nodes(scene, by="offset", points=False):
    """A box whose geometry nodes move its corners, or say how fast they move; or balls on its corners."""
    owner = box("Shaped", 0.8)
    tree = bpy.data.node_groups.new("Shape", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    chain = [tree.nodes.new("NodeGroupInput")]
    if points:
        chain.append(tree.nodes.new("GeometryNodeMeshToPoints"))
        chain[-1].inputs["Radius"].default_value = 0.25
    if by == "offset":
        moved, offset = tree.nodes.new("GeometryNodeSetPosition"), tree.nodes.new("ShaderNodeCombineXYZ")
        tree.links.new(offset.outputs[0], moved.inputs["Offset"])
        animate(offset.inputs["X"], "default_value", [-0.8, 0, 0.8])
        chain.append(moved)
    else:
        chain.append(tree.nodes.new("GeometryNodeStoreNamedAttribute"))
        chain[-1].data_type = "FLOAT_VECTOR"
        chain[-1].inputs["Name"].default_value = "velocity"
        value = next(socket for socket in chain[-1].inputs if socket.name == "Value" and socket.enabled)
        value.default_value = (20, 0, 10)  # a second has 24 frames
    if points:
        chain.append(tree.nodes.new("GeometryNodeSetMaterial"))
        chain[-1].inputs["Material"].default_value = owner.data.materials[0]
    chain.append(tree.nodes.new("NodeGroupOutput"))
    for source, target in pairwise(chain):
        tree.links.new(source.outputs[0], target.inputs[0])
    owner.modifiers.new("Shape", "NODES").node_group = tree


def moving_cloud(scene):
    """A point cloud that moves and turns."""
    tufts.cloud(scene, material("Clay", (0.8, 0.3, 0.1)))
    owner = bpy.data.objects["Cloud"]
    animate(owner, "location", [(-1, 0, 0), (0, 0, 0.3), (1, 0, 0)])
    animate(owner, "rotation_euler", [(0, 0, 0), (0, 0.3, 0.5), (0, 1, 1)])
