"""Node trees become flat graphs that say the same."""

import re

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import BLENDER_5, Tree, shape_of, source, with_nodes  # noqa: E402
from support.bpy_scenes import add, cube, empty_scene, export  # noqa: E402

from pt_engine.blender.export.images import ImageTable  # noqa: E402
from pt_engine.blender.export.node_tree import flatten  # noqa: E402
from pt_engine.scene.snapshot import Link  # noqa: E402


@pytest.fixture(autouse=True)
def scene():
    return empty_scene()


def test_values_and_settings_of_a_node():
    tree = Tree()
    noise = tree.node("TexNoise", noise_dimensions="4D")
    noise.inputs["Scale"].default_value = 7.0
    tree.link(noise, "Color", tree.bsdf, "Base Color")
    _, graph = tree.export()
    (node,) = [node for node in graph.nodes if node.kind == "TexNoise"]
    assert node.inputs["Scale"] == 7.0
    assert node.inputs["Vector"] is None  # hidden: default coordinates
    assert node.props["noise_dimensions"] == "4D"
    assert isinstance(node.props["normalize"], bool)
    assert "location" not in node.props
    assert graph.outputs["Surface"].socket == "BSDF"
    assert source(graph, "BsdfPrincipled", "Base Color") == "TexNoise"


def test_nested_groups_equal_the_hand_flattened_graph():
    flat = Tree()
    noise, math = flat.node("TexNoise"), flat.node("Math", operation="POWER")
    math.inputs[1].default_value = 3.0
    flat.link(noise, 0, math, 0)
    flat.link(math, 0, flat.bsdf, "Roughness")
    nested = Tree()
    outer, outer_node = nested.group(("A", "INPUT", "Float"), ("Out", "OUTPUT", "Float"))
    inner, inner_node = outer.group(("X", "INPUT", "Float"), ("Y", "OUTPUT", "Float"))
    power = inner.node("Math", operation="POWER")
    power.inputs[1].default_value = 3.0
    inner.link(inner.start, 0, power, 0)
    inner.link(power, 0, inner.end, 0)
    outer.link(outer.start, 0, inner_node, 0)
    outer.link(inner_node, 0, outer.end, 0)
    noise, reroute = nested.node("TexNoise"), nested.node("NodeReroute")
    nested.link(noise, 0, reroute, 0)
    nested.link(reroute, 0, outer_node, 0)
    nested.link(outer_node, 0, nested.bsdf, "Roughness")
    assert shape_of(nested.export()[1]) == shape_of(flat.export()[1])


def test_one_group_used_twice_keeps_its_two_inputs_apart():
    tree = Tree()
    inner, first = tree.group(("X", "INPUT", "Float"), ("Y", "OUTPUT", "Float"))
    math = inner.node("Math", operation="SINE")
    inner.link(inner.start, 0, math, 0)
    inner.link(math, 0, inner.end, 0)
    second = tree.node("Group", node_tree=inner.tree)
    first.inputs[0].default_value, second.inputs[0].default_value = 0.25, 0.75
    tree.link(first, 0, tree.bsdf, "Roughness")
    tree.link(second, 0, tree.bsdf, "Metallic")
    _, graph = tree.export()
    values = {node.name: node.inputs["Value"] for node in graph.nodes if node.kind == "Math"}
    assert values == {"Group/Math": 0.25, "Group.001/Math": 0.75}


def test_unlinked_group_input_hands_in_its_value_as_the_inner_type():
    tree = Tree()
    inner, node = tree.group(
        ("Tint", "INPUT", "Float"), ("Vector", "INPUT", "Vector"), ("Out", "OUTPUT", "Color")
    )
    inner.tree.interface.items_tree["Vector"].hide_value = True
    noise, mix = inner.node("TexNoise"), inner.node("MixRGB")
    inner.link(inner.start, "Vector", noise, "Vector")
    inner.link(inner.start, "Tint", mix, "Color1")
    inner.link(noise, "Color", mix, "Color2")
    inner.link(mix, 0, inner.end, 0)
    node.inputs["Tint"].default_value = 0.25
    tree.link(node, 0, tree.bsdf, "Base Color")
    _, graph = tree.export()
    kind = next(node.kind for node in graph.nodes if node.kind.startswith("Mix"))
    color = next(key for key in graph.nodes[-2].inputs if re.fullmatch("Color1|A_Color", key))
    assert source(graph, kind, color) == (0.25, 0.25, 0.25, 1.0)
    # Blender 5 folds a node whose inputs are all constants, a hidden one among them
    assert source(graph, "TexNoise", "Vector") == ((0.0, 0.0, 0.0) if BLENDER_5 else None)


def test_a_colour_through_a_float_socket_turns_grey_before_blender_5():
    tree = Tree()
    inner, node = tree.group(("X", "INPUT", "Float"), ("Y", "OUTPUT", "Color"))
    inner.link(inner.start, 0, inner.end, 0)
    tree.link(tree.node("TexNoise"), "Color", node, 0)
    tree.link(node, 0, tree.bsdf, "Base Color")
    _, graph = tree.export()
    assert source(graph, "BsdfPrincipled", "Base Color") == ("TexNoise" if BLENDER_5 else "RGBToBW")
    if not BLENDER_5:
        assert source(graph, "RGBToBW", "Color") == "TexNoise"


def test_a_colour_in_a_shader_socket_is_an_emission():
    tree = Tree()
    tree.link(tree.node("TexNoise"), "Color", tree.output, 0)
    _, graph = tree.export()
    assert source(graph, "Emission", "Color") == "TexNoise"
    assert source(graph, "Emission", "Strength") == 1.0


def test_muted_links_do_not_count():
    tree = Tree()
    tree.link(tree.node("TexNoise"), 0, tree.bsdf, "Roughness").is_muted = True
    tree.bsdf.inputs["Roughness"].default_value = 0.125
    _, graph = tree.export()
    assert source(graph, "BsdfPrincipled", "Roughness") == 0.125
    assert [node.kind for node in graph.nodes] == ["BsdfPrincipled"]


def test_a_muted_node_hands_on_its_first_input():
    tree = Tree()
    noise, math = tree.node("TexNoise"), tree.node("Math", mute=True)
    tree.link(noise, 0, math, 0)
    tree.link(math, 0, tree.bsdf, "Roughness")
    _, graph = tree.export()
    assert source(graph, "BsdfPrincipled", "Roughness") == "TexNoise"


def test_sockets_are_keyed_by_identifier():
    tree = Tree()
    mix = tree.node("Mix", data_type="RGBA")
    tree.link(tree.node("TexNoise"), "Color", mix, 7)
    tree.link(mix, 2, tree.bsdf, "Base Color")
    _, graph = tree.export()
    assert source(graph, "Mix", "B_Color") == "TexNoise"
    (node,) = [node for node in graph.nodes if node.kind == "Mix"]
    assert {"Factor_Float", "A_Float", "A_Color"} <= set(node.inputs)


def test_active_output_for_cycles_wins():
    tree = Tree()
    eevee = tree.node("OutputMaterial", target="EEVEE")
    tree.link(tree.node("Emission"), 0, eevee, 0)
    cycles = tree.node("OutputMaterial", target="CYCLES")
    tree.link(tree.node("BsdfDiffuse"), 0, cycles, 0)
    _, graph = tree.export()
    assert [node.kind for node in graph.nodes] == ["BsdfDiffuse"]


def test_an_output_inside_a_group_counts():
    tree = Tree()
    inner, _ = tree.group(("Out", "OUTPUT", "Float"))
    inner.link(inner.node("BsdfDiffuse"), 0, inner.node("OutputMaterial"), 0)
    tree.tree.nodes.remove(tree.output)
    _, graph = tree.export()
    assert [node.name for node in graph.nodes] == ["Group/Diffuse BSDF"]


@pytest.mark.skipif(not BLENDER_5, reason="Blender 4.5 has no inliner")
def test_flattening_agrees_with_blenders_inliner():
    """Groups in groups, reroutes, mutes: the same nodes reach the surface, linked the same way."""
    tree = Tree()
    outer, node = tree.group(("A", "INPUT", "Color"), ("B", "INPUT", "Float"), ("Out", "OUTPUT", "Color"))
    inner, inner_node = outer.group(("C", "INPUT", "Color"), ("D", "OUTPUT", "Color"))
    voronoi, reroute, muted = (
        inner.node("TexVoronoi"),
        inner.node("NodeReroute"),
        inner.node("Gamma", mute=True),
    )
    inner.link(inner.start, 0, voronoi, "Vector")
    inner.link(voronoi, "Color", muted, "Color")
    inner.link(muted, 0, reroute, 0)
    inner.link(reroute, 0, inner.end, 0)
    noise = outer.node("TexNoise")
    outer.link(outer.start, 0, inner_node, 0)
    outer.link(inner_node, 0, noise, "Vector")
    outer.link(outer.start, 1, noise, "Scale")
    outer.link(noise, "Color", outer.end, 0)
    tree.link(tree.node("NewGeometry"), "Position", node, 0)
    tree.link(tree.node("ObjectInfo"), "Random", node, 1)
    tree.link(node, 0, tree.bsdf, "Base Color")
    _, graph = tree.export()
    inlined = bpy.types.InlineShaderNodes.from_material(tree.material)
    assert shape_of(flatten(inlined.node_tree, "Inlined", ImageTable([]))) == shape_of(graph)


def test_every_node_comes_after_what_feeds_it():
    tree = Tree()
    previous = tree.node("TexNoise")
    for _ in range(300):
        node = tree.node("Math")
        tree.link(previous, 0, node, 0)
        tree.link(previous, 0, node, 1)
        previous = node
    tree.link(previous, 0, tree.bsdf, "Roughness")
    _, graph = tree.export()
    assert len(graph.nodes) == 302
    for number, node in enumerate(graph.nodes):
        assert all(value.node < number for value in node.inputs.values() if isinstance(value, Link))


def test_ramp_and_curves_are_plain_numbers():
    tree = Tree()
    ramp, curve = tree.node("ValToRGB"), tree.node("RGBCurve")
    ramp.color_ramp.elements[0].color = (1, 0, 0, 1)
    ramp.color_ramp.interpolation = "EASE"
    curve.mapping.curves[3].points[1].location = (1.0, 0.5)
    tree.link(ramp, 0, curve, "Color")
    tree.link(curve, 0, tree.bsdf, "Base Color")
    _, graph = tree.export()
    props = {node.kind: node.props for node in graph.nodes}
    assert props["ValToRGB"]["ramp"] == ("RGB", "EASE", ((0, 1, 0, 0, 1), (1, 1, 1, 1, 1)))
    tables = np.array(props["RGBCurve"]["curves"])
    assert tables.shape == (3, 257)
    np.testing.assert_allclose(tables, np.linspace([0] * 3, [0.5] * 3, 257).T, atol=1e-5)
    assert props["RGBCurve"]["curve_range"] == (0.0, 1.0)


def test_outputs_that_are_settings():
    tree = Tree()
    value, color = tree.node("Value"), tree.node("RGB")
    value.outputs[0].default_value, color.outputs[0].default_value = 0.5, (0.5, 0.25, 0, 1)
    tree.link(value, 0, tree.bsdf, "Roughness")
    tree.link(color, 0, tree.bsdf, "Base Color")
    _, graph = tree.export()
    assert {n.kind: n.props["value"] for n in graph.nodes if "value" in n.props} == {
        "Value": 0.5,
        "RGB": (0.5, 0.25, 0, 1),
    }


def test_drivers_have_their_say(scene):
    tree = Tree()
    driver = tree.bsdf.inputs["Roughness"].driver_add("default_value").driver
    driver.expression = "0.25 + 0.5"
    _, graph = tree.export()
    assert source(graph, "BsdfPrincipled", "Roughness") == 0.75


@pytest.mark.skipif(BLENDER_5, reason="materials always have nodes in Blender 5")
def test_material_without_nodes_is_diffuse():
    material = bpy.data.materials.new("Plain")
    material.use_nodes, material.diffuse_color = False, (0.5, 0.25, 0.125, 1)
    data = cube()
    data.materials.append(material)
    add(data)
    assert source(export().materials[1], "BsdfDiffuse", "Color") == (0.5, 0.25, 0.125, 1)


def test_materials_with_a_zone_go_through_blenders_inliner():
    if not hasattr(bpy.types, "InlineShaderNodes"):
        pytest.skip("Blender 5 has zones in shaders")
    tree = Tree()
    start, end = tree.node("GeometryNodeRepeatInput"), tree.node("GeometryNodeRepeatOutput")
    start.pair_with_output(end)
    end.repeat_items.new("FLOAT", "Value")
    start.inputs["Iterations"].default_value = 3
    math, noise = tree.node("Math"), tree.node("TexNoise")
    tree.link(noise, 0, start, "Value")
    tree.link(start, "Value", math, 0)
    tree.link(math, 0, end, "Value")
    tree.link(end, "Value", tree.bsdf, "Roughness")
    _, graph = tree.export()
    assert [node.kind for node in graph.nodes].count("Math") == 3
    assert graph.notes == ()


def test_background_of_a_world(scene):
    assert export().world is None
    scene.world = bpy.data.worlds.new("World")
    tree = with_nodes(scene.world)
    back, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    back.inputs["Strength"].default_value = 2.5
    tree.links.new(back.outputs[0], output.inputs[0])
    assert source(export().world, "Background", "Strength") == 2.5


@pytest.mark.skipif(BLENDER_5, reason="worlds always have nodes in Blender 5")
def test_world_without_nodes(scene):
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes, scene.world.color = False, (0.5, 0.25, 0.125)
    assert source(export().world, "Background", "Color") == (0.5, 0.25, 0.125, 1.0)
