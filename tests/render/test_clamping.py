"""Clamping: what one sample may bring, of light after one bounce and after more; nothing when off."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.rooms import MIRROR

from pt_engine.render.clamping import Clamp, clamp_of
from pt_engine.render.progressive import render
from pt_engine.render.replay import replay
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import LightData

SUN, ALBEDO, REFLECTANCE = 8.0, 0.5, 0.9
DIRECT = ALBEDO / np.pi * SUN * np.sqrt(0.5)  # 45° above the plane: every sample brings just this
INDIRECT = REFLECTANCE * DIRECT
LIMITED = {"path", "path_active", "path_fixed", "direct_emitter", "direct_mis"}


def seen_from_above(mirrored):
    """A plane under a sun without a size; or a mirror, in which such a plane is seen overhead."""
    camera = make.perspective((0, 0, 2), (0, 0, 0), 0.2)
    if mirrored:
        above = make.translation(0, 0, 10) @ np.diag([1.0, -1.0, -1.0, 1.0])
        sun = LightData("SUN", "sun", make.looking((10, 0, 0), (0, 0, 10)), SUN)
        objects = [(make.quad(2.0), np.eye(4), MIRROR), (make.quad(9.0), above, make.diffuse(ALBEDO))]
    else:
        sun = LightData("SUN", "sun", make.looking((10, 0, 10), (0, 0, 0)), SUN)
        objects = [(make.quad(4.0), np.eye(4), make.diffuse(ALBEDO))]
    return prepare(make.scene(objects, camera, [sun]))


def settings(**how):
    return RenderSettings(4, 4, **{"samples": 4, "threads": 1, "max_depth": 4, **how})


@pytest.mark.parametrize("integrator", sorted(LIMITED))
def test_direct_light_is_cut_at_its_own_limit(integrator):
    scene = seen_from_above(mirrored=False)
    for direct, indirect, expected in ((0, 0.1, DIRECT), (0.5, 0, 0.5), (2, 0, DIRECT)):
        how = settings(integrator=integrator, clamp_direct=direct, clamp_indirect=indirect)
        np.testing.assert_allclose(render(scene, how).image()[..., :3], expected, rtol=1e-5)


@pytest.mark.parametrize("integrator", ["path", "path_fixed"])
def test_light_after_two_bounces_is_indirect(integrator):
    scene = seen_from_above(mirrored=True)
    for direct, indirect, expected in ((0.1, 0, INDIRECT), (0, 0.5, 0.5), (0, 2, INDIRECT)):
        how = settings(integrator=integrator, clamp_direct=direct, clamp_indirect=indirect)
        np.testing.assert_allclose(render(scene, how).image()[..., :3], expected, rtol=1e-5)


@pytest.mark.parametrize(
    ("mirrors", "limit"), [(0, "clamp_direct"), (1, "clamp_direct"), (2, "clamp_indirect")]
)
def test_light_that_rays_find_counts_its_bounces(mirrors, limit):
    """The sky, met by camera rays, in a mirror, and in two that face each other at 45° to the view."""
    tilt = make.looking((0, 0, 0), (1, 0, -1)) if mirrors else np.eye(4)
    objects = [(make.quad(2.0), tilt, MIRROR)][:mirrors]
    if mirrors == 2:
        objects += [(make.quad(2.0), make.translation(-3, 0, 0) @ tilt, MIRROR)]
        objects += [(make.quad(2.0), make.translation(3, 0, 0) @ tilt, MIRROR)]
    scene = prepare(make.scene(objects, make.perspective((0, 0, 4), (0, 0, 0), 0.05), sky=make.world(5.0)))
    free = render(scene, settings()).image()[..., :3]
    np.testing.assert_allclose(free, 5 * REFLECTANCE**mirrors, rtol=1e-5)
    np.testing.assert_allclose(render(scene, settings(**{limit: 1.5})).image()[..., :3], 1.5, rtol=1e-5)


def test_colours_keep_their_hue_and_dim_light_is_let_alone():
    """Scaled so that the mean of the channels is the limit, as Cycles does it."""
    radiance = np.array([[6.0, 3.0, 0.0], [0.1, 0.2, 0.3], [30.0, 0.0, 0.0]], np.float32).T
    clamped = Clamp(direct=np.inf, indirect=1.0).applied(radiance, np.array([2, 2, 1]))
    expected = np.array([[2.0, 1.0, 0.0], [0.1, 0.2, 0.3], [30.0, 0.0, 0.0]]).T
    np.testing.assert_allclose(clamped, expected, rtol=1e-6)


def test_nothing_is_paid_when_it_is_off():
    assert clamp_of(settings()) is None
    assert clamp_of(settings(clamp_indirect=10.0)) == Clamp(np.inf, 10.0)


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_replay_is_clamped_too(mirrored):
    scene, how = seen_from_above(mirrored), settings(clamp_direct=0.5, clamp_indirect=0.25)
    again = replay(scene, how, 1, 2, 3)
    np.testing.assert_allclose(again.radiance, 0.25 if mirrored else 0.5, rtol=1e-5)
    parts = [event.contribution for event in again.events if event.contribution is not None]
    np.testing.assert_allclose(np.sum(parts, axis=0), again.radiance, rtol=1e-5)
