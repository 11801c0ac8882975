"""A scene that is prepared once and seen through another camera, as the views of a stereo render are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.motion import moving
from support.rooms import GLASS, SOFT_LAMP, room

from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.world import compile_world
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.another_view import made_for_one_view, through
from pt_engine.scene.movement import beside
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, Link, Node, Visibility

SETTINGS = RenderSettings(16, 16, samples=4, threads=1)
OTHER = replace(make.perspective((1.5, -4, 2), (0, 0, 0.9), 0.4), aperture_radius=0.05, focus_distance=4.0)


def image(scene):
    return render(scene, SETTINGS).image()


def seen_by_other(snapshot):
    """The snapshot through the other camera, which moves along with its own."""
    motion = snapshot.motion
    if motion is not None:
        motion = replace(motion, cameras=beside(motion.cameras, snapshot.camera, OTHER))
    return replace(snapshot, camera=OTHER, motion=motion)


def moved(snapshot):
    """The ball and the camera move."""
    steps = [make.translation(x, 0.3, 0.7) for x in (-0.2, 0.2)]
    cameras = [
        replace(snapshot.camera, matrix=make.translation(x, 0, 0) @ snapshot.camera.matrix) for x in (0, 0.3)
    ]
    return moving(snapshot, {2: steps}, cameras=cameras)


def with_a_catcher(snapshot):
    bits = snapshot.instances.visibility.copy()
    bits[0] |= Visibility.CATCHER
    return replace(snapshot, instances=replace(snapshot.instances, visibility=bits))


CHANGES = {
    "still": lambda snapshot: snapshot,
    "moving": moved,
    "catcher": with_a_catcher,
    "moving beside a catcher": lambda snapshot: moved(with_a_catcher(snapshot)),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_it_is_the_scene_prepared_for_that_camera_bit_for_bit(change):
    """Radiance, features and coverage; and the first view is as it was."""
    snapshot = change(room(GLASS, SOFT_LAMP, make.world(0.3)))
    other = seen_by_other(snapshot)
    scene = prepare(snapshot)
    before = image(scene)
    seen, anew = through(scene, other), prepare(other)
    np.testing.assert_array_equal(image(seen), image(anew))
    np.testing.assert_array_equal(image(scene), before)
    assert not np.array_equal(image(seen), before)
    assert seen.features == anew.features != scene.features
    assert seen.coverage == anew.coverage


def test_a_world_that_depends_on_the_camera_is_made_for_each():
    """Its light is tabulated for one camera; that of materials is asked when it is seen."""
    assert of_one_view("Window")
    assert of_one_view("Camera")
    assert not of_one_view("Generated")


def test_what_is_made_for_one_view_is_not_shown_to_another():
    scene = prepare(room(GLASS, SOFT_LAMP))
    scene.of_one_view = True
    assert through(scene, seen_by_other(room(GLASS, SOFT_LAMP))) is None


def of_one_view(output):
    """Of a world whose colour is an output of Texture Coordinate."""
    place = Node("TexCoord", "place", {})
    background = Node("Background", "sky", {"Color": Link(0, output), "Strength": 1.0})
    world = compile_world(Graph("world", (place, background), {"Surface": Link(1, "Background")}))
    return made_for_one_view(compile_materials([]), world, [])
