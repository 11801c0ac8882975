"""Estimators that are unbiased agree; those that cannot see a path are wrong in the way the lecture says."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_same_mean, mean_and_error
from support.rooms import GLASS, MIRROR, ROUGH, SOFT_LAMP, UP, half_transparent, room, rotation_x

from pt_engine.scene.snapshot import LightData

pytestmark = pytest.mark.slow  # physics that no Python changes


@pytest.mark.parametrize("material", [make.diffuse(0.7), ROUGH, GLASS], ids=lambda m: m.name)
@pytest.mark.parametrize("lamp", [None, SOFT_LAMP], ids=["mesh light", "area lamp"])
def test_three_strategies_agree_on_direct_light(material, lamp):
    """BSDF sampling, emitter sampling and MIS estimate the same image where there is no Dirac delta."""
    snapshot = room(material, lamp)
    results = {
        name: make.rendered(snapshot, 24, samples=96, integrator=name, seed=k)
        for k, name in enumerate(("direct_bsdf", "direct_emitter", "direct_mis"))
    }
    assert_same_mean(results["direct_bsdf"], results["direct_mis"])
    assert_same_mean(results["direct_emitter"], results["direct_mis"])


def test_three_strategies_agree_under_a_sky():
    snapshot = room(ROUGH, sky=make.world(0.5))
    a, b, c = (
        make.rendered(snapshot, 24, samples=96, integrator=name, seed=k)
        for k, name in enumerate(("direct_bsdf", "direct_emitter", "direct_mis"))
    )
    assert_same_mean(a, c)
    assert_same_mean(b, c)


def behind_leaves(lamp):
    """The room seen through a half-transparent leaf, and a second one between the lamp and the floor."""
    before = (make.quad(1.5), make.translation(0, -3, 1.5) @ rotation_x(np.pi / 2), half_transparent(0.6))
    above = (make.quad(1.2), make.translation(0.3, -0.2, 1.8), half_transparent(0.4))
    return room(ROUGH, lamp, more=[before, above])


@pytest.mark.parametrize("lamp", [None, SOFT_LAMP], ids=["mesh light", "area lamp"])
def test_three_strategies_agree_on_light_behind_transparent_leaves(lamp):
    """A leaf reflects or lets pass; behind it there is the one bounce, for passing is none."""
    results = [
        make.rendered(behind_leaves(lamp), 24, samples=96, integrator=name, seed=k)
        for k, name in enumerate(("direct_bsdf", "direct_emitter", "direct_mis"))
    ]
    assert_same_mean(results[0], results[2])
    assert_same_mean(results[1], results[2])


def test_three_strategies_see_light_through_clear_sheets():
    """L = τ⁴ ρ L_sky of a Lambert plane below two sheets: τ² toward the camera, τ² from the sky."""
    sheet = make.shader("BsdfTransparent", Color=make.rgba(0.6))
    objects = [(make.quad(400.0), UP, make.diffuse(0.8))]
    objects += [(make.quad(400.0), make.translation(0, 0, 0.01 * (k + 1)), sheet) for k in range(2)]
    snapshot = make.scene(objects, make.orthographic((0, 0, 2), (0, 0, 0), 0.1), sky=make.world(1.0))
    for name in ("direct_bsdf", "direct_emitter", "direct_mis"):
        mean, error = mean_and_error(make.rendered(snapshot, 12, samples=64, integrator=name))
        assert (np.abs(mean - 0.8 * 0.6**4) < 4.5 * error + 3e-4).all(), name  # sheets end: rays escape below


@pytest.mark.parametrize("make_scene", [lambda: room(GLASS, SOFT_LAMP), lambda: behind_leaves(None)])
def test_direct_light_by_mis_is_the_path_of_depth_two_bit_for_bit(make_scene):
    """The same random numbers make the same decisions; a path has no roulette here."""
    direct, path = (
        make.rendered(make_scene(), 16, samples=8, integrator=name, max_depth=2).image()
        for name in ("direct_mis", "path_active")
    )
    np.testing.assert_array_equal(direct, path)


def test_path_without_roulette_with_roulette_and_with_fixed_depth_agree():
    snapshot = room(ROUGH)
    a, b, c = (
        make.rendered(snapshot, 24, samples=96, integrator=name, seed=k, max_depth=6, rr_depth=2)
        for k, name in enumerate(("path", "path_active", "path_fixed"))
    )
    assert_same_mean(a, b)
    assert_same_mean(b, c)


def test_bsdf_sampling_cannot_see_a_point_light():
    """The lecture's first failure: f(x) ∝ δ needs p(x) ∝ δ."""
    snapshot = room(make.diffuse(0.7), LightData("POINT", "point", make.translation(0, -1, 3), 100.0))
    blind = make.rendered(snapshot, 16, samples=16, integrator="direct_bsdf")
    sees = make.rendered(snapshot, 16, samples=16, integrator="direct_mis")
    assert blind.image()[..., :3].max() == 0
    assert mean_and_error(sees)[0].min() > 0.01


def test_emitter_sampling_cannot_see_a_light_in_a_mirror():
    """The second: an ideal mirror reflects no sampled emitter; BSDF sampling and MIS see it."""
    floor_mirror = (make.quad(4.0), UP, MIRROR)
    lamp = (make.quad(1.0), make.translation(0, 0, 1.0), make.emission(5.0))
    snapshot = make.scene([floor_mirror, lamp], make.perspective((0.0, -0.15, 0.6), (0, 0, 0), 0.05))
    blind, bsdf, both = (
        make.rendered(snapshot, 8, samples=16, integrator=name)
        for name in ("direct_emitter", "direct_bsdf", "direct_mis")
    )
    assert blind.image()[..., :3].max() == 0
    np.testing.assert_allclose(bsdf.image()[..., :3], 0.9 * 5.0, rtol=1e-5)  # reflectance times Le, no noise
    np.testing.assert_allclose(both.image()[..., :3], 0.9 * 5.0, rtol=1e-5)


@pytest.mark.parametrize("layers", [1, 3])
def test_transparent_layers_dim_light_and_shadow_rays_alike(layers):
    """Clear sheets of transmittance τ over a plane under a sky, looked at through them:

    camera and light both pass τᵏ; BSDF sampling (escaping rays) and emitter sampling (shadow rays) agree.
    """
    tau = 0.6
    sheet = make.shader("BsdfTransparent", Color=make.rgba(tau))
    objects = [(make.quad(400.0), UP, make.diffuse(0.8))]
    objects += [(make.quad(400.0), make.translation(0, 0, 0.01 * (k + 1)), sheet) for k in range(layers)]
    snapshot = make.scene(objects, make.orthographic((0, 0, 2), (0, 0, 0), 0.1), sky=make.world(1.0))
    expected = 0.8 * tau ** (2 * layers)
    result = make.rendered(snapshot, 12, samples=128, max_depth=2, transparent_depth=8)
    mean, error = mean_and_error(result)
    # sheets end at 200: rays within 1e-4 of the horizon escape below them
    assert (np.abs(mean - expected) < 4.5 * error + 3e-4).all()


def test_partly_transparent_sheet_is_the_mix_of_its_parts():
    """L = τ L_sky + (1 − τ) ρ L_sky for a sheet in a furnace, by all estimators."""
    tau = 0.3
    snapshot = make.scene(
        [(make.quad(2.0), UP, half_transparent(tau))],
        make.orthographic((0, 0, 3), (0, 0, 0), 0.5),
        sky=make.world(1.0),
    )
    result = make.rendered(snapshot, 16, samples=256, max_depth=4)
    mean, error = mean_and_error(result)
    assert (np.abs(mean - (tau + (1 - tau) * 0.7)) < 4.5 * error + 1e-6).all()


def test_transparent_film_has_the_coverage_of_what_is_seen():
    """Alpha 0 beside the sheet, 1 − τ on it; the sky still lights it but is not in the picture."""
    tau = 0.3
    snapshot = make.scene(
        [(make.quad(2.0), UP, half_transparent(tau))],
        make.orthographic((0, 0, 3), (0, 0, 0), 4.0),
        sky=make.world(1.0),
    )
    image = make.rendered(snapshot, 16, samples=512, max_depth=4, film_transparent=True).image()
    inside = image[5:11, 5:11]
    assert np.abs(inside[..., 3] - (1 - tau)).max() < 5 * np.sqrt(0.21 / 512)
    assert abs(inside[..., :3].mean() - (1 - tau) * 0.7) < 0.01
    assert (image[0] == 0).all()
