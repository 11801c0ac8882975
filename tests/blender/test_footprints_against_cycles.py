"""Bump after bounces: the width of the ray decides what the surface looks like in mirrors and glass.

A wall shines with the normal that Bump gives it, of waves hardly wider than its steps. It is seen directly,
in a flat and in a curved mirror, through a refracting pane, and as light on a matt floor.
"""

from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, empty_scene, mesh  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402

SIZE = (48, 48)


def material(name, kind, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node, end = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeOutputMaterial")
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    return made, tree, node


def bumpy():
    """Emission of the bumped normal's x and z."""
    made, tree, shine = material("Bumpy", "Emission")
    where, waves = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeTexWave")
    bump = tree.nodes.new("ShaderNodeBump")
    waves.bands_direction, waves.inputs["Scale"].default_value = "DIAGONAL", 1.0
    bump.inputs["Distance"].default_value, bump.inputs["Filter Width"].default_value = 0.3, 2.0
    half = tree.nodes.new("ShaderNodeVectorMath")
    half.operation = "MULTIPLY_ADD"
    half.inputs[1].default_value = half.inputs[2].default_value = (0.5, 0.5, 0.5)
    tree.links.new(where.outputs["Position"], waves.inputs["Vector"])
    tree.links.new(waves.outputs["Fac"], bump.inputs["Height"])
    tree.links.new(bump.outputs["Normal"], half.inputs[0])
    tree.links.new(half.outputs[0], shine.inputs["Color"])
    return made


def square(name, made, half=1.0, **settings):
    data = mesh(
        [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [(0, 1, 2, 3)], name
    )
    data.materials.append(made)
    return add(data, name, **settings)


def wall_and(kind, **inputs):
    """The wall faces +Z at z = 0; the camera at its side looks at a square of the material above it."""
    scene = empty_scene()
    square("Wall", bumpy(), 6.0)
    made, *_ = material("Seen", kind, **inputs)
    camera = scene.camera
    camera.data.clip_start = 0.5
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    return scene, camera, made


@pytest.mark.parametrize("how", ["direct", "mirror", "pane"])
def test_bump_looks_the_same_in_a_mirror_and_through_glass(how, tmp_path: Path):
    """One look per pixel, Dirac bounces: pixel by pixel, but for edges and places within 1/200 pixel."""
    kind = {"mirror": "BsdfAnisotropic", "pane": "BsdfRefraction", "direct": "BsdfDiffuse"}[how]
    inputs = {"direct": {}, "mirror": {"Roughness": 0.0}, "pane": {"Roughness": 0.0, "IOR": 1.3}}[how]
    _, camera, made = wall_and(kind, **inputs)
    if how == "mirror":
        camera.location, camera.rotation_euler = (0, 0, 1.0), (np.pi, 0, 0)
        square("Mirror", made, 3.0, location=(0, 0, 4), rotation_euler=(0.1, 0.2, 0))
    else:
        camera.location = (0, 0, 5)
        if how == "pane":
            square("Pane", made, 3.0, location=(0, 0, 2), rotation_euler=(0.1, 0.2, 0))
    theirs, _ = by_cycles(1, SIZE, tmp_path)
    mine, _ = by_engine(1, SIZE)
    error = np.abs(mine - theirs)[..., :3].max(axis=2)
    assert np.quantile(error, 0.97) < 0.02
    assert np.median(error) < 1e-3


@pytest.mark.parametrize("kind", ["BsdfDiffuse", "BsdfAnisotropic"])
def test_light_from_a_bumpy_wall_on_a_floor(kind, tmp_path: Path):
    """A bounce, however wide its lobe, leaves the cone as it is: the floor is lit by the wall's every bump.

    By BSDF samples alone: where Cycles samples emissive meshes it takes Bump's normal for zero.
    """
    _, camera, made = wall_and(kind)
    bpy.data.materials["Bumpy"].cycles.emission_sampling = "NONE"
    camera.location = (0, -6, 3)
    camera.rotation_euler = (np.pi / 2, 0, 0)
    square("Floor", made, 3.0, location=(0, 0, 3), rotation_euler=(np.pi * 0.55, 0, 0))
    theirs, mine = (
        np.array(by_cycles(64, SIZE, tmp_path)),
        np.array(by_engine(64, SIZE, integrator="direct_bsdf")),
    )
    cells = [a[..., :3].reshape(2, 4, 12, 4, 12, 3).mean(axis=(2, 4)) for a in (theirs, mine)]
    spread = np.sqrt(sum(((c[0] - c[1]) ** 2).mean() for c in cells) / 2)
    difference = cells[0].mean(axis=0) - cells[1].mean(axis=0)
    assert np.sqrt((difference**2).mean()) < 2 * spread
