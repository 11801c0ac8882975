"""Cycles' own answers: a node's output as emission, on faces whose inputs are face attributes.

Every case is a sheet of faces, one pixel each; face attributes i0, i1, ... (vectors) feed the node's
inputs, so that a pixel's value does not depend on where in the pixel Cycles looks. All sheets lie side
by side under one orthographic camera: one render answers every case.
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray
from support.bpy_nodes import with_nodes
from support.exr import pixels

from .cases import VALUES, Case, recipe
from .sweeps import SIDE, Feed, Table

Float32 = NDArray[np.float32]


def sheet(name: str, table: Table, column: int, row: int) -> Any:
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


def material(case: Case) -> tuple[Any, list[Feed]]:
    """A material that shines with the output of the case's node, and what feeds its inputs."""
    made = bpy.data.materials.new(case.name)
    tree = with_nodes(made)
    node = tree.nodes.new("ShaderNode" + case.kind)
    for key, value in case.settings:
        setattr(node, key, value)
    if case.setup:
        recipe(case.kind).setups[case.setup](node)
    fed = []
    for socket in node.inputs:
        if socket.type in VALUES - {"ROTATION"} and not socket.is_unavailable:
            fed.append(feed_of(case.kind, socket, f"i{len(fed)}"))
            feed(tree, socket, fed[-1].name)
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    source = next(s for s in node.outputs if s.identifier == case.output)
    tree.links.new(source, shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    return made, fed


def feed_of(kind: str, socket: Any, name: str) -> Feed:
    """The ranges of a socket's values."""
    hints = recipe(kind)
    bounds = hints.ranges.get(socket.identifier, (-0.3, 1.5) if socket.type == "RGBA" else (-2.0, 2.0))
    return Feed(name, bounds, hints.limits.get(socket.identifier, (-hints.reach, hints.reach)))


def feed(tree: Any, socket: Any, name: str) -> None:
    """Link an attribute to a socket: its vector, or the first component."""
    attribute = tree.nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = name
    source = attribute.outputs["Vector"]
    if socket.type not in ("VECTOR", "RGBA"):
        split = tree.nodes.new("ShaderNodeSeparateXYZ")
        tree.links.new(source, split.inputs[0])
        source = split.outputs["X"]
    tree.links.new(source, socket)


def render(count: int) -> Float32:
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
        return pixels(path)[..., :3]


def place(number: int, count: int) -> tuple[int, int]:
    """Column and row of a sheet."""
    columns = math.ceil(math.sqrt(count))
    return number % columns, number // columns


def cut(picture: Float32, number: int, count: int) -> Float32:
    """(3, n) values of a sheet's pixels in the order of its faces."""
    column, row = place(number, count)
    part = picture[row * SIDE : (row + 1) * SIDE, column * SIDE : (column + 1) * SIDE]
    return np.ascontiguousarray(part.reshape(-1, 3).T)
