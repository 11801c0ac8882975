"""A node's output seen by a camera: our whole way from export to hit, and Cycles' picture of the same.

Objects with shear, mirroring, smooth and flat faces shine with a node's output. Cycles takes one sample per
pixel within a hundredth of it about its centre; how much we change over that way may be the difference.
Pixels on an edge may see different faces, so a small share of pixels may differ.
"""

from __future__ import annotations

from typing import NamedTuple

import bpy
import numpy as np
import pytest
from support.bpy_scenes import add, cube, empty_scene, export
from support.camera_view import SIZE, cycles, one_sample, shot

from pt_engine.scene.prepare import prepare

EXACT = 1e-4
JITTER = 0.005  # half the width of Cycles' narrowest filter
EDGES = 0.02  # share of pixels on an edge between faces


def sphere():
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    owner = bpy.context.object
    data = owner.data
    bpy.data.objects.remove(owner)
    data.shade_smooth()
    return data


def with_layers(data):
    """A uv map and a corner colour attribute that vary."""
    if not data.uv_layers:
        data.uv_layers.new(name="UVMap")
    uv = np.array([c for k in range(len(data.loops)) for c in ((k % 4) in (1, 2), (k % 4) > 1)], np.float32)
    if len(data.polygons) == 6:
        data.uv_layers[0].data.foreach_set("uv", uv * 1.3 - 0.1)
    color = data.color_attributes.new("Tint", "FLOAT_COLOR", "CORNER")
    values = np.random.default_rng(5).uniform(0, 1, (len(data.loops), 4)).astype(np.float32)
    color.data.foreach_set("color", values.ravel())
    return data


def build():
    scene = empty_scene()
    camera = scene.camera
    camera.location, camera.rotation_euler = (0.4, -7.0, 2.2), (1.28, 0.05, 0.06)
    settings = {"pass_index": 3, "color": (0.2, 0.5, 0.7, 0.6)}
    made = bpy.data.materials.new("Test")
    made.use_nodes = True
    ball_data, box_data = with_layers(sphere()), with_layers(cube())
    for data in (ball_data, box_data):
        data.materials.append(made)
    ball = add(ball_data, "Ball", location=(-1.4, 0, 0.2), scale=(1.2, 1.2, 1.2), **settings)
    ball.rotation_euler = (0.3, 0.5, 0.2)
    box = add(box_data, "Box", location=(1.4, 0.5, 0), scale=(0.8, -0.7, 1.1), **settings)
    box.rotation_euler = (0.4, 0.3, 0.7)
    one_sample(scene)
    return scene, made.node_tree


class Case(NamedTuple):
    """Nodes from source to output; what feeds the node; how many pixels may differ and by how much."""

    kind: str
    output: str
    settings: dict
    links: dict
    share: float = EDGES
    tolerance: float = EXACT


def case(kind, output, share=EDGES, tolerance=EXACT, links=None, **settings):
    label = " ".join([kind, output, *(str(v) for v in settings.values() if isinstance(v, str | bool))])
    return pytest.param(Case(kind, output, settings, links or {}, share, tolerance), id=label)


def since_5(reason, *cases):
    """Cases that Blender 4.5 is not asked."""
    mark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason=reason)
    return [pytest.param(*c.values, id=c.id, marks=mark) for c in cases]


def picture():
    """A small byte image with structure in every channel."""
    image = bpy.data.images.get("Picture")
    if image is None:
        image = bpy.data.images.new("Picture", 7, 5, alpha=True)
        values = np.random.default_rng(2).integers(0, 256, (5, 7, 4)).astype(np.float32) / 255
        values[..., 3] = np.maximum(values[..., 3], 0.3)
        image.pixels.foreach_set(values.ravel())
        image.update()
        image.pack()
    return image


def set_up(tree, c):
    """The material shines with the case's output."""
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNode" + c.kind)
    for key, value in c.settings.items():
        setattr(node, key, picture() if key == "image" else value)
    sources = {}
    for name, source in c.links.items():
        if isinstance(source, tuple) and isinstance(source[0], str):
            kind, output = source
            if kind not in sources:
                sources[kind] = tree.nodes.new("ShaderNode" + kind)
            tree.links.new(sources[kind].outputs[output], node.inputs[name])
        else:
            node.inputs[name].default_value = source
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(next(s for s in node.outputs if s.identifier == c.output), shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])


def ours():
    """(3, n) our picture, and how much a pixel may change as far from its centre as Cycles may look."""
    ready = prepare(export()).with_pixels(SIZE, SIZE)
    centre, *beside = (shot(ready, (0.5 + x, 0.5 + y)) for x, y in ((0, 0), (JITTER, 0), (0, JITTER)))
    return centre, sum(np.abs(other - centre) for other in beside)


def compare(scene, tree, c):
    """The case's output, by both."""
    set_up(tree, c)
    check(scene, c.share, c.tolerance)


def check(scene, share=EDGES, tolerance=EXACT):
    """Fail where more pixels differ than are allowed."""
    theirs, (mine, change) = cycles(scene), ours()
    beyond = np.maximum(np.abs(mine - theirs) - change, 0)
    error = beyond.max(axis=0) / (np.abs(theirs).max(axis=0) + 0.01)
    seen = np.abs(theirs).max(axis=0) + np.abs(mine).max(axis=0) > 0
    wrong = ~(error <= tolerance) & seen
    worst = np.argsort(error * seen)[-3:]
    assert wrong.sum() <= share * max(seen.sum(), 1000), (
        f"{wrong.sum()} of {seen.sum()} pixels differ, for example at {worst}: "
        f"{mine[:, worst].T} instead of {theirs[:, worst].T}"
    )
