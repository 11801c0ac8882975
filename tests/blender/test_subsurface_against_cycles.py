"""Subsurface scattering in its diffuse limit, and volumes left out: what stands in for them, and who is told.

A block whose radius of scattering is a thousandth of its size, under an even sky of radiance 1: what it sends
to a camera above is its albedo. Burley's profile and a radius of 0 give the colour itself, as a diffuse
surface does; Cycles' random walks come out darker, for their map from colour to the medium's albedo is a fit.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import with_nodes  # noqa: E402
from support.bpy_scenes import add, cube, empty_scene  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402

from pt_engine.blender.export.scene import export_scene  # noqa: E402
from pt_engine.scene.prepare import prepare  # noqa: E402

COLOR = (0.9, 0.5, 0.1, 1.0)
SIZE = (8, 8)


def even_sky(scene):
    scene.world = bpy.data.worlds.new("Even")
    tree = with_nodes(scene.world)
    light, end = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    light.inputs["Color"].default_value = (1, 1, 1, 1)
    tree.links.new(light.outputs[0], end.inputs["Surface"])


def block(kind, socket="Surface", **values):
    """A block under the camera with one shader node at a socket of its output; (tree, node, end)."""
    scene = empty_scene()
    material = bpy.data.materials.new("Block")
    tree = with_nodes(material)
    node, end = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], end.inputs[socket])
    for name, value in values.items():
        name = name.replace("_", " ")
        if name in node.inputs:
            node.inputs[name].default_value = value
        else:
            setattr(node, name.replace(" ", "_"), value)
    data = cube()
    data.materials.append(material)
    add(data, "Block", scale=(4, 4, 4), location=(0, 0, -4))
    even_sky(scene)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 1.0
    scene.camera.location, scene.camera.rotation_euler = (0, 0, 5), (0, 0, 0)
    return tree, node, end


def block_of(kind, method, radius):
    if kind == "SubsurfaceScattering":
        block(kind, Color=COLOR, Scale=1.0, Radius=(radius,) * 3, falloff=method)
        return
    matt = {"Base_Color": COLOR, "Specular_IOR_Level": 0.0, "Subsurface_Weight": 1.0}
    block(kind, **matt, Subsurface_Scale=1.0, Subsurface_Radius=(radius,) * 3, subsurface_method=method)


def albedos(folder):
    """(3,) ours and Cycles'."""
    pair = by_engine(16, SIZE), by_cycles(128, SIZE, folder)
    return [np.mean([image[..., :3].mean(axis=(0, 1)) for image in images], axis=0) for images in pair]


def states():
    """What the coverage says of the block."""
    found = prepare(export_scene(bpy.context.evaluated_depsgraph_get())).coverage
    return [(e.state, e.effect) for e in found if e.material == "Block" and e.state != "exact"]


@pytest.mark.parametrize("kind", ["SubsurfaceScattering", "BsdfPrincipled"])
@pytest.mark.parametrize(("method", "radius"), [("BURLEY", 4e-3), ("RANDOM_WALK", 0.0)])
def test_the_limit_is_the_colour(method, radius, kind, tmp_path):
    """Noise: 2·64·16 samples of a spread below 0.5 leave 0.01."""
    block_of(kind, method, radius)
    ours, theirs = albedos(tmp_path)
    np.testing.assert_allclose(theirs, COLOR[:3], atol=2e-3)
    np.testing.assert_allclose(ours, COLOR[:3], atol=0.01)


@pytest.mark.parametrize("method", ["RANDOM_WALK", "RANDOM_WALK_SKIN"])
def test_random_walks_are_darker_by_no_more_than_a_fifteenth(method, tmp_path):
    """Measured: 0.855, 0.435, 0.078 and 0.886, 0.475, 0.093 for 0.9, 0.5, 0.1."""
    block_of("BsdfPrincipled", method, 1e-3)
    ours, theirs = albedos(tmp_path)
    assert (theirs < ours + 0.01).all()
    np.testing.assert_allclose(theirs, ours, atol=0.075)


@pytest.mark.parametrize("kind", ["SubsurfaceScattering", "BsdfPrincipled"])
def test_coverage_tells_of_the_limit_where_there_is_a_radius(kind):
    block_of(kind, "RANDOM_WALK", 0.1)
    ((state, effect),) = states()
    assert state == "approximate"
    assert "light leaves where it enters" in effect
    block_of(kind, "RANDOM_WALK", 0.0)
    assert states() == []


@pytest.mark.parametrize("kind", ["VolumeAbsorption", "VolumeScatter", "VolumePrincipled", "MixShader"])
def test_coverage_tells_that_a_volume_is_left_out(kind):
    """The surface is rendered as if the inside were clear."""
    tree, _, end = block(kind, "Volume")
    glass = tree.nodes.new("ShaderNodeBsdfTransparent")
    tree.links.new(glass.outputs[0], end.inputs["Surface"])
    assert states() == [("ignored", "the volume is left out: clear inside")]
    assert np.allclose(by_engine(4, SIZE)[0][..., :3], 1, atol=1e-5)


def test_coverage_tells_that_the_air_is_left_out():
    block("BsdfDiffuse")
    tree = bpy.context.scene.world.node_tree
    end = next(n for n in tree.nodes if n.type == "OUTPUT_WORLD")
    tree.links.new(tree.nodes.new("ShaderNodeVolumeScatter").outputs[0], end.inputs["Volume"])
    found = prepare(export_scene(bpy.context.evaluated_depsgraph_get())).coverage
    assert [e.state for e in found if "volume" in e.effect.lower()] == ["ignored"]
