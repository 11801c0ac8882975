"""What moves is read at the shutter's times, matched to who it is, and the frame is restored."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_motion import animate  # noqa: E402
from support.bpy_scenes import add, cube, export, shutter_scene  # noqa: E402

from pt_engine.blender.export import ExportError  # noqa: E402
from pt_engine.scene.movement import Movement, moving_last  # noqa: E402


@pytest.fixture(autouse=True)
def scene():
    return shutter_scene()


class Frames:
    """`frame_set` that remembers where it went, and fails there if told so."""

    def __init__(self, fails_at=None):
        self.scene, self.visited, self.fails_at = bpy.context.scene, [], fails_at

    def __call__(self, frame, part):
        self.visited.append(frame + part)
        if len(self.visited) == self.fails_at:
            raise RuntimeError("no such time")
        self.scene.frame_set(frame, subframe=part)


def blurred(**more):
    frames = Frames()
    return export(frame_set=frames, **more), frames.visited


def mover(**settings):
    owner = add(cube(), "Mover", **settings)
    animate(owner, "location", [(0, 0, 0), (2, 0, 0), (4, 0, 2)])
    return owner


@pytest.mark.parametrize(("position", "middle"), [("START", 2.25), ("CENTER", 2.0), ("END", 1.75)])
def test_the_shutter_is_open_around_before_or_after_the_frame(scene, position, middle):
    mover()
    scene.render.motion_blur_position = position
    snapshot, visited = blurred()
    times = np.array([middle - 0.25, middle, middle + 0.25])
    path = snapshot.motion.instances[0].matrix[0, :, 0, 3]
    np.testing.assert_allclose(path, 2 * (times - 1), atol=1e-6)
    np.testing.assert_allclose(snapshot.instances.matrix[0, 0, 3], path[1])
    assert {middle - 0.25, middle + 0.25} <= set(visited)
    assert snapshot.frame == scene.frame_current == 2
    assert scene.frame_subframe == 0


@pytest.mark.parametrize("steps", [1, 2, 4])
def test_motion_steps_are_powers_of_two_of_intervals(scene, steps):
    mover().cycles.motion_steps = steps
    other = add(cube("Other"), "Other")
    animate(other, "location", [(0, 0, 0), (0, 1, 0), (0, 2, 0)])
    snapshot, visited = blurred()
    counts = {
        int(rows.instance[0]): rows.matrix.shape[1]
        for rows in snapshot.motion.instances
        for _ in rows.instance
    }
    assert sorted({rows.matrix.shape[1] for rows in snapshot.motion.instances}) == sorted({3, 2**steps + 1})
    assert counts[0] == 2**steps + 1
    assert len(set(visited)) == 2**steps + 1


def test_what_is_not_to_be_blurred_stands_still(scene):
    owner = mover()
    owner.cycles.use_motion_blur = False
    assert blurred()[0].motion is None
    empty = add(None, "Empty", instance_type="COLLECTION")
    collection = bpy.data.collections.new("Collection")
    collection.objects.link(add(cube("Child"), "Child"))
    scene.collection.objects.unlink(bpy.data.objects["Child"])
    empty.instance_collection = collection
    animate(empty, "location", [(0, 0, 0), (2, 0, 0), (4, 0, 2)])
    assert blurred()[0].motion is not None
    empty.cycles.use_motion_blur = False  # an instancer's switch counts as well
    assert blurred()[0].motion is None


def test_nothing_that_could_move_costs_no_frame(scene):
    add(cube())
    snapshot, visited = blurred()
    assert snapshot.motion is None
    assert visited == []
    assert snapshot.unsupported == ()


@pytest.mark.parametrize("off", ["shutter 0", "switch"])
def test_no_shutter_no_motion(scene, off):
    mover()
    scene.render.motion_blur_shutter, scene.render.use_motion_blur = 0.5 * (off == "switch"), off != "switch"
    snapshot, visited = blurred()
    assert snapshot.motion is None
    assert visited == []


def test_what_is_animated_but_stands_while_the_shutter_is_open(scene):
    owner = add(cube(), "Mover")
    animate(owner, "location", [(1, 0, 0), (1, 0, 0), (1, 0, 0)])
    assert blurred()[0].motion is None


@pytest.mark.parametrize("fails_at", [1, 2])
def test_the_frame_is_restored_after_a_failure(scene, fails_at):
    mover()
    frames = Frames(fails_at)
    with pytest.raises(RuntimeError, match="no such time"):
        export(frame_set=frames)
    assert (scene.frame_current, scene.frame_subframe) == (2, 0.0)
    scene.camera, scene.render.motion_blur_position = None, "START"
    with pytest.raises(ExportError):
        export(frame_set=Frames())
    assert (scene.frame_current, scene.frame_subframe) == (2, 0.0)


def test_shape_keys_and_their_normals(scene):
    owner = add(cube(), "Keyed")
    owner.data.shade_smooth()
    owner.shape_key_add(name="Basis")
    key = owner.shape_key_add(name="tall")
    for point in key.data:
        if point.co.z > 0:
            point.co.x *= 3
    animate(key, "value", [0, 0.5, 1])
    (motion,) = blurred()[0].motion.meshes
    top = motion.vertices[0, :, 2] > 0
    np.testing.assert_allclose(
        np.abs(motion.vertices[:, top, 0]), [[1.75] * 4, [2.0] * 4, [2.25] * 4], atol=1e-6
    )
    assert motion.normals.shape == (3, 8, 3)
    assert (
        np.diff(motion.normals[:, top, 2], axis=0) < 0
    ).all()  # the wider the top, the more walls look down
    owner.cycles.use_deform_motion = False
    assert blurred()[0].motion is None


def test_a_mesh_whose_faces_change_is_named_and_keeps_its_shape(scene):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4)
    modifier = bpy.context.object.modifiers.new("Build", "BUILD")
    modifier.frame_start, modifier.frame_duration = 1, 4
    snapshot, _ = blurred()
    assert snapshot.motion is None
    assert [(where, what) for where, what, _ in snapshot.unsupported] == [("Object Grid", "motion blur")]
    assert "faces change" in snapshot.unsupported[0][2]


def test_who_appears_stands_still_when_it_is_not_there(scene):
    owner = mover()
    for frame, hidden in ((1, True), (2, False)):
        owner.hide_render = owner.hide_viewport = hidden
        owner.keyframe_insert("hide_viewport", frame=frame)
    scene.frame_set(2)
    snapshot, _ = blurred()
    np.testing.assert_allclose(snapshot.motion.instances[0].matrix[0, :, 0, 3], [2, 2, 2.5], atol=1e-6)
    assert [what for _, what, _ in snapshot.unsupported] == ["appears or vanishes while the shutter is open"]


def test_particles_that_are_born_meanwhile_are_not_there(scene):
    """Of ten, one is born in each of ten steps; the one within the shutter is left out, as in Cycles."""
    grain = add(cube("Grain", 0.1), "Grain", location=(0, 50, 0))
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.context.object.modifiers.new("Particles", "PARTICLE_SYSTEM")
    system = bpy.context.object.particle_systems[0].settings
    system.count, system.frame_start, system.frame_end, system.lifetime = 10, -7, 3, 50
    system.render_type, system.instance_object, system.normal_factor = "OBJECT", grain, 3.0
    for frame in range(-7, 3):
        scene.frame_set(frame)
    still = export()
    snapshot, _ = blurred()
    lost = len(still.instances.names) - len(snapshot.instances.names)
    assert lost == 1
    (rows,) = snapshot.motion.instances
    np.testing.assert_allclose(rows.matrix[:, 1], snapshot.instances.matrix[rows.instance])


def test_the_camera_and_its_lens(scene):
    animate(scene.camera, "location", [(0, 0, 0), (1, 0, 0), (2, 0, 0)])
    animate(scene.camera.data, "lens", [30, 40, 50])
    cameras = blurred()[0].motion.cameras
    np.testing.assert_allclose([c.matrix[0, 3] for c in cameras], [0.75, 1, 1.25], atol=1e-6)
    np.testing.assert_allclose([36 / (2 * c.frame[1]) for c in cameras], [37.5, 40, 42.5], rtol=1e-6)
    scene.camera.cycles.use_motion_blur = False
    assert blurred()[0].motion is None


def test_a_scale_through_zero_stays_finite_and_passes_through_a_point(scene):
    owner = add(cube(), "Mover")
    animate(owner, "scale", [(2, 2, 2), (0, 0, 0), (-2, -2, -2)])
    snapshot = moving_last(blurred()[0])
    movement = Movement(snapshot, snapshot.motion)
    sizes = [np.linalg.norm(movement.instances(t).matrix[0, :3, 0]) for t in (0, 0.25, 0.5, 0.75, 1)]
    np.testing.assert_allclose(sizes, [0.5, 0.25, 0, 0.25, 0.5], atol=1e-6)


@pytest.mark.parametrize(("kind", "expected"), [("NONE", 1.0), ("TOP", 0.25)])
def test_a_rolling_shutter_exposes_rows_for_its_duration(scene, kind, expected):
    scene.cycles.rolling_shutter_type, scene.cycles.rolling_shutter_duration = kind, 0.25
    mover()
    assert blurred()[0].motion.row_exposure == expected


def test_links_follow_the_instances_that_stay(scene):
    """A particle is left out, and with it its row of the links."""
    test_particles_that_are_born_meanwhile_are_not_there(scene)
    lamp = add(bpy.data.lights.new("Lamp", "POINT"))
    receivers = bpy.data.collections.new("Receivers")
    receivers.objects.link(bpy.data.objects["Grain"])
    lamp.light_linking.receiver_collection = receivers
    mover()
    snapshot, _ = blurred()
    assert snapshot.linking is not None
    assert len(snapshot.linking.receiver) == len(snapshot.instances.names)
