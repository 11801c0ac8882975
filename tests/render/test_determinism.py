"""The same seed gives the same bits, however the work is cut."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.rooms import GLASS, ROUGH, SOFT_LAMP, half_transparent, room

from pt_engine.render.replay import replay
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare

SKY = make.world((0.3, 0.4, 0.6))
SCENES = {
    "rough under an area lamp": room(ROUGH, SOFT_LAMP, SKY),
    "glass by a mesh light": room(GLASS),
    "veil": room(half_transparent(0.5), SOFT_LAMP, SKY),
}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("sampler", ["sobol", "independent"])
def test_chunks_threads_and_tiles_do_not_change_a_bit(name, sampler):
    images = [
        make.rendered(
            SCENES[name], (23, 17), samples=6, sampler=sampler, lanes=lanes, threads=threads
        ).image()
        for lanes, threads in ((1 << 16, 1), (400, 1), (97, 2), (23, 3))
    ]
    for image in images[1:]:
        np.testing.assert_array_equal(image, images[0])


@pytest.mark.parametrize("sampler", ["sobol", "independent"])
def test_two_halves_merge_to_the_film_of_one_run(sampler):
    snapshot = SCENES["glass by a mesh light"]
    whole = make.rendered(snapshot, 20, samples=13, sampler=sampler)
    first = make.rendered(snapshot, 20, samples=5, sampler=sampler)
    second = make.rendered(snapshot, 20, samples=8, first_sample=5, sampler=sampler)
    second.film.merge(first.film)
    np.testing.assert_array_equal(second.film.image(), whole.film.image())
    np.testing.assert_array_equal(second.film.variance_of_mean(), whole.film.variance_of_mean())


def test_another_seed_gives_other_noise_around_the_same_mean():
    snapshot = SCENES["rough under an area lamp"]
    a, b = (make.rendered(snapshot, 16, samples=4, seed=seed).image() for seed in (0, 2**31 - 1))
    assert (a != b).mean() > 0.5
    assert abs(a[..., :3].mean() - b[..., :3].mean()) < 0.1 * a[..., :3].mean()


def test_a_border_holds_the_same_samples_as_the_full_image():
    snapshot = SCENES["veil"]
    whole = make.rendered(snapshot, 24, samples=3).image()
    part = make.rendered(snapshot, 24, samples=3, border=(5, 3, 17, 20)).image()
    np.testing.assert_array_equal(part, whole[3:20, 5:17])


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("integrator", ["path", "path_active", "path_fixed", "direct_mis"])
def test_a_replayed_path_adds_up_to_what_the_film_received(name, integrator):
    """Each pixel-sample alone, bit for bit; and its recorded contributions sum to it."""
    settings = RenderSettings(12, 12, integrator=integrator, max_depth=5, samples=1, first_sample=7)
    snapshot = SCENES[name]
    image = make.rendered(
        snapshot,
        12,
        integrator=integrator,
        max_depth=5,
        samples=1,
        first_sample=7,
        sampler="sobol",
        pixel_filter="BLACKMAN_HARRIS",
        filter_width=1.5,
    ).image()
    scene = prepare(snapshot)
    for x, y in ((0, 0), (5, 6), (7, 5), (11, 3), (6, 9)):
        story = replay(scene, settings, x, y, 7)
        np.testing.assert_array_equal(story.radiance, image[y, x, :3])
        total = sum((e.contribution for e in story.events if e.contribution is not None), np.zeros(3))
        np.testing.assert_allclose(total, story.radiance, rtol=1e-5, atol=1e-9)
        assert any("radiance" in line for line in story.lines())
