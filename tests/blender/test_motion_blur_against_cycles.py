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


MOVES = (moving_camera, changing_shape, moving_lights, turning_collection, moving_nodes, particles)


@pytest.mark.parametrize("build", MOVES, ids=lambda build: build.__name__)
def test_what_else_moves(scene, tmp_path, build):
    """Lamps are not blurred; a particle born while the shutter is open is not there: both as in Cycles."""
    build(scene)
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
