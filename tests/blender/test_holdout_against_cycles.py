"""Holes in the film where Cycles has them: colour and alpha of sheets without any random choice."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import with_nodes  # noqa: E402
from support.bpy_scenes import add, empty_scene, mesh  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402

EMISSION = {"Color": (1.0, 0.6, 0.3, 1.0), "Strength": 2.0}
VEIL = {"Color": (0.9, 0.6, 0.3, 1.0)}


def shader(tree, kind, sockets):
    node = tree.nodes.new("ShaderNode" + kind)
    for name, value in sockets.items():
        node.inputs[name].default_value = value
    return node.outputs[0]


def material(join=None, share=0.0, kind=None, sockets=(), holdout=True):
    """A holdout, a shader, or both mixed or added."""
    made = bpy.data.materials.new("Sheet")
    tree = with_nodes(made)
    parts = [shader(tree, kind, dict(sockets))] if kind else []
    parts += [tree.nodes.new("ShaderNodeHoldout").outputs[0]] if holdout else []
    result = parts[0]
    if join:
        node = tree.nodes.new(f"ShaderNode{join}Shader")
        if join == "Mix":
            node.inputs[0].default_value = share
        for part, socket in zip(parts, node.inputs[-2:], strict=True):
            tree.links.new(part, socket)
        result = node.outputs[0]
    tree.links.new(result, tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


SHEETS = [  # from the top down, a pixel each
    [material],
    [lambda: material("Mix", 0.3, "Emission", EMISSION)],
    [lambda: material("Add", kind="Emission", sockets=EMISSION)],
    [lambda: material("Add", kind="BsdfTransparent", sockets=VEIL)],
    [
        lambda: material("Mix", 0.4, "BsdfTransparent", VEIL),
        lambda: material(kind="Emission", sockets=EMISSION),
    ],
    [lambda: material(kind="BsdfTransparent", sockets=VEIL, holdout=False), material],
    [lambda: material(kind="BsdfTransparent", sockets=VEIL, holdout=False)],
    [],
]


@pytest.mark.parametrize("clear", [False, True])
def test_colour_and_alpha_are_cycles(clear, tmp_path):
    """Both sum the same few products in float32."""
    scene = empty_scene()
    sky = bpy.data.worlds.new("Sky")
    background = with_nodes(sky).nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (0.2, 0.4, 0.8, 1.0)
    end = sky.node_tree.nodes.new("ShaderNodeOutputWorld")
    sky.node_tree.links.new(background.outputs[0], end.inputs["Surface"])
    scene.world, scene.render.film_transparent = sky, clear
    for x, layers in enumerate(SHEETS):
        for k, made in enumerate(layers):
            sheet = mesh([(x, -2, -k), (x + 1, -2, -k), (x + 1, 2, -k), (x, 2, -k)], [(0, 1, 2, 3)])
            sheet.materials.append(made())
            add(sheet)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", len(SHEETS)
    scene.camera.location = (len(SHEETS) / 2, 0, 5)
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    size = (len(SHEETS), 4)  # Blender makes no smaller pictures
    theirs, ours = by_cycles(1, size, tmp_path)[0], by_engine(1, size)[0]
    np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=1e-6)
    assert theirs[0, 0].tolist() == [0, 0, 0, 0]
    assert 0 < theirs[0, 1, 3] < 1
