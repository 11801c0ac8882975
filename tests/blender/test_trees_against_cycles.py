"""How trees are put together: zones, closures, bundles, switches, groups, mutes, drivers; as in Cycles."""

import pytest

bpy = pytest.importorskip("bpy")
from support.seen_nodes import build, check  # noqa: E402

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="zones and closures came with Blender 5")


@pytest.fixture(scope="module")
def stage():
    return build()


@pytest.fixture(name="tree")
def _tree(stage):
    _, tree = stage
    tree.nodes.clear()
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    return tree


def new(tree, kind, **settings):
    node = tree.nodes.new(kind if "Node" in kind else f"ShaderNode{kind}")
    for key, value in settings.items():
        setattr(node, key, value)
    return node


def position(tree):
    return new(tree, "NewGeometry").outputs["Position"]


def shown(stage, tree, output):
    """The output is the material's light."""
    tree.links.new(output, next(n for n in tree.nodes if n.type == "EMISSION").inputs["Color"])
    check(stage[0])


def scaled(tree, source, by):
    """A vector times a number."""
    node = new(tree, "VectorMath", operation="SCALE")
    tree.links.new(source, node.inputs[0])
    node.inputs["Scale"].default_value = by
    return node


def test_a_repeat_zone_and_its_iteration(stage, tree):
    start, end = new(tree, "GeometryNodeRepeatInput"), new(tree, "GeometryNodeRepeatOutput")
    start.pair_with_output(end)
    end.repeat_items.clear()
    end.repeat_items.new("VECTOR", "Value")
    start.inputs["Iterations"].default_value = 4
    tree.links.new(position(tree), start.inputs["Value"])
    add = new(tree, "VectorMath", operation="ADD")
    tree.links.new(scaled(tree, start.outputs["Value"], 0.6).outputs[0], add.inputs[0])
    tree.links.new(start.outputs["Iteration"], add.inputs[1])
    tree.links.new(add.outputs[0], end.inputs["Value"])
    shown(stage, tree, end.outputs["Value"])


def test_a_closure_evaluated_twice(stage, tree):
    start, end = new(tree, "NodeClosureInput"), new(tree, "NodeClosureOutput")
    start.pair_with_output(end)
    end.input_items.new("VECTOR", "In")
    end.output_items.new("VECTOR", "Out")
    sine = new(tree, "VectorMath", operation="SINE")
    tree.links.new(start.outputs["In"], sine.inputs[0])
    tree.links.new(sine.outputs[0], end.inputs["Out"])
    source = position(tree)
    for _ in range(2):
        call = new(tree, "NodeEvaluateClosure")
        call.input_items.new("VECTOR", "In")
        call.output_items.new("VECTOR", "Out")
        tree.links.new(end.outputs["Closure"], call.inputs["Closure"])
        tree.links.new(source, call.inputs["In"])
        source = call.outputs["Out"]
    shown(stage, tree, source)


def test_bundles(stage, tree):
    pack, unpack = new(tree, "NodeCombineBundle"), new(tree, "NodeSeparateBundle")
    for node in (pack, unpack):
        node.bundle_items.new("VECTOR", "Place")
        node.bundle_items.new("FLOAT", "Factor")
    tree.links.new(position(tree), pack.inputs["Place"])
    pack.inputs["Factor"].default_value = 0.3
    tree.links.new(pack.outputs["Bundle"], unpack.inputs["Bundle"])
    scale = scaled(tree, unpack.outputs["Place"], 1.0)
    tree.links.new(unpack.outputs["Factor"], scale.inputs["Scale"])
    shown(stage, tree, scale.outputs[0])


def test_a_menu_switch(stage, tree):
    switch = new(tree, "GeometryNodeMenuSwitch", data_type="VECTOR")
    switch.enum_items.new("Third")
    tree.links.new(position(tree), switch.inputs["Third"])
    switch.inputs["Menu"].default_value = "Third"
    shown(stage, tree, switch.outputs["Output"])


@pytest.mark.parametrize(
    ("kind", "setting", "value"),
    [
        ("FunctionNodeInputBool", "boolean", True),
        ("FunctionNodeInputInt", "integer", 3),
        ("FunctionNodeInputVector", "vector", (0.3, 0.5, 0.7)),
    ],
)
def test_constants_of_other_trees(kind, setting, value, stage, tree):
    add = new(tree, "VectorMath", operation="ADD")
    tree.links.new(position(tree), add.inputs[0])
    tree.links.new(new(tree, kind, **{setting: value}).outputs[0], add.inputs[1])
    shown(stage, tree, add.outputs[0])


@pytest.mark.parametrize("output", ["Seconds", "Frame"])
def test_scene_time(output, stage, tree):
    scene = stage[0]
    scene.frame_set(7)
    add = new(tree, "VectorMath", operation="ADD")
    tree.links.new(position(tree), add.inputs[0])
    tree.links.new(new(tree, "GeometryNodeInputSceneTime").outputs[output], add.inputs[1])
    shown(stage, tree, add.outputs[0])
    scene.frame_set(1)


def test_drivers_mutes_and_reroutes(stage, tree):
    """A driven factor, a muted node on the way, a muted link, a reroute: Blender's evaluated values count."""
    scale = scaled(tree, position(tree), 1.0)
    scale.inputs["Scale"].driver_add("default_value").driver.expression = "0.25 + 0.5"
    muted = new(tree, "VectorMath", operation="NORMALIZE", mute=True)
    tree.links.new(scale.outputs[0], muted.inputs[0])
    reroute = new(tree, "NodeReroute")
    tree.links.new(muted.outputs[0], reroute.inputs[0])
    add = new(tree, "VectorMath", operation="ADD")
    tree.links.new(reroute.outputs[0], add.inputs[0])
    add.inputs[1].default_value = (0.1, 0.2, 0.3)
    tree.links.new(position(tree), add.inputs[1]).is_muted = True
    shown(stage, tree, add.outputs[0])


def test_groups_in_groups(stage, tree):
    """Two levels, the inner one twice with its own inputs, a float socket on the way of a vector."""
    inner = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    outer = bpy.data.node_groups.new("Outer", "ShaderNodeTree")
    for group in (inner, outer):
        group.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketVector")
        group.interface.new_socket("By", in_out="INPUT", socket_type="NodeSocketFloat")
        group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketVector")
    start, end = new(inner, "NodeGroupInput"), new(inner, "NodeGroupOutput")
    scale = scaled(inner, start.outputs["In"], 1.0)
    inner.links.new(start.outputs["By"], scale.inputs["Scale"])
    inner.links.new(scale.outputs[0], end.inputs["Out"])
    start, end = new(outer, "NodeGroupInput"), new(outer, "NodeGroupOutput")
    source = start.outputs["In"]
    for by in (0.5, 1.5):
        node = new(outer, "Group", node_tree=inner)
        outer.links.new(source, node.inputs["In"])
        node.inputs["By"].default_value = by
        source = node.outputs["Out"]
    outer.links.new(start.outputs["By"], node.inputs["By"])
    outer.links.new(source, end.inputs["Out"])
    top = new(tree, "Group", node_tree=outer)
    tree.links.new(position(tree), top.inputs["In"])
    tree.links.new(position(tree), top.inputs["By"])
    shown(stage, tree, top.outputs["Out"])


def hiding_group(kind, socket, **sockets):
    """A group around a node, its input "In" (hidden value, unlinked later) linked to a socket of the node."""
    group = bpy.data.node_groups.new("Hiding", "ShaderNodeTree")
    group.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketVector").hide_value = True
    for name, socket_type in sockets.items():
        group.interface.new_socket(name, in_out="INPUT", socket_type=f"NodeSocket{socket_type}")
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
    start, inside = new(group, "NodeGroupInput"), new(group, kind)
    group.links.new(start.outputs["In"], inside.inputs[socket])
    for name in sockets:
        if name in inside.inputs:
            group.links.new(start.outputs[name], inside.inputs[name])
    group.links.new(inside.outputs[0], new(group, "NodeGroupOutput").inputs["Out"])
    return group


@pytest.mark.parametrize("varies", [False, True])
@pytest.mark.parametrize("kind", ["TexNoise", "TexVoronoi", "TexChecker"])
def test_a_hidden_value_is_the_texture_coordinate_only_where_the_node_is_folded(varies, kind, stage, tree):
    """All inputs constant: flat at (0, 0, 0). A Scale that varies: Generated coordinates."""
    node = new(tree, "Group", node_tree=hiding_group(kind, "Vector", Scale="Float"))
    node.inputs["Scale"].default_value = 3.0
    if varies:
        tree.links.new(new(tree, "ObjectInfo").outputs["Object Index"], node.inputs["Scale"])
    shown(stage, tree, node.outputs["Out"])


def test_a_hidden_value_reaches_a_socket_that_shows_its_own(stage, tree):
    node = new(tree, "Group", node_tree=hiding_group("VectorMath", 0))
    node.inputs["In"].default_value = (0.2, 0.4, 0.6)
    shown(stage, tree, node.outputs["Out"])


def test_a_shader_in_the_place_of_a_value_counts_for_nothing(stage, tree):
    """Behind a group's colour input the socket inside keeps its own value, not the group node's."""
    group = hiding_group("VectorMath", 1, Tint="Color")
    inside = next(n for n in group.nodes if n.bl_idname == "ShaderNodeVectorMath")
    start = next(n for n in group.nodes if n.bl_idname == "NodeGroupInput")
    group.links.new(start.outputs["Tint"], inside.inputs[0])
    inside.inputs[0].default_value = (0.7, 0.1, 0.3)
    node = new(tree, "Group", node_tree=group)
    node.inputs["Tint"].default_value = (0.2, 0.5, 0.9, 1.0)
    tree.links.new(new(tree, "BsdfDiffuse").outputs[0], node.inputs["Tint"])
    shown(stage, tree, node.outputs["Out"])
