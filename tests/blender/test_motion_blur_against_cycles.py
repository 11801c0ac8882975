"""Motion blur as Cycles has it: what moves, turns, grows and changes shape, the camera, instances, particles.

All pixels of one of our pictures see the same times, so their errors are not independent, as the test takes
them to be: a cell that differs by less than 1 % of the picture's mean is no matter.
"""

import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_motion import animate  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.moving_room import (  # noqa: E402
    box,
    changing_shape,
    moving_box,
    moving_camera,
    moving_lights,
    moving_nodes,
    particles,
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


def test_the_camera(scene, tmp_path):
    """It goes along, turns and zooms."""
    moving_camera(scene)
    agree(scene, tmp_path)


def test_shapes(scene, tmp_path):
    """A shape key, on a smooth mesh under a shutter that opens slowly."""
    changing_shape(scene)
    agree(scene, tmp_path)


def test_lamps_stay_in_the_middle(scene, tmp_path):
    """Cycles does not blur them, nor do we; a mesh that shines moves."""
    moving_lights(scene)
    agree(scene, tmp_path)


def test_instances(scene, tmp_path):
    """Of a collection by an empty that turns."""
    turning_collection(scene)
    agree(scene, tmp_path)


def test_instances_of_geometry_nodes(scene, tmp_path):
    """On the points of a plane that turns, and moved by the nodes themselves."""
    moving_nodes(scene)
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


def test_particles(scene, tmp_path):
    """Boxes thrown up from a plane; one that is born while the shutter is open is not there, as in Cycles."""
    particles(scene)
    agree(scene, tmp_path)
