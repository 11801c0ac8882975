"""Material slots, and the mesh layers that the materials' graphs read."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import Tree, source  # noqa: E402
from support.bpy_scenes import add, cube, empty_scene, export, export_in_render, mesh  # noqa: E402

from pt_engine.scene.attributes import color_layer  # noqa: E402
from pt_engine.scene.geometry import flatten  # noqa: E402


@pytest.fixture(autouse=True)
def scene():
    return empty_scene()


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
    # Cycles' default surface
    kind, color = ("BsdfPrincipled", "Base Color") if bpy.app.version >= (5, 0) else ("BsdfDiffuse", "Color")
    assert source(snapshot.materials[0], kind, color) == (0.8, 0.8, 0.8, 1.0)


def test_view_layer_overrides_every_material():
    data = cube()
    data.materials.append(bpy.data.materials.new("Own"))
    add(data)
    bpy.context.view_layer.material_override = bpy.data.materials.new("Clay")
    snapshot = export()
    assert snapshot.materials[snapshot.instances.materials[0, 0]].name == "Clay"


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


def test_corner_colours_of_a_single_quad_meet_their_corners():
    """It has as many corners as vertices, in another order."""
    tree = Tree()
    tree.link(tree.node("VertexColor", layer_name="Paint"), 0, tree.bsdf, "Base Color")
    data = mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [(0, 1, 3, 2)])
    paint = data.color_attributes.new("Paint", "FLOAT_COLOR", "CORNER")
    for item, loop in zip(paint.data, data.loops, strict=True):
        item.color = (*data.vertices[loop.vertex_index].co, 1.0)
    snapshot, _ = tree.export(data)
    layer = color_layer(snapshot, flatten(snapshot), "Paint")
    (exported,) = snapshot.meshes
    at_corner = layer.values[:3, layer.index[:, :2]].T
    np.testing.assert_array_equal(at_corner, exported.vertices[exported.triangles])


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
