"""Motion blur as Cycles has it: what moves, turns, grows and changes shape, the camera, instances, particles.

All pixels of one of our pictures see the same times, so their errors are not independent, as the test takes
them to be: a cell that differs by less than 1 % of the picture's mean is no matter.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_motion import animate  # noqa: E402
from support.bpy_scenes import add  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.moving_room import (  # noqa: E402
    box,
    changing_shape,
    material,
    moving_box,
    moving_camera,
    moving_cloud,
    moving_lights,
    moving_nodes,
    particles,
    shaped_by_nodes,
    stage,
    turning_collection,
)
from support.ztest import compare  # noqa: E402

SIZE, THEIRS, OURS = (36, 24), 128, 32
TOLERANCE = 0.01
pytestmark = pytest.mark.slow


@pytest.fixture(name="scene")
def _scene():
    return stage()


def agree(scene, folder, theirs=THEIRS, ours=OURS):
    scene.frame_set(2)
    a = by_engine(ours, SIZE, max_depth=3)
    assert (scene.frame_current, scene.frame_subframe) == (2, 0)
    b = by_cycles(theirs, SIZE, folder, max_bounces=1, diffuse_bounces=1)
    found = compare(a, b)
    assert found.agrees(TOLERANCE), str(found)
    return a, b


@pytest.mark.parametrize("position", ["START", "CENTER", "END"])
def test_objects_that_move_turn_and_grow(scene, tmp_path, position):
    scene.render.motion_blur_position = position
    moving_box(scene)
    agree(scene, tmp_path)


MOVES = (
    moving_camera,
    changing_shape,
    moving_lights,
    turning_collection,
    moving_nodes,
    particles,
    moving_cloud,
)


@pytest.mark.parametrize("build", MOVES, ids=lambda build: build.__name__)
def test_what_else_moves(scene, tmp_path, build):
    """Lamps are not blurred; a particle born while the shutter is open is not there: both as in Cycles."""
    build(scene)
    agree(scene, tmp_path)


@pytest.mark.parametrize("points", [False, True], ids=["mesh", "points"])
@pytest.mark.parametrize("by", ["offset", "velocity"])
def test_what_geometry_nodes_move(scene, tmp_path, by, points):
    """A mesh or points, by what the nodes make of them at each time or by the velocities that they store."""
    shaped_by_nodes(scene, by, points)
    agree(scene, tmp_path)


@pytest.mark.parametrize("when", ["comes", "goes"])
def test_what_comes_or_goes(scene, tmp_path, when):
    """It is there in the middle of the shutter's time, but not at its beginning or at its end."""
    owner = box()
    animate(owner, "location", [(-2, 0, 0), (0, 0, 0.5), (2, 1, 1)])
    hidden = (True, False, False) if when == "comes" else (False, False, True)
    for frame, state in zip((1, 2, 2.4), hidden, strict=True):
        owner.hide_render = owner.hide_viewport = state
        owner.keyframe_insert("hide_render", frame=frame)
        owner.keyframe_insert("hide_viewport", frame=frame)
    agree(scene, tmp_path)


@pytest.mark.parametrize("duration", [0.0, 0.4])
def test_a_rolling_shutter(scene, tmp_path, duration):
    """An object and the camera move; a shorter row of the shutter's time than the whole moves each less."""
    scene.cycles.rolling_shutter_type, scene.cycles.rolling_shutter_duration = "TOP", duration
    animate(box(), "location", [(-3, 0, 0), (0, 0, 0.5), (3, 1, 1)])
    animate(scene.camera, "rotation_euler", [(1.2, 0, -0.1), (1.25, 0, 0), (1.3, 0, 0.1)])
    agree(scene, tmp_path)


def test_a_shadow_catcher(scene, tmp_path):
    """It goes down as a box goes over it, and turns."""
    floor = bpy.data.objects["Floor"]
    floor.is_shadow_catcher = True
    animate(floor, "location", [(0, 0, 0.6), (0, 0, 0), (0, 0, -0.6)])
    animate(floor, "rotation_euler", [(0, 0.1, 0), (0, 0, 0), (0.1, 0, 0)])
    animate(box(), "location", [(-2, 0, 0), (0, 0, 0.5), (2, 1, 1)])
    agree(scene, tmp_path)


def tuft(count=60):
    curves = bpy.data.hair_curves.new("Tuft")
    curves.add_curves([4] * count)
    rng = np.random.default_rng(2)
    roots = rng.uniform((-0.8, -0.8, -1), (0.8, 0.8, -1), (count, 3))
    lean = rng.uniform(-0.5, 0.5, (count, 3)) * (1, 1, 0)
    points = [roots + k * np.array([0, 0, 0.6]) + k * k / 9 * lean for k in range(4)]
    curves.attributes["position"].data.foreach_set("vector", np.stack(points, 1).astype(np.float32).ravel())
    curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", [0.05] * 4 * count)
    curves.materials.append(material("Tuft", (0.8, 0.3, 0.1)))
    return add(curves, "Tuft")


@pytest.mark.parametrize("shape", ["THICK", "RIBBONS"])
def test_curves_that_move_and_grow(scene, tmp_path, shape):
    scene.cycles_curves.shape = shape
    owner = tuft()
    animate(owner, "location", [(-1.5, 0, 0), (0, 0, 0), (1.5, 0.5, 0.3)])
    animate(owner, "rotation_euler", [(0, 0, 0), (0.3, 0, 0.5), (0.6, 0, 1)])
    animate(owner, "scale", [(1, 1, 1), (1, 1, 1), (1.2, 1, 0.7)])
    agree(scene, tmp_path)


def test_strands_on_a_mesh_that_bends(scene, tmp_path):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6)
    ball = bpy.context.object
    ball.modifiers.new("Hair", "PARTICLE_SYSTEM")
    settings = ball.particle_systems[0].settings
    settings.type, settings.count, settings.hair_length = "HAIR", 200, 1.0
    settings.root_radius = settings.tip_radius = 4.0
    settings.display_step = settings.render_step  # ours reads the viewport's depsgraph here, Cycles renders
    ball.shape_key_add(name="Basis")
    key = ball.shape_key_add(name="Long")
    for point in key.data:
        point.co.x += 1.5 * point.co.z
    animate(key, "value", (0.0, 0.5, 1.0))
    ball.data.materials.append(material("Ball", (0.8, 0.3, 0.1)))
    agree(scene, tmp_path)


def test_velocities(scene, tmp_path):
    """Of a mesh, which are all there is, and of strands; 24 frames are a second."""
    owners = box("Box", 1.0), tuft()
    for owner, speed in zip(owners, ((36, 0, 0), (-24, 0, 12)), strict=True):
        made = owner.data.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
        made.data.foreach_set("vector", np.tile(np.float32(speed), len(made.data)))
    agree(scene, tmp_path)
