"""Nodes whose inputs are constants: Cycles gets what Blender has folded, otherwise than it computes them."""

import itertools

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support import cycles_nodes  # noqa: E402
from support.bpy_nodes import BLENDER_5, with_nodes  # noqa: E402
from support.bpy_scenes import empty_scene  # noqa: E402
from support.node_lanes import NodeLanes  # noqa: E402
from support.parity.recipes import RAMPS  # noqa: E402

from pt_engine.blender.export.images import ImageTable  # noqa: E402
from pt_engine.blender.export.materials import export_material  # noqa: E402
from pt_engine.nodes.compile import compile_materials  # noqa: E402

KINDS = ("FloatCurve", "RGBCurve", "VectorCurve")
EXTENDS = ("HORIZONTAL", "EXTRAPOLATED")
CLIP = (-0.2, 0.8)
INPUTS = ((0.0, 0.3, 0.7), (0.95, 2.0, -0.6), (-2.0, 0.137, 0.51))
CASES = [
    *itertools.product(KINDS, (False, True), EXTENDS, INPUTS, (1.0, 0.4), (False, True)),
    *(("Blackbody", kelvin) for kelvin in (1.0, 900.0, 1742.0, 3088.0, 6500.0, 10369.0, 40000.0)),
    *(
        ("ValToRGB", ramp, at)
        for ramp in RAMPS
        for at in (-0.5, 0.0, 0.0998, 0.3804, 0.5, 0.631, 0.9047, 1.5)
    ),
    *(("RGBToBW", color) for color in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))),
]


def of_one_input(kind, *given):
    """A temperature, a place on a ramp, a colour that a folded node makes in the place of a number."""
    made = bpy.data.materials.new("Folded")
    tree = with_nodes(made)
    node = tree.nodes.new("ShaderNode" + ("Mix" if kind == "RGBToBW" else kind))
    if kind == "RGBToBW":
        node.data_type, node.inputs[0].default_value = "RGBA", 0.0
        node.inputs[6].default_value = (*given[0], 1.0)
        source, node = node, tree.nodes.new("ShaderNodeMath")
        tree.links.new(next(s for s in source.outputs if s.identifier == "Result_Color"), node.inputs[0])
        node.operation, node.inputs[1].default_value = "MULTIPLY", 1.0
    else:
        node.inputs[0].default_value = given[-1]
    if kind == "ValToRGB":
        RAMPS[given[0]](node)
    show(tree, node)
    return made


def bent(kind, clip, extend, x, share, behind):
    """Steep curves, narrower or wider than the editor's range; the input behind a folded node or not."""
    made = bpy.data.materials.new("Folded")
    tree = with_nodes(made)
    node = tree.nodes.new("ShaderNode" + kind)
    bend(node, clip, extend)
    node.inputs[0].default_value = share
    if behind:
        source = tree.nodes.new("ShaderNodeCombineXYZ" if kind != "FloatCurve" else "ShaderNodeMath")
        for socket, value in zip(source.inputs, x if kind != "FloatCurve" else (x[0], 0.0), strict=False):
            socket.default_value = value
        tree.links.new(source.outputs[0], node.inputs[1])
    else:
        node.inputs[1].default_value = {"FloatCurve": x[0], "RGBCurve": (*x, 1), "VectorCurve": x}[kind]
    show(tree, node)
    return made


def show(tree, node):
    """Let the material shine with the node's first output."""
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(node.outputs[0], shine.inputs[0])
    tree.links.new(shine.outputs[0], end.inputs[0])


def bend(node, clip, extend):
    """Set a node's curves: other points in every channel."""
    mapping = node.mapping
    mapping.use_clip, mapping.extend = False, extend
    for k, curve in enumerate(mapping.curves):
        curve.points[0].location = (-1.2, -0.9) if k == 1 else (0.1, 0.1 * k - 0.4)
        curve.points[-1].location = (0.8, 1.3)
        curve.points.new(0.3, 0.9 - 0.2 * k)
    mapping.use_clip = clip
    if clip:
        mapping.clip_min_y, mapping.clip_max_y = CLIP
    mapping.update()


@pytest.fixture(scope="module")
def answers():
    """Case → Cycles' and our value."""
    empty_scene()
    materials = [(bent if case[0] in KINDS else of_one_input)(*case) for case in CASES]
    table = {"A": np.zeros((3, cycles_nodes.SIDE**2), np.float32)}
    for number, material in enumerate(materials):
        sheet = cycles_nodes.sheet("Sheet", table, *cycles_nodes.place(number, len(CASES)))
        sheet.data.materials.append(material)
    picture = cycles_nodes.render(len(CASES))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    images = ImageTable([])
    compiled = compile_materials([export_material(m.evaluated_get(depsgraph), images) for m in materials])
    found = {}
    for number, case in enumerate(CASES):
        value = compiled.batches[compiled.batch_of[number]].emission(NodeLanes(n=1, material=number))
        ours = np.zeros(3) if value is None else np.broadcast_to(value, (3, 1))[:, 0]
        found[case] = cycles_nodes.cut(picture, number, len(CASES))[:, 0], ours
    return found


@pytest.mark.parametrize("case", CASES, ids=lambda case: " ".join(str(part) for part in case))
def test_a_node_of_constants(case, answers):
    if case[0] in ("Blackbody", "RGBToBW") and not BLENDER_5:
        pytest.skip("Cycles 4.5 rounds its colour matrices otherwise")
    theirs, ours = answers[case]
    np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=2e-6)


@pytest.mark.parametrize("clip", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_only_float_curves_are_clipped(kind, clip, answers):
    """In Cycles' picture, where none of the input is mixed in; before Blender 5 nothing is folded."""
    whole = itertools.product(EXTENDS, INPUTS, (1.0,), (False, True))
    values = np.array([answers[kind, clip, *rest][0] for rest in whole])
    inside = (values > CLIP[0] - 1e-6) & (values < CLIP[1] + 1e-6)
    assert inside.all() == (kind == "FloatCurve" and clip and BLENDER_5)
