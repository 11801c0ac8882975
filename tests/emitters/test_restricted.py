"""Emitters that do not shine on everyone: both strategies leave out the same light."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.lamps import lamp, lights, placed

from pt_engine.core.raykind import RayKind
from pt_engine.emitters.restricted import SEEN_AS, Linking, Shown, Ways
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Linking as Links
from pt_engine.scene.snapshot import Visibility

BALL = lamp("POINT", placed(z=2.0), radius=0.5)


def test_where_all_shine_on_everyone_there_is_nothing_to_ask():
    assert lights(BALL, replace(BALL, power=3.0)).restrictions is None


@pytest.mark.parametrize(
    ("kind", "needs"),
    [
        (RayKind.CAMERA, Visibility.CAMERA),
        (RayKind.REFLECTION | RayKind.DIFFUSE, Visibility.DIFFUSE),
        (RayKind.REFLECTION | RayKind.GLOSSY | RayKind.SINGULAR, Visibility.GLOSSY),
        (RayKind.TRANSMISSION | RayKind.GLOSSY, Visibility.TRANSMISSION),
        (RayKind.TRANSMISSION | RayKind.DIFFUSE, Visibility.TRANSMISSION | Visibility.DIFFUSE),
    ],
)
def test_what_a_ray_has_to_be_shown(kind, needs):
    """Cycles' table: a diffusely transmitted ray is both, a refracted one is not glossy."""
    assert SEEN_AS[kind] == needs


def test_linking_shows_the_camera_all():
    links = Linking(np.array([[True, False], [True, True]]), np.array([0, 1], np.int32))
    emitters, instances = np.array([0, 1, 1, 1], np.int32), np.array([0, 0, 1, -1], np.int32)
    assert links.lights(emitters, instances).tolist() == [True, False, True, True]


def test_max_bounces_count_from_the_surface_that_is_lit():
    limits = lights(replace(BALL, max_bounces=1)).restrictions
    depth, nobody = np.arange(4, dtype=np.int32), np.full(4, -1, np.int32)
    assert limits.sampled(0, nobody, depth).tolist() == [True, True, False, False]
    onward = Ways(np.full(4, RayKind.REFLECTION | RayKind.DIFFUSE, np.int32), nobody, depth + 1, depth < 0)
    assert limits.met(0, onward).tolist() == [True, True, False, False]  # rays that left those surfaces


def floors(linking, lamps):
    """Two white sheets side by side under lamps."""
    rows = [(make.quad(2.0), make.translation(x, 0, 0), make.diffuse(1.0)) for x in (-1.0, 1.0)]
    camera = make.orthographic((0, 0, 9), (0, 0, 0), 4.0)
    return replace(make.scene(rows, camera, lamps), linking=linking)


@pytest.mark.parametrize("integrator", ["path", "path_fixed", "direct_mis", "direct_emitter", "direct_bsdf"])
def test_a_linked_lamp_lights_its_receiver_alone(integrator):
    """One lamp for each sheet, of opposite colours: all of a sheet's light is of its own lamp's colour.

    Rays that meet the lamps by chance and samples of them both have to leave out the other.
    """
    red, blue = ((1.0, 0.0, 0.0), 1), ((0.0, 0.0, 1.0), 2)
    lamps = [replace(BALL, color=color, group=group) for color, group in (red, blue)]
    receives = np.array([[1, 0, 0], [1, 1, 0], [1, 0, 1]], np.uint8)
    sets = np.array([1, 2], np.int32)
    zero = np.zeros(2, np.int32)
    links = Links(receives, np.ones((1, 3), np.uint8), sets, zero, zero)
    scene = prepare(floors(links, lamps))
    assert scene.features["light linking"] == "on"
    image = render(scene, RenderSettings(8, 4, samples=64, integrator=integrator, max_depth=3)).image()
    left, right = image[:, :3], image[:, 5:]  # the filter reaches over the edge between the sheets
    assert left[..., 0].mean() > 0.1
    assert right[..., 2].mean() > 0.1
    assert left[..., 2].max() == right[..., 0].max() == 0


def test_only_what_scatters_makes_a_restriction():
    """Hidden from glossy rays, not from the camera alone; the world's visibility where it is an emitter."""
    assert lights(replace(BALL, visibility=Visibility.ALL & ~Visibility.GLOSSY)).restrictions.hides
    assert lights(replace(BALL, visibility=Visibility.ALL & ~Visibility.CAMERA)).restrictions is None
    assert lights(BALL, shown=Shown(Visibility.DIFFUSE)).restrictions is None
