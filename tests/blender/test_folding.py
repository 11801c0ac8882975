"""Which nodes Blender folds where all their inputs are constants: what `export.folding` takes for granted."""

import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import with_nodes  # noqa: E402
from support.parity.cases import VALUES, kinds  # noqa: E402

from pt_engine.blender.export.folding import FOLDED  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 2, 0), reason="earlier Blenders fold other nodes")


def is_folded(kind):
    """Whether a node with constant inputs is gone from what Cycles gets; None without outputs of values."""
    material = bpy.data.materials.new("Folded")
    tree = with_nodes(material)
    node, shine = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeEmission")
    outputs = [s for s in node.outputs if s.type in VALUES and not s.is_unavailable]
    if not outputs:
        return None
    for socket in node.inputs:
        if socket.hide_value and not socket.is_unavailable:
            tree.links.new(tree.nodes.new("ShaderNodeCombineXYZ").outputs[0], socket)
    tree.links.new(outputs[0], shine.inputs[0])
    tree.links.new(shine.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
    inlined = bpy.types.InlineShaderNodes.from_material(material)
    return "ShaderNode" + kind not in {n.bl_idname for n in inlined.node_tree.nodes}


def test_blender_folds_the_nodes_that_we_say_it_folds():
    assert {kind for kind in kinds() if is_folded(kind)} == FOLDED
