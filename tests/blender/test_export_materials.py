"""Node trees become flat graphs that say the same, with the layers that they need."""

import re

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, cube, empty_scene, export, export_in_render  # noqa: E402

from pt_engine.scene.snapshot import Link  # noqa: E402

BLENDER_5 = bpy.app.version >= (5, 0, 0)


@pytest.fixture(autouse=True)
def scene():
    return empty_scene()


def with_nodes(owner):
    """The empty node tree of a material, world or light."""
    if not BLENDER_5:
        owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree


class Tree:
    """A material's tree with a Principled BSDF, and shorthands to build on it."""

    def __init__(self, tree=None):
        self.material = bpy.data.materials.new("Test") if tree is None else None
        self.tree = with_nodes(self.material) if tree is None else tree
        if tree is None:
            self.output = self.node("OutputMaterial")
            self.bsdf = self.node("BsdfPrincipled")
            self.link(self.bsdf, 0, self.output, 0)

    def node(self, kind, **settings):
        node = self.tree.nodes.new(kind if kind.startswith(("Node", "Geometry")) else f"ShaderNode{kind}")
        for key, value in settings.items():
            setattr(node, key, value)
        return node

    def link(self, source, output, target, socket):
        return self.tree.links.new(source.outputs[output], target.inputs[socket])

    def group(self, *sockets):
        """A group with (name, direction, type) sockets: its inner Tree and a node of it here."""
        tree = bpy.data.node_groups.new("Group", "ShaderNodeTree")
        for name, direction, kind in sockets:
            tree.interface.new_socket(name, in_out=direction, socket_type=f"NodeSocket{kind}")
        inner = Tree(tree)
        inner.start, inner.end = inner.node("NodeGroupInput"), inner.node("NodeGroupOutput")
        return inner, self.node("Group", node_tree=tree)

    def export(self, mesh=None):
        mesh = mesh or cube()
        mesh.materials.clear()
        mesh.materials.append(self.material)
        add(mesh)
        snapshot = export()
        return snapshot, snapshot.materials[snapshot.instances.materials[-1, 0]]


def shape_of(graph, link=None):
    """A graph without its names and numbers, as a nested tuple: equal for graphs that mean the same."""
    if link is None:
        return {socket: shape_of(graph, start) for socket, start in graph.outputs.items()}
    node = graph.nodes[link.node]
    inputs = {
        key: shape_of(graph, value) if isinstance(value, Link) else value
        for key, value in node.inputs.items()
    }
    return node.kind, link.socket, inputs, node.props


def source(graph, kind, socket):
    """The kind of the node that feeds a socket of the only node of `kind`, or the socket's value."""
    (node,) = [node for node in graph.nodes if node.kind == kind]
    value = node.inputs[socket]
    return graph.nodes[value.node].kind if isinstance(value, Link) else value


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
    assert source(graph, "TexNoise", "Vector") is None


def test_a_colour_through_a_float_socket_turns_grey():
    tree = Tree()
    inner, node = tree.group(("X", "INPUT", "Float"), ("Y", "OUTPUT", "Color"))
    inner.link(inner.start, 0, inner.end, 0)
    tree.link(tree.node("TexNoise"), "Color", node, 0)
    tree.link(node, 0, tree.bsdf, "Base Color")
    _, graph = tree.export()
    assert source(graph, "BsdfPrincipled", "Base Color") == "RGBToBW"
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


def test_slots_linked_to_the_object_win():
    data = cube()
    for name in ("Red", "Blue"):
        data.materials.append(bpy.data.materials.new(name))
    add(data, "Plain")
    slot = add(data, "Special").material_slots[1]
    slot.link, slot.material = "OBJECT", bpy.data.materials.new("Gold")
    snapshot = export()
    names = {
        name: [snapshot.materials[number].name for number in row]
        for name, row in zip(snapshot.instances.names, snapshot.instances.materials, strict=True)
    }
    assert names == {"Plain": ["Red", "Blue"], "Special": ["Red", "Gold"]}
    assert len(snapshot.meshes) == 1


def test_faces_keep_their_slots_and_empty_slots_are_the_stand_in():
    data = cube()
    data.materials.append(None)
    data.materials.append(bpy.data.materials.new("Second"))
    data.polygons[2].material_index = 1
    add(data)
    snapshot = export()
    assert np.bincount(snapshot.meshes[0].material_slot).tolist() == [10, 2]
    assert snapshot.instances.materials[0].tolist() == [0, 1]
    assert source(snapshot.materials[0], "BsdfDiffuse", "Color") == (0.8, 0.8, 0.8, 1.0)


@pytest.mark.skipif(BLENDER_5, reason="materials always have nodes in Blender 5")
def test_material_without_nodes_is_diffuse():
    material = bpy.data.materials.new("Plain")
    material.use_nodes, material.diffuse_color = False, (0.5, 0.25, 0.125, 1)
    data = cube()
    data.materials.append(material)
    add(data)
    assert source(export().materials[1], "BsdfDiffuse", "Color") == (0.5, 0.25, 0.125, 1)


def layered_cube():
    data = cube()
    for name in ("First", "Second"):
        data.uv_layers.new(name=name)
    data.uv_layers["Second"].active_render = True
    uv = np.random.default_rng(2).random(48, np.float32)
    data.attributes["Second"].data.foreach_set("vector", uv)
    paint = data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    colors = np.random.default_rng(3).random((8, 4), np.float32)
    paint.data.foreach_set("color", colors.ravel())
    return data, uv.reshape(24, 2), colors


def test_only_layers_that_a_graph_reads_are_exported():
    (data,) = Tree().export(layered_cube()[0])[0].meshes
    assert (data.uvs, data.colors, data.corner_index) == ({}, {}, None)


def test_active_uv_map_of_an_image_texture():
    tree = Tree()
    tree.link(tree.node("TexImage"), 0, tree.bsdf, "Base Color")
    data, uv, _ = layered_cube()
    (exported,) = tree.export(data)[0].meshes
    assert list(exported.uvs) == [exported.active_uv] == ["Second"]
    np.testing.assert_array_equal(exported.uvs["Second"], uv)
    corner = data.loops[int(exported.corner_index[5, 2])]
    assert corner.vertex_index == exported.triangles[5, 2]


def test_named_layers_come_by_name():
    tree = Tree()
    tree.link(tree.node("UVMap", uv_map="First"), 0, tree.bsdf, "Normal")
    tree.link(tree.node("VertexColor", layer_name="Paint"), 0, tree.bsdf, "Base Color")
    data, _, colors = layered_cube()
    (exported,) = tree.export(data)[0].meshes
    assert (list(exported.uvs), list(exported.colors)) == (["First"], ["Paint"])
    at_corner = exported.colors["Paint"][exported.corner_index]
    np.testing.assert_array_equal(at_corner, colors[exported.triangles])


def test_number_attributes_of_faces_are_colours_too():
    tree = Tree()
    tree.link(tree.node("Attribute", attribute_name="Height"), "Fac", tree.bsdf, "Roughness")
    data = cube()
    data.attributes.new("Height", "FLOAT", "FACE").data.foreach_set("value", np.arange(6, dtype=np.float32))
    (exported,) = tree.export(data)[0].meshes
    at_corner = exported.colors["Height"][exported.corner_index]
    expected = np.repeat(np.arange(6), 2)[:, None, None] * np.array([1, 1, 1, 0]) + np.array([0, 0, 0, 1])
    np.testing.assert_array_equal(at_corner, np.broadcast_to(expected, (12, 3, 4)))


def test_generated_coordinates_are_those_before_the_modifiers():
    tree = Tree()
    tree.link(tree.node("TexNoise"), 0, tree.bsdf, "Roughness")
    data = cube(size=4.0)
    data.materials.append(tree.material)
    modifier = add(data).modifiers.new("Cast", "CAST")
    modifier.factor = 1.0
    (exported,) = export_in_render().meshes
    np.testing.assert_allclose(np.abs(exported.orco), 2.0)
    assert np.abs(exported.vertices).max() < 2.0 or np.abs(exported.vertices).min() > 2.0
    np.testing.assert_allclose(exported.texture_space, [[0, 0, 0], [2, 2, 2]], atol=1e-6)


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


def test_view_layer_overrides_every_material():
    data = cube()
    data.materials.append(bpy.data.materials.new("Own"))
    add(data)
    bpy.context.view_layer.material_override = bpy.data.materials.new("Clay")
    snapshot = export()
    assert snapshot.materials[snapshot.instances.materials[0, 0]].name == "Clay"
