"""Closures lit by one lamp of no size, by Cycles and by us: a face a pixel, so a pixel is one f·cosθo.

Every material has a sheet of SIDE × SIDE faces, tilted any way toward a parallel camera straight above. The
lamp casts no shadow, so faces don't disturb each other, and there is no noise.
"""

import math

import bpy
import numpy as np
from mathutils import Vector
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, empty_scene, mesh
from support.cycles import by_cycles, by_engine

SIDE = 12
STEEPEST = 0.15  # cosine of the most tilted faces
SUNS = [(0.3, -0.2, 0.8), (-0.6, 0.5, 0.4)]


def sheet(number, columns, rng):
    """A mesh of tilted faces over the unit squares of sheet `number`."""
    cos = rng.uniform(STEEPEST, 1, SIDE * SIDE)
    slope = np.sqrt(1 - cos * cos) / cos
    azimuth = rng.uniform(0, 2 * np.pi, SIDE * SIDE)
    corners = []
    for k in range(SIDE * SIDE):
        x0, y0 = k % SIDE + number % columns * SIDE, k // SIDE + number // columns * SIDE
        across, along = slope[k] * np.cos(azimuth[k]), slope[k] * np.sin(azimuth[k])
        for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)):
            corners.append((x0 + x, y0 + y, (x - 0.5) * across + (y - 0.5) * along))
    return mesh(corners, np.arange(len(corners)).reshape(-1, 4).tolist())


def material(kind, sockets, **settings):
    """A material of one shader node; `sockets` by name, colours as three numbers."""
    made = bpy.data.materials.new(kind)
    tree = with_nodes(made)
    node = tree.nodes.new("ShaderNode" + kind)
    for name, value in settings.items():
        setattr(node, name, value)
    for name, value in sockets.items():
        if node.inputs[name].type == "VECTOR":  # linked, as a tangent's own value is never looked at
            tree.links.new(constant(tree, value), node.inputs[name])
        else:
            node.inputs[name].default_value = (*value, 1.0) if isinstance(value, tuple) else value
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def constant(tree, vector):
    """The output of a node that gives a vector."""
    node = tree.nodes.new("ShaderNodeCombineXYZ")
    for name, value in zip("XYZ", vector, strict=True):
        node.inputs[name].default_value = value
    return node.outputs[0]


def pictures(cases, folder, seed=1):
    """[(K, SIDE, SIDE, 3) by Cycles, by us]: each sheet under each of the suns side by side."""
    scene, rng = empty_scene(), np.random.default_rng(seed)
    columns = math.ceil(math.sqrt(len(cases)))
    for number, made in enumerate(cases):
        data = sheet(number, columns, rng)
        data.materials.append(made())
        add(data)
    size = columns * SIDE
    camera = scene.camera
    camera.data.type, camera.data.ortho_scale, camera.data.clip_end = "ORTHO", size, 1e4
    camera.location = (size / 2, size / 2, 100)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle, sun.use_shadow = 1.0, 0.0, False
    lamp = add(sun)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    found = []
    for direction in SUNS:
        lamp.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
        bpy.context.view_layer.update()
        theirs = by_cycles(1, (size, size), folder, max_bounces=0)[0]
        pair = theirs, by_engine(1, (size, size), max_depth=2)[0]  # light that is reflected once
        found.append([cut(image[::-1, :, :3], len(cases), columns) for image in pair])
    return np.concatenate([f[0] for f in found], axis=2), np.concatenate([f[1] for f in found], axis=2)


def cut(image, count, columns):
    """(K, SIDE, SIDE, 3): the sheets of a picture."""
    places = [(k // columns * SIDE, k % columns * SIDE) for k in range(count)]
    return np.array([image[y : y + SIDE, x : x + SIDE] for y, x in places])
