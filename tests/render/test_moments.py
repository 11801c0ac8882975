"""Which moment a sample sees is its own affair: no thread, tile, range, window or replay changes it."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.motion import moving

from pt_engine.core.samplers import SAMPLERS
from pt_engine.render import moments
from pt_engine.render.moments import LONGEST_RUN, Kept, Moments
from pt_engine.render.progressive import render
from pt_engine.render.replay import replay
from pt_engine.render.schedule import morton_order, units
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare

SETTINGS = RenderSettings(23, 17, samples=6, threads=1, max_depth=4, sampler="sobol")


def snapshot(rings=2):
    """A ball flies over a floor under a grey sky, and the camera turns after it."""
    camera = make.perspective((0, -5, 2), (0, 0, 0.5), 0.5)
    cameras = [replace(camera, matrix=make.looking((0, -5, 2), (x, 0, 0.5))) for x in (-0.3, 0.3)]
    floor = make.quad(8.0), np.eye(4), make.diffuse(0.5, "floor")
    ball = make.sphere(0.6, rings), make.translation(0, 0, 1), make.diffuse((0.9, 0.3, 0.1), "ball")
    made = make.scene([ball, floor], camera, sky=make.world((0.3, 0.4, 0.5)))
    return moving(made, {0: [make.translation(x, 0, 1 + x / 3) for x in (-1.5, 0, 1.5)]}, cameras=cameras)


@pytest.fixture(params=["one moment a sample", "crowds", "runs"], name="scene")
def fixture_scene(request, monkeypatch):
    """The three ways to share moments: what moves is small, very small for the image, or large."""
    if request.param == "crowds":
        monkeypatch.setattr(moments, "FEWEST_LANES", 50)
    made = prepare(snapshot(rings=16 if request.param == "runs" else 2))
    found = Moments(made.slices, SETTINGS, SAMPLERS["sobol"](0), lambda scene: scene)
    expected = {"one moment a sample": (1, 1), "crowds": (4, 1), "runs": (1, 4)}
    assert (found.crowds, found.run) == expected[request.param]
    return made


def test_threads_and_tiles_do_not_change_a_bit(scene):
    cuts = [{}, {"threads": 3}, {"lanes": 97}, {"lanes": 23, "threads": 2}]
    images = [render(scene, replace(SETTINGS, **cut)).image() for cut in cuts]
    for image in images[1:]:
        np.testing.assert_array_equal(image, images[0])


def test_ranges_of_samples_merge_to_the_film_of_one_run(scene):
    whole = render(scene, SETTINGS)
    first = render(scene, replace(SETTINGS, samples=3))
    second = render(scene, replace(SETTINGS, samples=3, first_sample=3))
    second.film.merge(first.film)
    np.testing.assert_array_equal(second.film.image(), whole.film.image())
    np.testing.assert_array_equal(second.film.variance_of_mean(), whole.film.variance_of_mean())


def test_a_window_sees_the_same_moments(scene):
    whole = render(scene, SETTINGS).image()
    part = render(scene, replace(SETTINGS, border=(5, 3, 17, 14))).image()
    np.testing.assert_array_equal(part, whole[3:14, 5:17])


def test_units_that_mix_moments_give_the_same_numbers(scene):
    """Whatever a unit holds, its parts see their own moments."""
    worker_settings = replace(SETTINGS, samples=LONGEST_RUN)
    from pt_engine.render.integrator import INTEGRATORS
    from pt_engine.render.worker import Worker

    worker = Worker(scene, worker_settings, INTEGRATORS["path"](worker_settings), SAMPLERS["sobol"](0))
    mixed = list(units(worker_settings, morton_order(23, 17)))[-1]
    assert mixed.spp > 1
    both = worker.render(mixed).radiance.reshape(3, mixed.spp, -1)
    for k in range(mixed.spp):
        alone = worker.render(mixed._replace(first=mixed.first + k, spp=1))
        np.testing.assert_array_equal(both[:, k], alone.radiance)


def test_the_films_halves_never_see_the_same_moment(scene):
    """Even samples are A, odd ones B; where a moment serves several samples, all are of one half."""
    settings = replace(SETTINGS, samples=32)
    found = Moments(scene.slices, settings, SAMPLERS["sobol"](0), lambda scene: scene)
    seen = defaultdict(list)
    for unit in units(settings, morton_order(23, 17), split=found.groups, aligned=found.block):
        for part in found.parts(unit):
            samples = range(unit.first, unit.first + unit.spp)[part.rows]
            assert list(samples) == [part.unit.first + k * part.unit.step for k in range(part.unit.spp)]
            seen[part.moment].extend(samples)
    halves = {moment: {sample % 2 for sample in samples} for moment, samples in seen.items()}
    assert all(len(half) == 1 for half in halves.values())
    assert all(len(set(samples)) == found.run for samples in seen.values())


def test_a_replay_walks_the_same_path_at_the_same_time(scene):
    pixels = [(11, 9), (6, 8), (3, 12)]
    stories = [[replay(scene, SETTINGS, x, y, sample) for sample in range(6)] for x, y in pixels]
    image = render(scene, SETTINGS).image()
    for (x, y), story in zip(pixels, stories, strict=True):
        mean = np.mean([one.radiance.astype(np.float64) for one in story], axis=0)
        np.testing.assert_allclose(mean, image[y, x, :3], rtol=1e-6)  # the image is float32
    times = {one.events[0].numbers["time"] for one in stories[0]}
    assert all(0 <= time <= 1 for time in times)
    assert len(times) == (2 if scene.slices.triangles > 100 else 6)


def test_another_seed_has_other_times():
    scene = prepare(snapshot())
    a, b = (
        replay(scene, replace(SETTINGS, seed=seed), 11, 9, 0).events[0].numbers["time"] for seed in (0, 1)
    )
    assert a != b


def test_crowds_have_times_of_their_own_and_fill_the_shutter(monkeypatch):
    """Of 8 runs of 16 crowds, the even and the odd four have each crowd once in every quarter of the time."""
    monkeypatch.setattr(moments, "FEWEST_LANES", 1)
    scene = prepare(snapshot())
    found = Moments(
        scene.slices, replace(SETTINGS, width=640, height=480), SAMPLERS["sobol"](3), lambda scene: scene
    )
    assert found.crowds == 16
    times = np.array([[found.scene(moments.Moment(c, r)).time for r in range(8)] for c in range(16)])
    for half in (times[:, ::2], times[:, 1::2]):  # two sequences: see `core.samplers.Sobol`
        assert (np.sort((half * 4).astype(int), axis=1) == np.arange(4)).all()
    assert len(np.unique(times)) == times.size


def test_a_render_of_moving_things_can_be_stopped():
    asked = []
    result = render(
        prepare(snapshot()),
        replace(SETTINGS, samples=0),
        should_stop=lambda: len(asked) > 3 or asked.append(0),
    )
    assert result.cancelled
    assert 0 < result.progress.samples < 20


def test_what_is_kept_is_made_once_and_a_failure_reaches_everyone():
    kept, made = Kept(2), []
    for key in (1, 2, 1, 2, 3, 2, 1):
        assert kept.get(key, lambda key=key: made.append(key) or key) == key
    assert made == [1, 2, 3, 1]  # 1 is the oldest when 3 comes
    with pytest.raises(ZeroDivisionError):
        kept.get(7, lambda: 1 / 0)
