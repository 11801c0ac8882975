"""A slice is the scene that would be prepared of what stands still at its time, bit for bit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.motion import moving, standing_at
from support.rooms import half_transparent

from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.memory import TooLarge
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, Link, Node, Visibility

UP = np.eye(4)
CAMERA = make.perspective((0, -6, 3), (0, 0, 0.5), 0.5)
GREY = make.diffuse(0.6, "grey")
FLOOR = make.quad(12.0)  # the scene's box, wherever the small ones go: both are about the same centre
TOP = make.translation(0, 0, 4)
SKY = make.world(0.4)
SETTINGS = RenderSettings(24, 16, samples=4, threads=1, max_depth=4)
PATH = [
    make.translation(-1, 0, 1),
    make.translation(0, 0.5, 1) @ np.diag([1, -0.5, 1, 1.0]),
    make.translation(1, 0, 1.5) @ make.looking((0, 0, 0), (1, 2, 3)) @ np.diag([1, -1, 0.5, 1.0]),
]


def image(scene):
    return render(scene, SETTINGS).image()


def assert_slice_is_that_moment(snapshot, u=0.3):
    slice_ = prepare(snapshot).slices.at(u)
    assert slice_.time == pytest.approx(u, abs=1e-6)
    slice_.slices = None  # rendered as it is
    found, expected = image(slice_), image(prepare(standing_at(snapshot, slice_.time)))
    assert found[..., :3].std() > 0.01
    np.testing.assert_array_equal(found, expected)


def stage(*objects, lights=()):
    bounds = [(FLOOR, UP, GREY), (make.quad(0.1), TOP, GREY)]
    return make.scene([*objects, *bounds], CAMERA, lights, SKY)


@pytest.mark.parametrize("rings", [8, 48])
def test_a_rigid_body(rings):
    """Mirrored, stretched and turned, ahead of the rest in the file; few triangles and many."""
    still = make.sphere(1.0, rings, smooth=True), make.translation(-2, 1, 0.5), make.diffuse((0.9, 0.2, 0.1))
    snapshot = stage((make.box(1.0), PATH[1], make.diffuse((0.1, 0.8, 0.3))), still)
    assert_slice_is_that_moment(moving(snapshot, {0: PATH}))


def test_all_that_there_is():
    """Nothing stands still: the still tree is empty."""
    snapshot = stage((make.box(1.0), PATH[1], make.diffuse(0.3)))
    rows = {0: PATH, 1: [UP, UP], 2: [TOP, TOP]}
    assert_slice_is_that_moment(moving(snapshot, rows))


def test_a_mesh_that_changes_shape():
    """Flat and smooth, its normals following, both moving as well; two share the smooth one (`alone`)."""
    ball, cube = make.sphere(0.8, 8), make.box(1.0)
    beside = (cube, make.translation(2, 0, 1), make.diffuse(0.9))
    snapshot = stage((ball, PATH[1], GREY), beside, (ball, make.translation(-2, 0, 1), GREY))
    snapshot.instances.mesh[2] = 0
    squeezed = ball.vertices * np.float32([1, 1, 0.3])
    steep = ball.normals * np.float32([0.3, 0.3, 1])
    shapes = {
        0: (np.stack([ball.vertices, squeezed]), np.stack([ball.normals, steep])),
        1: np.stack([cube.vertices * np.float32(s) for s in (0.5, 1, 2)]),
    }
    snapshot = moving(snapshot, {0: PATH}, shapes)
    assert_slice_is_that_moment(snapshot)


def test_a_mesh_light():
    """The light comes from where it is now."""
    glow = make.emission((8.0, 6.0, 4.0), "glow")
    assert_slice_is_that_moment(moving(stage((make.quad(0.7), PATH[1], glow)), {0: PATH}))


def test_a_veil_moves():
    """Shadow rays pass what is transparent, still or not."""
    veil = half_transparent(0.5)
    snapshot = stage((make.quad(1.5), PATH[1], veil), (make.quad(2.0), make.translation(0, 0, 2), veil))
    assert_slice_is_that_moment(moving(snapshot, {0: PATH}))


def test_a_displaced_mesh_changes_shape():
    """It is displaced as it is now."""
    nodes = (
        Node("BsdfDiffuse", "d", {"Color": make.rgba(0.7)}),
        Node("TexCoord", "c", {}),
        Node("SeparateXYZ", "s", {"Vector": Link(1, "Object")}),
        Node(
            "Displacement", "u", {"Height": Link(2, "X"), "Midlevel": 0.0, "Scale": 0.4}, {"space": "OBJECT"}
        ),
    )
    outputs = {"Surface": Link(0, "BSDF"), "Displacement": Link(3, "Displacement")}
    bumpy = Graph("bumpy", nodes, outputs, displacement_method="DISPLACEMENT")
    ball = make.sphere(0.8, 8)
    shapes = np.stack([ball.vertices, ball.vertices * np.float32([1.5, 1, 0.5])])
    snapshot = stage((ball, PATH[1], bumpy), (make.sphere(0.5, 8), make.translation(2, 0, 1), bumpy))
    snapshot = moving(snapshot, {1: [make.translation(2, 0, 1), make.translation(2, 1, 1)]},
                      {0: (shapes, np.stack([ball.normals] * 2))})  # fmt: skip
    assert_slice_is_that_moment(snapshot)


def test_rays_within_its_own_object():
    """Ambient occlusion that looks at itself alone, on a moving box and on one that stands."""
    props = {"samples": 4, "only_local": True, "inside": True}
    node = Node("AmbientOcclusion", "a", {"Color": make.WHITE, "Distance": 1.0}, props)
    shine = Node("Emission", "e", {"Color": Link(0, "AO"), "Strength": 1.0})
    graph = Graph("looks", (node, shine), {"Surface": Link(1, "Emission")})
    snapshot = stage((make.box(1.0), PATH[1], graph), (make.box(1.0), make.translation(2, 1, 1), graph))
    assert_slice_is_that_moment(moving(snapshot, {0: PATH}))


def test_a_moving_camera_builds_nothing():
    """All of the scene but its camera is shared."""
    snapshot = stage((make.box(1.0), PATH[1], GREY))
    cameras = [make.perspective((x, -6, 3), (0, 0, 0.5), 0.5) for x in (-1, 1)]
    snapshot = moving(snapshot, cameras=cameras)
    scene = prepare(snapshot)
    there = scene.slices.at(0.3)
    assert scene.slices.triangles == 0
    assert there.geometry is scene.geometry
    assert there.accel is scene.accel
    assert there.lights is scene.lights
    assert_slice_is_that_moment(snapshot)


def test_materials_world_and_still_records_are_shared():
    scene = prepare(moving(stage((make.box(1.0), PATH[1], GREY), (make.sphere(1, 48), UP, GREY)), {0: PATH}))
    a, b = scene.slices.at(0.2), scene.slices.at(0.8)
    assert a.materials is b.materials
    assert a.world is b.world
    assert a.lights is b.lights  # no moving mesh shines
    assert a.geometry.records is b.geometry.records
    assert a.geometry.surface is scene.geometry.surface
    assert scene.slices.triangles == 12


def test_features_tell_whether_anything_moves():
    snapshot = stage((make.box(1.0), PATH[1], GREY))
    assert prepare(snapshot).features["motion blur"] == "off: nothing moves while the shutter is open"
    assert prepare(snapshot).slices is None
    assert prepare(moving(snapshot, {0: PATH})).features["motion blur"] == "on"


def test_a_motion_that_is_none_changes_no_bit():
    """Two equal steps of the file's own, untransformed objects."""
    snapshot = stage((make.box(1.0), UP, GREY))
    snapshot = replace(moving(snapshot, {0: [UP, UP]}))
    still = standing_at(snapshot, 0.5)
    np.testing.assert_array_equal(image(prepare(snapshot)), image(prepare(still)))


def test_what_slices_take_counts_for_the_scene():
    """Two of them at a time, and the shapes at all times; with less memory than that nothing is built."""
    ball = make.sphere(1.0, 48)
    snapshot = stage((ball, PATH[1], GREY))
    moved = moving(snapshot, {0: PATH}, {0: np.stack([ball.vertices] * 3)})
    still, scene = prepare(snapshot), prepare(moved)
    shapes, matrices = 3 * ball.vertices.nbytes, np.array(PATH).nbytes
    assert scene.bytes == still.bytes + scene.slices.bytes + shapes + matrices
    with pytest.raises(TooLarge):
        prepare(moved, memory=still.bytes)


def test_what_some_rays_do_not_see():
    """One that moves and one that stands still, each hidden from kinds of rays."""
    still = (make.box(0.7), make.translation(1.5, 0, 0.5), make.diffuse((0.9, 0.2, 0.1)))
    snapshot = stage((make.box(1.0), PATH[1], make.diffuse((0.1, 0.8, 0.3))), still)
    bits = snapshot.instances.visibility.copy()
    bits[0] &= ~np.uint8(Visibility.CAMERA)
    bits[1] &= ~np.uint8(Visibility.SHADOW | Visibility.DIFFUSE)
    snapshot = replace(snapshot, instances=replace(snapshot.instances, visibility=bits))
    assert_slice_is_that_moment(moving(snapshot, {0: PATH}))
