"""Ray portals lead where Cycles' lead: pictures without noise, and a floor lit through one."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import with_nodes  # noqa: E402
from support.bpy_scenes import add, empty_scene, mesh  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.lit_faces import constant  # noqa: E402

SIZE = (8, 4)


def square(x, z, half, made):
    """A sheet about (x, 0, z)."""
    data = mesh(
        [(x + i * half, j * half, z) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))], [(0, 1, 2, 3)]
    )
    data.materials.append(made)
    return add(data)


def end(made, output):
    tree = made.node_tree
    tree.links.new(output, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def chequered():
    """An emission that varies along the sheet, so that a picture tells where a ray has arrived."""
    made = bpy.data.materials.new("Chequered")
    tree = with_nodes(made)
    where, shine = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeEmission")
    move = tree.nodes.new("ShaderNodeVectorMath")
    move.inputs[1].default_value = (40, 40, 40)  # nothing shines with a negative colour
    tree.links.new(where.outputs["Position"], move.inputs[0])
    tree.links.new(move.outputs[0], shine.inputs["Color"])
    return end(made, shine.outputs[0])


def portal(shift=None, direction=(0.0, 0.0, 0.0), clear_share=0.0):
    """A portal by `shift`, mixed with Transparent."""
    made = bpy.data.materials.new("Portal")
    tree = with_nodes(made)
    node, mix = tree.nodes.new("ShaderNodeBsdfRayPortal"), tree.nodes.new("ShaderNodeMixShader")
    node.inputs["Color"].default_value = (0.9, 0.7, 0.5, 1)
    tree.links.new(constant(tree, direction), node.inputs["Direction"])
    if shift is not None:
        where, move = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeVectorMath")
        move.inputs[1].default_value = shift
        tree.links.new(where.outputs["Position"], move.inputs[0])
        tree.links.new(move.outputs[0], node.inputs["Position"])
    mix.inputs[0].default_value = clear_share
    tree.links.new(node.outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[2])
    return end(made, mix.outputs[0])


def parallel_camera(scene, size):
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", size
    scene.camera.location = (0.13, 0.07, 5)  # no ray through a diagonal, where Cycles meets a sheet twice


@pytest.mark.parametrize(
    ("shift", "direction"),
    [(None, (0, 0, 0)), ((30, 0, 0), (0, 0, 0)), ((30, 1, -1), (0.2, 0.1, -2)), (None, (1, 0.5, -0.3))],
)
def test_a_ray_arrives_where_cycles_does(shift, direction, tmp_path):
    """Positions to 0.02, of what is seen through a filter 0.006 wide at a slope of up to 3."""
    scene = empty_scene()
    square(0, 0, 3, portal(shift, direction))
    for x in (0, 30):
        square(x, -3, 14, chequered())
    parallel_camera(scene, 5)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    theirs, ours = by_cycles(1, SIZE, tmp_path)[0], by_engine(1, SIZE)[0]
    np.testing.assert_allclose(ours, theirs, atol=0.02)
    assert np.ptp(theirs[..., 0]) > 0.1


@pytest.mark.parametrize("clear_share", [0.0, 0.4])
def test_a_floor_is_lit_as_in_cycles(clear_share, tmp_path):
    """By a sheet through a portal, or by a lamp of no size behind one that is partly transparent.

    4.5 standard errors of both renders' means, from the differences between two seeds' pixels.
    """
    scene = empty_scene()
    square(0, 1, 3, portal((0, 0, 0.5), clear_share=clear_share))
    if clear_share:
        lamp = bpy.data.lights.new("Lamp", "POINT")
        lamp.energy, lamp.shadow_soft_size = 100.0, 0.0
        add(lamp, location=(0.5, 0, 2))
    else:
        square(0, 4, 3, chequered())
    gray = bpy.data.materials.new("Floor")
    square(0, 0, 20, end(gray, with_nodes(gray).nodes.new("ShaderNodeBsdfDiffuse").outputs[0]))
    parallel_camera(scene, 5)
    scene.camera.location = (0, 0, 0.5)
    theirs, ours = by_cycles(512, SIZE, tmp_path), by_engine(512, SIZE)
    spread = sum(((a - b) ** 2).sum(axis=(0, 1)) / 2 for a, b in (theirs, ours))  # of one picture's sum
    difference = np.abs((sum(theirs) - sum(ours)).sum(axis=(0, 1))) / 2
    assert (difference[:3] <= 4.5 * np.sqrt(spread[:3] / 2) + 1e-3).all(), (difference, np.sqrt(spread))
    assert sum(theirs)[..., 0].mean() > 0.01
