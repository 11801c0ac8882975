"""Cycles' own answer for a node: its output as emission, on faces whose inputs are face attributes.

Every case is a sheet of faces, one pixel each; face attributes A, B, C, D (vectors) feed the node's
inputs, so that a pixel's value does not depend on where in the pixel Cycles looks. All sheets lie side
by side under one orthographic camera: one render answers every case.
"""

import math
import tempfile
from pathlib import Path

import bpy
import numpy as np

SIDE = 16  # pixels along a sheet
NAMES = ("A", "B", "C", "D")


def inputs(seed, low=-2.0, high=2.0):
    """(3, n) inputs of the four attributes: random, with zeros, ones and negatives among them."""
    rng = np.random.default_rng(seed)
    n = SIDE * SIDE
    table = {}
    for k, name in enumerate(NAMES):
        values = rng.uniform(low, high, (3, n)).astype(np.float32)
        special = np.array([0, 1, -1, 0.5, 2], np.float32)
        values[:, k::11] = rng.choice(special, (3, len(range(k, n, 11))))
        table[name] = values
    return table


def sheet(name, table, column, row):
    """A mesh object of SIDE×SIDE unit faces at a place in the picture, with the attributes."""
    x, y = np.meshgrid(np.arange(SIDE + 1), np.arange(SIDE + 1))
    corners = np.stack([x.ravel() + column * SIDE, y.ravel() + row * SIDE, np.zeros(x.size)], axis=1)
    first = (np.arange(SIDE)[:, None] * (SIDE + 1) + np.arange(SIDE)).ravel()
    faces = np.stack([first, first + 1, first + SIDE + 2, first + SIDE + 1], axis=1)
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners.tolist(), [], faces.tolist())
    for key, values in table.items():
        attribute = data.attributes.new(key, "FLOAT_VECTOR", "FACE")
        attribute.data.foreach_set("vector", np.ascontiguousarray(values.T).ravel())
    owner = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(owner)
    return owner


def material(name, kind, settings, links, output):
    """A material that shines with an output of a node; `links` feed sockets from attributes.

    `links` maps a socket identifier to an attribute's name (its vector), to `name.x` (a component), or
    to a constant.
    """
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNode" + kind)
    for key, value in settings.items():
        if callable(value):
            value(node)
        else:
            setattr(node, key, value)
    for socket in node.inputs:
        if socket.identifier in links:
            feed(tree, socket, links[socket.identifier])
    shine = tree.nodes.new("ShaderNodeEmission")
    end = tree.nodes.new("ShaderNodeOutputMaterial")
    source = next(s for s in node.outputs if s.identifier == output)
    tree.links.new(source, shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    return made


def feed(tree, socket, source):
    """Link an attribute to a socket, or set its value."""
    if not isinstance(source, str):
        socket.default_value = source
        return
    name, _, axis = source.partition(".")
    attribute = tree.nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = name
    vector = attribute.outputs["Vector"]
    if axis:
        split = tree.nodes.new("ShaderNodeSeparateXYZ")
        tree.links.new(vector, split.inputs[0])
        vector = split.outputs["xyz".index(axis)]
    tree.links.new(vector, socket)


def render(count):
    """(H, W, 3) Cycles' picture of `count` sheets, one sample per pixel, bottom row first."""
    columns = math.ceil(math.sqrt(count))
    size = columns * SIDE
    scene = bpy.context.scene
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", size
    owner = bpy.data.objects.new("Camera", camera)
    owner.location = (size / 2, size / 2, 10)
    scene.collection.objects.link(owner)
    scene.camera = owner
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.filter_size = 0.01
    scene.cycles.filter_width = 0.01
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling = 1, False
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 0
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    scene.cycles.device = "CPU"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.exr_codec = "NONE"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "nodes.exr")
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(str(path))
        image.colorspace_settings.name = "Non-Color"
        pixels = np.empty(size * size * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
    return pixels.reshape(size, size, -1)[..., :3]


def place(number, count):
    """Column and row of a sheet."""
    columns = math.ceil(math.sqrt(count))
    return number % columns, number // columns


def cut(picture, number, count):
    """(3, n) values of a sheet's pixels in the order of its faces."""
    column, row = place(number, count)
    part = picture[row * SIDE : (row + 1) * SIDE, column * SIDE : (column + 1) * SIDE]
    return np.ascontiguousarray(part.reshape(-1, 3).T)
