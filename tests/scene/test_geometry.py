"""Placed triangles: planes and bounds, which side is out, what is dropped, how surfaces are numbered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import lanes_of, placed, rotation, shoot

from pt_engine.scene.geometry import BOUND, EMITTER, INSTANCE, NORMAL, PLANE, SKY, flatten
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Snapshot

UP = np.eye(4)
CAMERA = make.perspective((0, -5, 0), (0, 0, 0))
GREY = make.diffuse(0.5)


def one(mesh, matrix=UP, material=GREY) -> Snapshot:
    return make.scene([(mesh, matrix, material)], CAMERA)


def soup(count=2000, size=1.0, seed=1):
    """Separate triangles of random shape in a box."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-1, 1, (count, 1, 3)) + 0.1 * rng.normal(size=(count, 3, 3))
    return make.mesh(corners.reshape(-1, 3) * size, np.arange(3 * count))


@pytest.mark.parametrize(("size", "away"), [(1.0, 0.0), (1e-3, 0.0), (1e4, 0.0), (1.0, 100.0)])
def test_each_vertex_lies_within_the_bound_of_its_triangles_plane(size, away):
    """|n·v − plane| ≤ bound, which is what lets a ray leave by the bound and clear the triangle.

    n and the plane's offset are float32: |δn·v| + |δ plane| ≤ 2·2⁻²⁴ |n|·|v|, a third of γ(6) |n|·max|v|.
    """
    far = (make.quad(1e-3), make.translation(-away, -away, -away), GREY)
    near = (soup(size=size), make.translation(away, away, away), GREY)
    geometry = flatten(make.scene([near, far], CAMERA))
    corners = geometry.vertices[geometry.triangles].astype(np.float64)
    records = geometry.records[:-1].astype(np.float64)
    height = (corners * records[:, None, NORMAL]).sum(-1) - records[:, None, PLANE]
    assert (np.abs(height) <= records[:, None, BOUND]).all()
    reach = np.abs(corners).max(axis=(1, 2))
    # the bound stays one of rounding: 6 · 2⁻²⁴ √3 of the largest coordinate at most, and not nothing
    assert (records[:, BOUND] <= 6.3e-7 * reach).all()
    assert (records[:, BOUND] > 0).all()


def test_normals_are_unit_and_follow_the_corners_order():
    """n = (b − a) × (c − a) / |…|, computed in float64; float32 keeps 2⁻²⁴ of each component."""
    geometry = flatten(one(soup()))
    a, b, c = np.moveaxis(geometry.vertices[geometry.triangles].astype(np.float64), 1, 0)
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    np.testing.assert_allclose(geometry.records[:-1, NORMAL], n, atol=2.0**-24, rtol=2.0**-23)


def test_the_world_is_centred_on_the_bounding_box():
    """Every vertex lies within `radius` of `origin`, to float32's rounding of its coordinates."""
    matrix = placed(rotation() * 3, (1e6, -2e6, 5e5))
    snapshot = one(soup(), matrix)
    geometry = flatten(snapshot)
    world = snapshot.meshes[0].vertices.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    np.testing.assert_allclose(geometry.vertices + geometry.origin, world, atol=geometry.radius * 2.0**-23)
    assert np.linalg.norm(geometry.vertices, axis=1).max() <= geometry.radius * (1 + 1e-6)
    # corners of a rotated box: not tight, but never more than √3 of its half diagonal
    assert geometry.radius <= np.sqrt(3) * np.linalg.norm(world.max(0) - world.min(0)) / 2


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (1, -2, 1), (-1, -1, -0.5), (-1, -3, 1)])
def test_a_mirrored_instance_keeps_its_outside_out(scale):
    """Where the determinant is negative, Blender turns the normal back: n·(p − centre) > 0 on a ball."""
    matrix = placed(rotation() * scale, (3, 2, 1))
    scene = prepare(one(make.sphere(1.0, 12), matrix))
    records, geometry = scene.geometry.records[:-1], flatten(one(make.sphere(1.0, 12), matrix))
    middle = geometry.vertices[geometry.triangles].mean(axis=1)
    centre = matrix[:3, 3] - geometry.origin
    assert ((middle - centre) * records[:, NORMAL]).sum(-1).min() > 0
    outside = shoot(scene, matrix[:3, 3] + 9 * np.eye(3), -np.eye(3))
    inside = shoot(scene, np.tile(matrix[:3, 3], (3, 1)), np.eye(3))
    assert outside.si.back.max() == 0
    assert inside.si.back.min() == 1


def test_a_triangle_without_area_is_never_hit():
    """Corners in a line or in a point: normal 0, and no ray finds them, not even one along them."""
    v = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0.5, 0, 0), (0.5, 0, 0), (5, 5, 5), (6, 5, 5), (5, 6, 5)]
    scene = prepare(one(make.mesh(v, [(0, 1, 2), (3, 4, 3), (5, 6, 7)])))
    assert (scene.geometry.records[:2, NORMAL] == 0).all()
    assert scene.geometry.dropped == 0  # harmless, so not worth a word in the report
    o = [(0.5, 0, 1), (-1, 0, 0), (0.5, -1, 0), (5.2, 5.2, 9)]
    d = [(0, 0, -1), (1, 0, 0), (0, 1, 0), (0, 0, -1)]
    assert shoot(scene, o, d).found.hits.prim.tolist() == [-1, -1, -1, 2]


@pytest.mark.parametrize("bad", [np.nan, pytest.param(np.inf, id="inf"), pytest.param(-np.inf, id="-inf")])
def test_triangles_with_a_vertex_that_is_not_finite_are_dropped_and_counted(bad):
    """Two of three use the bad vertex; the third is as it was, and so are origin and radius."""
    v = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (bad, 0, 0)]
    t = [(0, 1, 2), (0, 1, 3), (3, 1, 2)]
    broken, whole = one(make.mesh(v, t)), one(make.mesh(v[:3], t[:1]))
    scene, expected = prepare(broken), prepare(whole)
    assert scene.geometry.dropped == 2
    assert scene.geometry.radius == expected.geometry.radius
    np.testing.assert_array_equal(scene.geometry.origin, expected.geometry.origin)
    np.testing.assert_array_equal(scene.geometry.records[0], expected.geometry.records[0])
    shot = shoot(scene, [(0.2, 0.2, 1), (0, 0, 1), (0.9, 0.9, 1)], [(0, 0, -1)] * 3)
    assert set(shot.found.hits.prim.tolist()) <= {0, -1}
    assert any("2 triangles" in c.effect for c in scene.coverage)


@pytest.mark.parametrize("what", ["nan", "inf", "overflow"])
def test_an_instance_placed_nowhere_is_dropped_and_the_others_stand(what):
    """A matrix with NaN or ∞, or one beyond float32's range."""
    matrix = np.eye(4)
    matrix[0, 3] = {"nan": np.nan, "inf": np.inf, "overflow": 1.0}[what]
    if what == "overflow":
        matrix[:3, :3] *= 1e39
    scene = prepare(make.scene([(make.quad(), matrix, GREY), (make.quad(), UP, GREY)], CAMERA))
    assert scene.geometry.dropped == 2
    assert shoot(scene, [(0.1, 0.2, 1)], [(0, 0, -1)]).found.hits.prim.tolist() in ([2], [3])


def test_surfaces_are_numbered_by_material_and_smoothness():
    """A surface is a pair (material, smooth) that occurs on some triangle; 0 is the sky."""
    flat, curved = make.box(), make.sphere(1, 6)
    a, b = make.diffuse(0.1, "a"), make.diffuse(0.2, "b")
    objects = [(flat, UP, a), (curved, UP, b), (flat, UP, b), (curved, UP, b), (flat, UP, a)]
    geometry = flatten(make.scene(objects, CAMERA))
    pairs = list(zip(geometry.surface_material.tolist(), geometry.surface_smooth.tolist(), strict=True))
    assert pairs[SKY] == (-1, False)
    assert sorted(pairs[1:]) == [(1, False), (2, False), (2, True)]
    for k, (mesh, _, material) in enumerate(objects):
        span = slice(geometry.first_triangle[k], geometry.first_triangle[k + 1])
        expected = pairs.index((1 if material is a else 2, mesh is curved))
        assert (geometry.surface[span] == expected).all()
    assert geometry.surface.dtype == np.uint8
    assert geometry.surface[-1] == SKY


def test_slot_numbers_past_the_end_use_the_last_material():
    """As in Blender; and slots that no triangle uses make no surface."""
    mesh = replace(make.box(), material_slot=np.array([0, 1, 7, -1] * 3, np.int32))
    snapshot = one(mesh)
    more = (make.diffuse(0.1, "b"), make.diffuse(0.2, "c"))
    materials = np.array([[1, 2, 3]], np.int32)
    snapshot = replace(
        snapshot,
        materials=snapshot.materials + more,
        instances=replace(snapshot.instances, materials=materials),
    )
    geometry = flatten(snapshot)
    used = geometry.surface_material[geometry.surface[:-1]]
    assert used.tolist() == [1, 2, 3, 1] * 3


def test_a_slot_that_no_triangle_uses_is_no_surface():
    snapshot = one(make.quad())
    snapshot = replace(
        snapshot,
        materials=(*snapshot.materials, make.shader("BsdfTransparent", Color=make.WHITE)),
        instances=replace(snapshot.instances, materials=np.array([[1, 2]], np.int32)),
    )
    scene = prepare(snapshot)
    assert scene.used_materials.tolist() == [1]
    assert not scene.transparent_surfaces


def test_many_surfaces_get_wider_numbers():
    """300 materials do not fit a byte."""
    objects = [(make.quad(), make.translation(k, 0, 0), make.diffuse(k / 300, f"m{k}")) for k in range(300)]
    geometry = flatten(make.scene(objects, CAMERA))
    assert geometry.surface.dtype == np.uint16
    assert geometry.surface_material[geometry.surface[:-1:2]].tolist() == list(range(1, 301))


def test_records_know_instance_and_emitter():
    lamp = make.emission(1.0)
    objects = [(make.quad(), UP, GREY), (make.box(), UP, lamp), (make.quad(), UP, lamp)]
    scene = prepare(make.scene(objects, CAMERA))
    prim = np.arange(-1, 16, dtype=np.int32)
    assert scene.geometry.integer(INSTANCE, prim).tolist()[1:] == [0] * 2 + [1] * 12 + [2] * 2
    assert scene.geometry.integer(EMITTER, prim).tolist() == [-1, -1, -1, *range(14)]
    assert scene.emissive_prim.tolist() == list(range(2, 16))


def test_a_miss_wraps_to_the_sky():
    """Primitive −1 is the last row: no normal, no plane, no emitter, surface 0; of few and of many."""
    for count in (10, 5000):
        scene = prepare(one(soup(count)))
        assert (scene.geometry._columns is None) == (count > 4096)
        assert (scene.geometry.planes(np.array([-1, -1], np.int32))[: BOUND + 1] == 0).all()
        assert scene.geometry.integer(EMITTER, np.array([-1], np.int32)).tolist() == [-1]
        shot = shoot(scene, [(50, 0, 0)], [(1, 0, 0)])
        assert shot.found.hits.prim.tolist() == [-1]
        assert shot.found.surface.tolist() == [SKY]


def test_few_and_many_records_are_read_alike():
    """Columns or rows: the same bits of every hit point."""
    scene = prepare(one(soup(4000)))
    assert scene.geometry._columns is not None
    rng = np.random.default_rng(3)
    o, target = 5 * rng.normal(size=(5000, 3)), rng.uniform(-1, 1, (5000, 3))
    few = shoot(scene, o, target - o)
    scene.geometry._columns = None
    many = shoot(scene, o, target - o)
    assert few.si.size > 1000
    for name in ("p", "ng", "wi", "bound", "facing", "prim", "t", "u", "v", "surface", "instance", "emitter"):
        np.testing.assert_array_equal(getattr(few.si, name), getattr(many.si, name), err_msg=name)


def test_a_hit_point_lies_on_its_triangle():
    """p = a + u (b − a) + v (c − a), put back onto the plane within a third of the bound."""
    snapshot = one(soup(3000), placed(rotation() * (1, 2, 0.5), (5, 5, 5)))
    scene, geometry = prepare(snapshot), flatten(snapshot)
    rng = np.random.default_rng(5)
    o, target = 30 * rng.normal(size=(4000, 3)), 5 + rng.uniform(-1, 1, (4000, 3))
    si = shoot(scene, o, target - o).si
    record = geometry.records[si.prim].astype(np.float64)
    height = (si.p.T * record[:, NORMAL]).sum(-1) - record[:, PLANE]
    assert np.abs(height / record[:, BOUND]).max() < 0.5
    a, b, c = np.moveaxis(geometry.vertices[geometry.triangles[si.prim]].astype(np.float64), 1, 0)
    expected = a + si.u[:, None] * (b - a) + si.v[:, None] * (c - a)
    # along the plane the error is that of t: 2⁻²³ of the distance, over the ray's slope
    error = np.linalg.norm(si.p.T - expected, axis=1) * np.abs(si.facing)
    assert error.max() < 2.0**-21 * si.t.max()
    np.testing.assert_allclose(np.abs((si.ng * si.wi).sum(axis=0)), np.abs(si.facing), atol=1e-6)
    assert ((si.ng * si.wi).sum(axis=0) >= 0).all()


def test_instances_of_a_mesh_share_its_shading_attributes():
    """100 copies: the table of normals is as long as one mesh's, plus the default."""
    ball = make.sphere(1.0, 8)
    snapshot = make.scene([(ball, make.translation(3 * k, 0, 0), GREY) for k in range(100)], CAMERA)
    snapshot = replace(
        snapshot, meshes=(ball,), instances=replace(snapshot.instances, mesh=np.zeros(100, np.int32))
    )
    scene = prepare(snapshot)
    assert scene.normals.values.shape == (3, len(ball.normals) + 1)
    assert scene.normals.index.shape == (3, len(ball.triangles) + 1)
    o = np.stack([3.0 * np.arange(100), np.full(100, -9.0), np.full(100, 0.1)], axis=1)
    si = shoot(scene, o, np.tile((0.0, 1.0, 0.0), (100, 1))).si
    assert si.instance.tolist() == list(range(100))
    ns = lanes_of(scene, si, smooth=True).ns
    np.testing.assert_allclose(ns, ns[:, :1] * np.ones(100), atol=1e-5)


def test_more_triangles_than_numbers_is_refused_before_memory_is_taken():
    """2048 placed copies of 2²⁰ triangles: 2³¹."""
    many = replace(
        make.quad(),
        triangles=np.broadcast_to(np.int32([0, 1, 2]), (1 << 20, 3)),
        material_slot=np.broadcast_to(np.int32(0), 1 << 20),
    )
    snapshot = one(many)
    i = snapshot.instances
    repeated = replace(
        i,
        mesh=np.repeat(i.mesh, 2048),
        matrix=np.repeat(i.matrix, 2048, axis=0),
        materials=np.repeat(i.materials, 2048, axis=0),
    )
    with pytest.raises(MemoryError, match="2,147,483,648"):
        flatten(replace(snapshot, instances=repeated))
