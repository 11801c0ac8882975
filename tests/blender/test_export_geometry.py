"""What is exported is the geometry that Blender evaluates, once, and where it stands."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from mathutils import Matrix  # noqa: E402
from support.bpy_scenes import (  # noqa: E402
    add,
    cube,
    empty_scene,
    export,
    export_in_render,
    geometric_normals,
    mesh,
    rows_of,
    world_triangles,
)

from pt_engine.scene.snapshot import Visibility  # noqa: E402


@pytest.fixture(autouse=True)
def scene():
    return empty_scene()


def area(triangles):
    a, b, c = np.moveaxis(triangles, 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def signed_volume(triangles):
    a, b, c = np.moveaxis(triangles, 1, 0)
    return (a * np.cross(b, c)).sum() / 6


def test_cube_is_twelve_flat_triangles_facing_out():
    add(cube(), location=(1, 2, 3))
    snapshot = export()
    (data,) = snapshot.meshes
    assert (len(data.vertices), len(data.triangles), data.normals) == (8, 12, None)
    triangles = world_triangles(snapshot, 0)
    assert signed_volume(triangles - (1, 2, 3)) == pytest.approx(8)
    np.testing.assert_allclose(triangles.mean(axis=(0, 1)), (1, 2, 3), atol=1e-6)


def test_smooth_mesh_has_a_unit_normal_per_vertex():
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12)
    bpy.ops.object.shade_smooth()
    (data,) = export().meshes
    assert data.normals.shape == data.vertices.shape
    assert data.normal_index is data.triangles
    np.testing.assert_allclose(np.linalg.norm(data.normals, axis=1), 1, atol=1e-5)
    assert (data.normals * data.vertices).sum(axis=1).min() > 0.99  # a unit sphere's normal is its position


def test_mixed_mesh_has_normals_per_corner():
    data = cube()
    data.polygons.foreach_set("use_smooth", [True, False, True, False, True, False])
    add(data)
    (exported,) = export().meshes
    assert exported.normals.shape == (24, 3)
    np.testing.assert_allclose(np.linalg.norm(exported.normals, axis=1), 1, atol=1e-5)
    corner = exported.normals[exported.normal_index]
    assert ((corner * geometric_normals(exported)[:, None]).sum(axis=-1) > 0.5).all()


def test_modifiers_are_applied():
    owner = add(cube())
    array = owner.modifiers.new("Array", "ARRAY")
    array.count, array.use_relative_offset, array.use_constant_offset = 3, False, True
    array.constant_offset_displace = (5, 0, 0)
    snapshot = export()
    assert len(snapshot.meshes[0].triangles) == 36
    assert world_triangles(snapshot, 0)[..., 0].max() == pytest.approx(11)


def test_final_render_takes_the_render_levels():
    modifier = add(cube()).modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 2
    assert len(export().meshes[0].triangles) == 12
    assert len(export_in_render().meshes[0].triangles) == 12 * 16


def test_linked_duplicates_share_their_mesh():
    data = cube()
    for x in range(5):
        add(data, f"Copy {x}", location=(3 * x, 0, 0))
    snapshot = export()
    assert (len(snapshot.meshes), len(snapshot.instances.mesh)) == (1, 5)
    assert sorted(snapshot.instances.matrix[:, 0, 3]) == [0, 3, 6, 9, 12]
    assert len(set(snapshot.instances.random)) == 5


def test_negative_and_uneven_scale_stay_in_the_matrix():
    owner = add(cube())
    owner.matrix_world = Matrix.Translation((1, 0, 0)) @ Matrix.Diagonal((-1, 2, 3, 1))
    snapshot = export()
    np.testing.assert_allclose(snapshot.instances.matrix[0][:3, :3], np.diag([-1, 2, 3]), atol=1e-6)
    assert signed_volume(world_triangles(snapshot, 0) - (1, 0, 0)) == pytest.approx(-48)


def test_sheared_child_is_where_its_parent_takes_it():
    parent = add(None, "Parent")
    child = add(cube(), "Child")
    parent.rotation_euler, parent.scale = (0, 0, 0.5), (2, 1, 1)
    child.parent, child.rotation_euler = parent, (0, 0, 0.7)
    snapshot = export()
    np.testing.assert_allclose(snapshot.instances.matrix[0], np.array(child.matrix_world), atol=1e-6)


def test_collection_instances_share_one_mesh():
    source = bpy.data.collections.new("Source")
    owner = bpy.data.objects.new("Part", cube())
    owner.location = (0, 0, 1)
    source.objects.link(owner)
    for x in range(4):
        empty = add(None, f"Place {x}", location=(4 * x, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", source
    snapshot = export()
    assert (len(snapshot.meshes), len(snapshot.instances.mesh)) == (1, 4)
    np.testing.assert_allclose(sorted(snapshot.instances.matrix[:, 0, 3]), [0, 4, 8, 12])
    np.testing.assert_allclose(snapshot.instances.matrix[:, 2, 3], 1)


def test_vertex_instances_hide_their_instancer():
    plane = add(mesh([(0, 0, 0), (4, 0, 0), (0, 4, 0)], [(0, 1, 2)]), "Plane")
    add(cube(), "Child", parent=plane)
    plane.instance_type, plane.show_instancer_for_render = "VERTS", False
    snapshot = export_in_render()
    assert rows_of(snapshot, "Plane") == []
    assert len(snapshot.meshes) == 1
    assert len(rows_of(snapshot, "Child")) == 3


def scatter_tree(source):
    """Geometry nodes: one instance of `source` on each vertex, with a material of its own."""
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    make = {kind: tree.nodes.new(kind) for kind in (
        "NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints", "GeometryNodeMeshCube",
        "GeometryNodeSetMaterial",
    )}  # fmt: skip
    make["GeometryNodeSetMaterial"].inputs["Material"].default_value = source
    place = make["GeometryNodeInstanceOnPoints"]
    tree.links.new(make["NodeGroupInput"].outputs[0], place.inputs["Points"])
    tree.links.new(make["GeometryNodeMeshCube"].outputs["Mesh"], make["GeometryNodeSetMaterial"].inputs[0])
    tree.links.new(make["GeometryNodeSetMaterial"].outputs[0], place.inputs["Instance"])
    tree.links.new(place.outputs[0], make["NodeGroupOutput"].inputs[0])
    return tree


def test_geometry_nodes_instances_share_one_mesh_and_bring_their_material():
    material = bpy.data.materials.new("Scattered")
    owner = add(mesh([(float(x), 0, 0) for x in range(50)], []), "Points")
    owner.modifiers.new("Nodes", "NODES").node_group = scatter_tree(material)
    snapshot = export()
    assert (len(snapshot.meshes), len(snapshot.instances.mesh)) == (1, 50)
    assert len(snapshot.meshes[0].triangles) == 12
    np.testing.assert_allclose(sorted(snapshot.instances.matrix[:, 0, 3]), range(50))
    (slot,) = set(snapshot.meshes[0].material_slot)
    names = {snapshot.materials[number].name for number in snapshot.instances.materials[:, slot]}
    assert names == {"Scattered"}
    assert len(set(snapshot.instances.random)) == 50


def test_an_empty_slot_of_the_object_hides_the_meshs_material():
    data = cube()
    for name in ("First", "Second"):
        data.materials.append(bpy.data.materials.new(name))
    owner = add(data)
    owner.material_slots[1].link = "OBJECT"
    snapshot = export()
    names = [snapshot.materials[number].name for number in snapshot.instances.materials[0, :2]]
    assert names[0] == "First" != names[1] != "Second"


@pytest.mark.parametrize("kind", ["curve", "text", "metaball", "surface"])
def test_geometry_of_other_kinds_comes_once(kind):
    if kind == "curve":
        bpy.ops.curve.primitive_bezier_circle_add()
        bpy.context.object.data.bevel_depth = 0.1
    elif kind == "text":
        bpy.ops.object.text_add()
        bpy.context.object.data.extrude = 0.1
    elif kind == "metaball":
        bpy.ops.object.metaball_add()
    else:
        bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    owner = bpy.context.object
    snapshot = export()
    evaluated = owner.evaluated_get(bpy.context.evaluated_depsgraph_get())
    reference = evaluated.to_mesh()
    reference.calc_loop_triangles()
    assert len(snapshot.instances.mesh) == 1
    assert len(snapshot.meshes[0].triangles) == len(reference.loop_triangles) > 0
    evaluated.to_mesh_clear()


def test_particle_instances_are_placed():
    ball = add(cube(size=0.1), "Ball", location=(0, 0, 50))
    bpy.ops.mesh.primitive_plane_add(size=10)
    emitter = bpy.context.object
    emitter.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = emitter.particle_systems[0].settings
    settings.type, settings.count = "HAIR", 30
    settings.render_type, settings.instance_object = "OBJECT", ball
    snapshot = export()
    assert len(snapshot.meshes) == 2
    assert len(rows_of(snapshot, "Ball")) == 31


def test_hair_strands_are_curves_of_their_own():
    """Each particle a strand of 2^steps + 1 points; the emitter's mesh stays, unless it is not shown."""
    bpy.ops.mesh.primitive_plane_add()
    plane = bpy.context.object
    plane.modifiers.new("Particles", "PARTICLE_SYSTEM")
    settings = plane.particle_systems[0].settings
    settings.type, settings.count, settings.display_step = "HAIR", 7, 2
    snapshot = export()
    assert snapshot.unsupported == ()
    (curves,) = snapshot.curves
    np.testing.assert_array_equal(curves.first, 5 * np.arange(8))
    assert snapshot.instances.mesh.tolist() == [0, 1]
    plane.show_instancer_for_viewport = plane.show_instancer_for_render = False
    assert export().instances.mesh.tolist() == [0]
    bpy.context.view_layer.use_strand = False
    assert export().curves == ()


def test_hidden_and_excluded_objects_are_absent(scene):
    add(cube(), "Seen")
    add(cube(), "Hidden", hide_render=True)
    collection = bpy.data.collections.new("Excluded")
    scene.collection.children.link(collection)
    collection.objects.link(bpy.data.objects.new("Left out", cube()))
    bpy.context.view_layer.layer_collection.children["Excluded"].exclude = True
    assert export_in_render().instances.names == ("Seen",)


def test_visibility_flags():
    owner = add(cube())
    owner.visible_camera = owner.visible_shadow = False
    expected = Visibility.ALL & ~Visibility.CAMERA & ~Visibility.SHADOW
    assert export().instances.visibility.tolist() == [expected]


def test_indirect_only_and_holdout_collections(scene):
    for name in ("Indirect", "Cut"):
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        collection.objects.link(bpy.data.objects.new(name, cube()))
    layers = bpy.context.view_layer.layer_collection.children
    layers["Indirect"].indirect_only = layers["Cut"].holdout = True
    snapshot = export()
    (row,) = rows_of(snapshot, "Indirect")
    assert snapshot.instances.visibility[row] == Visibility.ALL & ~Visibility.CAMERA
    assert [snapshot.instances.visibility[k] & Visibility.HOLDOUT for k in rows_of(snapshot, "Cut")] == [64]


def test_object_colour_and_index():
    add(cube(), color=(0.1, 0.2, 0.3, 0.4), pass_index=7)
    snapshot = export()
    np.testing.assert_allclose(snapshot.instances.color, [[0.1, 0.2, 0.3, 0.4]], rtol=1e-6)
    assert snapshot.instances.pass_index.tolist() == [7]


def test_non_finite_vertices_lose_their_triangles():
    data = mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (float("nan"), 0, 1)], [(0, 1, 2), (0, 1, 3)])
    add(data)
    (exported,) = export().meshes
    assert exported.triangles.tolist() == [[0, 1, 2]]
    assert np.isfinite(exported.vertices).all()


def test_meshes_without_faces_are_left_out():
    add(mesh([(0, 0, 0), (1, 0, 0)], []))
    snapshot = export()
    assert snapshot.meshes == ()
    assert snapshot.instances.matrix.shape == (0, 4, 4)


def test_unknown_kinds_are_named(scene):
    add(bpy.data.volumes.new("Fog"), "Fog")
    what = {(where, what) for where, what, _ in export().unsupported}
    assert ("Object Fog", "volume object") in what
