"""Strands and points at other times of the shutter: where they go is exported, how they bend is listed."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_motion import animate  # noqa: E402
from support.bpy_scenes import add, cube, export, shutter_scene  # noqa: E402

from pt_engine.scene.hulls import STILL  # noqa: E402
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


def stills(snapshot):
    """Objects whose motion blur `prepare` lists as missing."""
    return {entry.material for entry in prepare(snapshot).coverage if entry.node == STILL}


def rows_that_move(snapshot):
    return sorted(int(k) for rows in snapshot.motion.instances for k in rows.instance)


def test_curves_that_move(scene):
    """Beside a box that does as well; nothing is said of those that stay as they are."""
    animate(tuft(), "location", PLACES)
    animate(add(cube(), "Box"), "location", PLACES)
    snapshot = blurred()
    assert rows_that_move(snapshot) == [0, 1]
    assert stills(snapshot) == {"Object Tuft"}
    assert not [entry for entry in snapshot.unsupported if entry[1] == "motion blur"]


def test_curves_that_stand_still(scene):
    tuft()
    animate(add(cube(), "Box"), "location", PLACES)
    snapshot = blurred()
    assert not stills(snapshot)
    assert prepare(snapshot).slices is not None


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
    assert stills(snapshot) == {"Object Sphere"}
    assert prepare(snapshot).slices is not None


def test_strands_on_a_mesh_that_bends_are_listed(scene):
    ball = haired(scene)
    ball.shape_key_add(name="Basis")
    key = ball.shape_key_add(name="Long")
    for point in key.data:
        point.co.z *= 2
    for frame, value in ((1, 0.0), (3, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    scene.frame_set(2)
    snapshot = blurred()
    assert len(snapshot.motion.meshes) == 1
    assert ("Object Sphere", "motion blur", "sharp where strands or points change") in snapshot.unsupported
