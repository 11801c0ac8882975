"""A sky texture's sun is sampled on its own, and found by rays with the same density."""

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_same_mean, mean_and_error
from support.rooms import ROUGH, room

from pt_engine.core.view import View
from pt_engine.nodes.world import compile_world
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, Link, Node
from pt_engine.scene.world_light import environment

HALF_DEGREE = 0.009512


def sky(size, tilt=0.0, **settings):
    """A world of one Sky Texture; `tilt` turns it about X by its old texture mapping."""
    props = {"sky_type": "SINGLE_SCATTERING", "sun_elevation": 0.7, "sun_rotation": 2.0, "sun_size": size}
    if tilt:
        axes = (("mapping_x", "X"), ("mapping_y", "Y"), ("mapping_z", "Z"))
        props["texture_mapping"] = (("rotation", (tilt, 0.0, 0.0)), *axes)
    nodes = (
        Node("TexSky", "sky", {}, props | settings),
        Node("Background", "background", {"Color": Link(0, "Color"), "Strength": 0.1}),
    )
    return Graph("sky", nodes, {"Surface": Link(1, "Background")})


@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_three_strategies_agree_under_a_sun(tilt):
    """A wide sun, which BSDF sampling finds too."""
    snapshot = room(ROUGH, sky=sky(0.6, tilt))
    a, b, c = (
        make.rendered(snapshot, 24, samples=96, integrator=name, seed=k)
        for k, name in enumerate(("direct_bsdf", "direct_emitter", "direct_mis"))
    )
    assert_same_mean(a, c)
    assert_same_mean(b, c)


def test_emitters_alone_find_the_dark_part_of_a_sky_too():
    """Only estimators that combine may leave what is darker than the mean to BSDF sampling."""
    snapshot = make.scene(
        [(make.quad(9.0), np.eye(4), make.diffuse(0.8))],
        make.orthographic((0, 0, 3), (0, 0, 0), 1.0),
        sky=sky(0.6, sun_disc=False),
    )
    a, b = (
        make.rendered(snapshot, 8, samples=256, integrator=name, seed=k)
        for k, name in enumerate(("direct_bsdf", "direct_emitter"))
    )
    assert_same_mean(a, b)


def test_a_small_sun_costs_no_noise():
    """A sample of the light on an open floor deviates by less than its mean: sun or sky, and what of it.

    From a map of 512 rows, in which the sun is a fifth of a texel, it would be several times that.
    """
    snapshot = make.scene(
        [(make.quad(100.0), make.translation(0, 0, 0), make.diffuse(0.8))],
        make.perspective((0, -3, 3), (0, 0, 0), 0.5),
        sky=sky(HALF_DEGREE),
    )
    mean, error = mean_and_error(make.rendered(snapshot, 4, samples=256, integrator="direct_mis"))
    assert (error * np.sqrt(16 * 256) < mean).all()


def test_the_suns_irradiance_on_a_plane():
    """E = π sin²α·cosθ · mean L, L by a quadrature of the disc; the sky without its sun by its own map."""
    world = compile_world(sky(HALF_DEGREE))
    with_sun, without = environment(world, View()), environment(world.without_suns, View())
    (sun,) = world.suns
    rng = np.random.default_rng(0)

    def estimate(e, n=200_000):
        d, pdf = e.sample(*rng.random((2, n), np.float32))
        value = (e.radiance(d)[1] * np.maximum(d[2], 0) / pdf).astype(np.float64)
        return value.mean(), value.std() / np.sqrt(n)

    r = (np.arange(2000) + 0.5) / 2000  # equal-width rings of the disc, cut through by a vertical line
    total, error = estimate(with_sun)
    background, more = estimate(without)
    made = world._batch is not None and sun.half_angle == pytest.approx(HALF_DEGREE / 2)
    assert made
    up = np.array([0.0, 0.0, 1.0])
    side = np.cross(sun.toward, up)
    side /= np.sqrt((side * side).sum())
    d = [np.cos(sun.half_angle * x) * sun.toward + np.sin(sun.half_angle * x) * side for x in r]
    lanes = np.stack(d, axis=1).astype(np.float32)  # at the height of its centre: limb darkening alone
    profile = with_sun.radiance(lanes)[1].astype(np.float64)
    disc = 2 * np.pi * sun.half_angle**2 * (profile * r).mean() * sun.toward[2]
    assert total - background == pytest.approx(disc, rel=4.5 * np.hypot(error, more) / disc + 2e-3)


def test_a_sun_behind_the_horizon_is_no_light():
    world = compile_world(sky(HALF_DEGREE, sun_elevation=-0.2))
    assert len(world.suns) == 1
    assert type(environment(world, View())).__name__ == "EnvironmentMap"


def test_a_scene_knows_its_sun_once():
    """The map that directions are drawn from has no sun in it: the same one with the disc switched off."""
    scene = prepare(room(ROUGH, sky=sky(HALF_DEGREE)))
    plain = prepare(room(ROUGH, sky=sky(HALF_DEGREE, sun_disc=False)))
    d = np.random.default_rng(2).normal(size=(3, 1000)).astype(np.float32)
    d /= np.sqrt((d * d).sum(axis=0))
    mixed, alone = scene.lights.environment_pdf(d), plain.lights.environment_pdf(d)
    share = mixed.max() / alone.max()
    assert 0 < share < 0.9
    np.testing.assert_allclose(mixed, share * alone, rtol=1e-5)
