"""Raycast: what a shader's own ray meets, as in Cycles, pixel by pixel.

A ball, a box and a floor; rays along the normal, along a direction of any length, from the surface or from
elsewhere, among all objects or within their own.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, mesh  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.seen_nodes import build  # noqa: E402

pytestmark = pytest.mark.skipif(not hasattr(bpy.types, "ShaderNodeRaycast"), reason="this Blender has none")


SIZE = (40, 40)


@pytest.fixture(scope="module")
def stage():
    scene, tree = build()
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    floor = mesh([(-4, -4, -1.2), (4, -4, -1.2), (4, 4, -1.2), (-4, 4, -1.2)], [(0, 1, 2, 3)], "Floor")
    floor.materials.append(bpy.data.materials["Test"])
    floor.attributes.new("Where", "FLOAT_VECTOR", "POINT").data.foreach_set(
        "vector", [0.2, 0.1, 0.0, 0.9, 0.3, 0.5, 0.4, 0.8, 1.0, 0.1, 0.6, 0.3]
    )
    add(floor, "Floor")
    return scene, tree


def casting(tree, output, local=False, length=5.0, direction=None, position=None):
    """The material shines with an output of a Raycast node; the node."""
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNodeRaycast")
    node.only_local = local
    node.inputs["Length"].default_value = length
    for name, value in (("Direction", direction), ("Position", position)):
        if isinstance(value, str):
            tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs[value], node.inputs[name])
        elif value is not None:
            vector = tree.nodes.new("ShaderNodeCombineXYZ")
            for k in range(3):
                vector.inputs[k].default_value = value[k]
            tree.links.new(vector.outputs[0], node.inputs[name])
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    if output is not None:
        tree.links.new(node.outputs[output], shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    return node, shine


def check(folder):
    """One look per pixel, at its centre: equal but for edges and places within 1/200 pixel."""
    theirs, mine = by_cycles(1, SIZE, folder)[0][..., :3], by_engine(1, SIZE)[0][..., :3]
    assert np.abs(theirs).max() > 0
    wrong = (np.abs(mine - theirs) > 0.01 * np.abs(theirs) + 0.005).any(axis=2)
    assert wrong.mean() < 0.02, (wrong.sum(), mine[wrong][:3], theirs[wrong][:3])


@pytest.mark.parametrize("output", ["Is Hit", "Hit Distance", "Hit Position", "Hit Normal"])
def test_along_the_normal(output, stage, tmp_path):
    casting(stage[1], output)
    check(tmp_path)


@pytest.mark.parametrize("output", ["Self Hit", "Hit Distance", "Hit Position"])
def test_along_a_long_direction(output, stage, tmp_path):
    """Length and distance count in units of the direction."""
    casting(stage[1], output, direction=(2.0, 0.3, -0.4), length=1.0, position="Position")
    check(tmp_path)


@pytest.mark.parametrize("output", ["Is Hit", "Hit Position", "Hit Normal"])
def test_within_the_own_object(output, stage, tmp_path):
    casting(stage[1], output, local=True, direction=(-0.5, 1.0, 0.2))
    check(tmp_path)


@pytest.mark.parametrize("output", ["Self Hit", "Hit Normal"])
def test_from_elsewhere(output, stage, tmp_path):
    """From a point between the objects toward the shaded one."""
    casting(stage[1], output, direction="Position", position=(0.0, -0.2, 0.1), length=0.9)
    check(tmp_path)


def test_an_attribute_of_what_is_met(stage, tmp_path):
    node, shine = casting(stage[1], None, direction=(0.1, 0.1, -1.0))
    node.sample_attribute_items.new("VECTOR", "Found")
    node.inputs["Found"].default_value = "Where"
    stage[1].links.new(node.outputs["Found"], shine.inputs["Color"])
    check(tmp_path)


def test_the_sky_meets_nothing(stage, tmp_path):
    """Where there is no surface the distance is the length, all else 0."""
    scene, tree = stage
    casting(tree, "Is Hit")
    world = bpy.data.worlds.new("World")
    sky = world.node_tree
    sky.nodes.clear()
    node = sky.nodes.new("ShaderNodeRaycast")
    node.inputs["Length"].default_value = 0.7
    light, end = sky.nodes.new("ShaderNodeBackground"), sky.nodes.new("ShaderNodeOutputWorld")
    sky.links.new(node.outputs["Hit Distance"], light.inputs["Color"])
    sky.links.new(light.outputs[0], end.inputs["Surface"])
    world.cycles.sampling_method = "NONE"
    before, scene.world = scene.world, world
    check(tmp_path)
    scene.world = before
