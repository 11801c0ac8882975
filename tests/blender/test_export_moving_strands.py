"""Strands and points at other times of the shutter: where they go, and how they bend."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_motion import animate  # noqa: E402
from support.bpy_scenes import add, cube, export, shutter_scene  # noqa: E402

from pt_engine.scene.prepare import prepare  # noqa: E402

PLACES = [(0, 0, 0), (2, 0, 0), (4, 0, 2)]


@pytest.fixture(autouse=True)
def scene():
    return shutter_scene()


def blurred():
    scene = bpy.context.scene
    return export(frame_set=lambda frame, part: scene.frame_set(frame, subframe=part))


def tuft():
    curves = bpy.data.hair_curves.new("Tuft")
    curves.add_curves([3, 3])
    points = np.random.default_rng(0).random((6, 3), np.float32)
    curves.attributes["position"].data.foreach_set("vector", points.ravel())
    return add(curves, "Tuft")


def rows_that_move(snapshot):
    return sorted(int(k) for rows in snapshot.motion.instances for k in rows.instance)


def test_curves_that_move(scene):
    """Beside a box that does as well; nothing is said of those that stay as they are."""
    animate(tuft(), "location", PLACES)
    animate(add(cube(), "Box"), "location", PLACES)
    snapshot = blurred()
    assert rows_that_move(snapshot) == [0, 1]
    assert snapshot.motion.rounds == ()
    assert snapshot.unsupported == ()
    assert prepare(snapshot).slices.triangles > 12


def test_curves_that_stand_still(scene):
    tuft()
    animate(add(cube(), "Box"), "location", PLACES)
    snapshot = blurred()
    assert snapshot.motion.rounds == ()
    assert prepare(snapshot).slices.triangles == 12


def haired(scene):
    """A ball with strands."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=4)
    ball = bpy.context.object
    ball.modifiers.new("Hair", "PARTICLE_SYSTEM")
    settings = ball.particle_systems[0].settings
    settings.type, settings.count = "HAIR", 5
    return ball


def test_strands_on_a_mesh_that_moves(scene):
    """Mesh and strands are two instances of one object; both go its way."""
    animate(haired(scene), "location", PLACES)
    snapshot = blurred()
    assert rows_that_move(snapshot) == [0, 1]
    paths = [rows.matrix[k] for rows in snapshot.motion.instances for k in range(len(rows.instance))]
    np.testing.assert_array_equal(paths[0], paths[1])
    assert snapshot.motion.rounds == ()
    assert prepare(snapshot).slices is not None


def test_strands_on_a_mesh_that_bends(scene):
    ball = haired(scene)
    ball.shape_key_add(name="Basis")
    key = ball.shape_key_add(name="Long")
    for point in key.data:
        point.co.z *= 2
    animate(key, "value", (0.0, 0.5, 1.0))
    scene.frame_set(2)
    snapshot = blurred()
    (bent,) = snapshot.motion.rounds
    assert bent.geometry == 1
    assert len(snapshot.motion.meshes) == 1
    np.testing.assert_allclose(bent.points[1], snapshot.curves[0].points)
    roots = bent.points[:, snapshot.curves[0].first[:-1]]
    # the shutter is open for half a frame, in which the key grows by a quarter
    expected = np.array([1.375, 1.5, 1.625])[:, None] / 1.5 * roots[1, :, 2]
    np.testing.assert_allclose(roots[..., 2], expected, atol=1e-4)
    assert np.abs(expected - roots[1, :, 2]).max() > 0.02
    assert snapshot.unsupported == ()


def speeds(data, speed):
    made = data.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
    made.data.foreach_set("vector", np.tile(np.float32(speed), len(made.data)))
    return data


def test_velocities_say_where_points_are(scene):
    """In metres a second; the shutter is open for half a frame of 24 in a second. Nothing else moves."""
    add(speeds(cube(), (24.0, 0, 0)), "Box")
    speeds(tuft().data, (0, 48.0, 0))
    snapshot = blurred()
    (box,), (strands,) = snapshot.motion.meshes, snapshot.motion.rounds
    np.testing.assert_allclose(
        box.vertices[:, :, 0] - snapshot.meshes[0].vertices[:, 0], [[-0.25] * 8, [0.25] * 8]
    )
    np.testing.assert_allclose(
        strands.points[:, :, 1] - snapshot.curves[0].points[:, 1], [[-0.5] * 6, [0.5] * 6], atol=1e-6
    )
    assert prepare(snapshot).slices is not None
    scene.render.use_motion_blur = False
    assert blurred().motion is None
