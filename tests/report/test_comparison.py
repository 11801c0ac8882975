"""Estimators side by side: slopes, bias, blind spots, and which of them pays."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.image_files import write
from support.motion import moving
from support.rooms import MIRROR, room

from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.report.comparison import compare
from pt_engine.report.contenders import by_power
from pt_engine.report.errors import Bias, Picture, least_known, squared_error
from pt_engine.report.reference import Reference, cache_file, given, made
from pt_engine.report.tables import comparison_lines
from pt_engine.report.verdict import verdict
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import LightData, Visibility

pytestmark = pytest.mark.slow  # some ten seconds of rendering

SETTINGS = RenderSettings(24, 24, threads=1, max_depth=3, sampler="independent", pixel_filter="BOX")
WORDS = ("direct", "path_fixed", "sampler", "depth 2")


@pytest.fixture(scope="module")
def compared():
    """A room with a mirror ball under a glowing square."""
    snapshot = room(MIRROR)
    scene = prepare(snapshot)
    reference = made(scene, SETTINGS, wanted=0.05, seconds=6)
    return compare(scene, SETTINGS, reference, seconds=0.25, seeds=3, only=WORDS)


def row(result, name):
    return next(row for row in result["rows"] if row["name"] == name)


def test_independent_samples_converge_as_one_over_n(compared):
    """MSE ∝ 1/n; the fit of few doublings in a scene with rare bright paths is good to some tenths."""
    assert row(compared, "as set")["slope"]["value"] == pytest.approx(-1, abs=0.3)


def test_whole_estimators_are_unbiased_and_say_nothing(compared):
    for name in ("as set", "path_fixed", "sampler sobol"):
        assert row(compared, name)["bias"]["p"] > 1e-4
        assert row(compared, name)["verdict"] == ""


def test_emitter_sampling_misses_the_mirror(compared):
    told = row(compared, "direct_emitter")["verdict"]
    assert "emitter sampling misses the mirror" in told
    assert "one bounce misses indirect light" in told
    assert "% energy, biased" in told
    assert row(compared, "direct_emitter")["bias"]["relative"] < 0


def test_short_paths_are_biased(compared):
    assert row(compared, "depth 2")["verdict"].startswith("depth 2 misses longer paths: \N{MINUS SIGN}")


def test_mis_beats_bsdf_sampling_of_a_small_light():
    """By a factor of 2.0 to 2.1, measured with 144 to 1136 samples a pixel.

    One bounce is all the light there is, so both are unbiased and the ratio is the same after any time.
    """
    scene, settings = prepare(room(make.diffuse(0.5))), replace(SETTINGS, max_depth=2)
    reference = made(scene, settings, wanted=0.01, seconds=2)
    result = compare(scene, settings, reference, 0.1, 3, ("direct_bsdf", "direct_mis"))
    errors = [row(result, n)["mse_at_equal_samples"]["value"] for n in ("direct_bsdf", "direct_mis")]
    assert errors[0] > 1.5 * errors[1]


def under_many_lamps():
    """A floor and lamps enough for a choice by place."""
    lamps = [LightData("POINT", f"{k}", make.translation(k - 6, 0, 1.5), 10.0) for k in range(12)]
    camera = make.orthographic((0, 0, 3), (0, 0, 0), 12.0)
    return make.scene([(make.quad(12), np.eye(4), make.diffuse(0.5))], camera, lamps)


def test_lights_are_chosen_by_power_at_every_moment_of_a_moving_scene():
    """What moves is a camera that gets nowhere: the samples are those of the scene which stands still."""
    still = under_many_lamps()
    moved = prepare(moving(still, cameras=(still.camera, still.camera)))
    assert moved.lights.by_place is not None
    settings = replace(SETTINGS, samples=4)
    one, other = (render(by_power(scene), settings).image() for scene in (moved, prepare(still)))
    np.testing.assert_array_equal(one, other)


def test_lights_that_catchers_alone_see_are_chosen_by_power_too():
    scene = prepare(catching(under_many_lamps()))
    assert scene.alone.lights.by_place is not None
    plain = by_power(scene)
    assert plain.alone.lights.by_place is None
    assert scene.alone.lights.by_place is not None


def test_runs_that_are_over_at_once_do_not_call_noise_a_bias():
    """A single sample knows nothing of its noise: each run has two, however little time there is."""
    settings = replace(SETTINGS, sampler="sobol", width=64, height=48)
    lamp = LightData("POINT", "point", make.translation(0.5, -0.5, 2.5), 60.0)
    scene = prepare(room(make.diffuse(0.5), lamp))
    reference = made(scene, settings, wanted=0.02, seconds=3)
    result = compare(scene, settings, reference, seconds=1e-6, seeds=1, only=("path_fixed",))
    for each in result["rows"]:
        assert each["samples"] == 2
        assert each["bias"]["p"] > 1e-4


def test_an_error_of_nothing_is_told_as_nothing():
    """An empty scene under an even sky has no noise at all."""
    scene = prepare(make.scene([], make.perspective((0, 0, 0), (0, 1, 0)), [], make.world(0.5)))
    reference = made(scene, SETTINGS, wanted=0.1, seconds=1)
    result = compare(scene, SETTINGS, reference, seconds=1e-3, seeds=2, only=("path_fixed", "adaptive"))
    told = comparison_lines(result)
    assert told[-3].split()[-7:-3] == ["0", "0", "1.00", "x"]  # as set: by definition
    assert [line.split()[-6:-3] for line in told[-2:]] == [["0", "0", "?"]] * 2


def test_the_least_known_error_is_what_a_references_noise_makes_of_none():
    """The truth measured against 400 noisy references: |MSE| exceeds it with a chance of 5 %."""
    rng = np.random.default_rng(3)
    variance = np.exp(rng.normal(0, 1.0, (24, 24, 1))) * np.ones(3)
    noise = np.sqrt(variance) * rng.normal(size=(400, 24, 24, 1))  # channels share it
    references = [Picture(each, variance) for each in noise]
    found = [float(squared_error(np.zeros((24, 24, 3)), each).mean()) for each in references]
    beyond = np.abs(found) > least_known(references[0])
    assert 0.02 < beyond.mean() < 0.09


def test_rounds_go_there_and_back_and_what_is_complete_counts():
    """A machine that gets slower favours nobody; who stops the third run of five has two."""
    scene, settings = prepare(room(make.diffuse(0.5))), replace(SETTINGS, width=8, height=8)
    reference, told = made(scene, settings, wanted=1.0, seconds=1), []
    words = {"seconds": 1e-3, "seeds": 2, "only": ("path_",), "tell": told.append}
    whole = compare(scene, settings, reference, **words)
    assert told == [f"1/2 {name}" for name in ("as set", "path_fixed", "path_active")] + [
        f"2/2 {name}" for name in ("path_active", "path_fixed", "as set")
    ]
    assert whole["complete"]
    told.clear()
    part = compare(scene, settings, reference, **words, should_stop=lambda: len(told) > 4)
    assert not part["complete"]
    assert [(row["name"], row["runs"]) for row in part["rows"]] == [
        ("as set", 1),
        ("path_fixed", 1),
        ("path_active", 2),
    ]
    told.clear()
    assert compare(scene, settings, reference, **words, should_stop=lambda: True)["rows"] == []


def test_what_the_settings_as_set_show_as_well_is_nobodys_blind_spot():
    """A reference 2 % too bright: a depth that misses next to nothing is not called blind, one bounce is."""
    scene, settings = prepare(room(make.diffuse(0.5))), replace(SETTINGS, max_depth=9)
    true = made(scene, settings, wanted=0.02, seconds=3)
    picture = Picture(1.02 * true.picture.mean, true.picture.variance)
    reference = Reference(picture, "too bright", true.error)
    result = compare(scene, settings, reference, 0.3, 2, ("depth 8", "direct_mis"))
    assert row(result, "as set")["verdict"].startswith("differs from the reference")
    assert row(result, "depth 8")["verdict"].startswith("differs as the settings as set do: ")
    assert row(result, "direct_mis")["verdict"].startswith("one bounce misses indirect light")


def test_pixels_of_a_moving_scene_share_moments_and_z_does_not_know():
    still = room(make.diffuse(0.5))
    scene = prepare(moving(still, {0: [np.eye(4), make.translation(0, 0, 0.1)]}))
    told = verdict(scene, SETTINGS, SETTINGS.max_depth, Bias(-0.002, -7.0, -13.0, 1e-40))
    assert "moments of the shutter, which pixels share" in told


def catching(snapshot):
    """The same, its first object a shadow catcher."""
    visibility = snapshot.instances.visibility.copy()
    visibility[0] |= Visibility.CATCHER
    return replace(snapshot, instances=replace(snapshot.instances, visibility=visibility))


def test_shadow_catchers_are_compared_by_the_light_of_the_whole_scene():
    """Their picture is made of several films, a merged reference is one: all must mean the same."""
    scene = prepare(catching(room(make.diffuse(0.5), sky=make.world(0.5))))
    assert scene.has_catchers
    reference = made(scene, SETTINGS, wanted=0.05, seconds=3)
    result = compare(scene, SETTINGS, reference, 0.2, 2, ("path_fixed",))
    assert [each["name"] for each in result["rows"]] == ["as set", "path_fixed"]
    for each in result["rows"]:
        assert each["verdict"] == ""
        assert abs(each["bias"]["relative"]) < 0.1


def test_what_is_not_known_to_be_blind_may_be_unlucky():
    """z of the mean may be small where a part of the image is far off: the sentence says which."""
    scene = prepare(room(make.diffuse(0.5)))
    told = verdict(scene, SETTINGS, SETTINGS.max_depth, Bias(-0.02, -0.1, -15.4, 1e-40))
    assert "rare bright samples are yet to come" in told
    assert "15.4 in a part of the image" in told
    blind = replace(SETTINGS, max_depth=2)
    assert verdict(scene, blind, 3, Bias(-0.2, -20.0, -9.0, 1e-40)).endswith(
        "depth 2 misses longer paths: -20.0% energy, biased (z = -20.0)".replace("-", "\N{MINUS SIGN}")
    )


def test_lamps_without_a_size_are_invisible_to_bsdf_sampling():
    lamp = LightData("POINT", "point", make.translation(0.5, -0.5, 2.5), 60.0)
    scene = prepare(room(make.diffuse(0.5), lamp))
    reference = made(scene, SETTINGS, wanted=0.1, seconds=3)
    result = compare(scene, SETTINGS, reference, seconds=0.05, seeds=2, only=("direct_bsdf",))
    told = row(result, "direct_bsdf")
    assert "BSDF sampling cannot hit lamps without a size" in told["verdict"]
    assert told["bias"]["relative"] == pytest.approx(-1)


def test_the_table_has_a_line_for_each_and_json_bears_it(compared):
    lines = comparison_lines(compared)
    assert sum(line.startswith("as set") for line in lines) == 1
    assert any(line.startswith("direct_emitter: emitter sampling misses") for line in lines)
    json.dumps(compared, allow_nan=True)


def test_a_kept_reference_is_continued_exactly(tmp_path):
    """16 samples in two goes are the film of one go, bit for bit; and a better one is not made again."""
    scene = prepare(room(make.diffuse(0.5)))
    path = tmp_path / "kept" / "film.npz"
    first = made(scene, SETTINGS, wanted=10.0, seconds=60, cache=path)
    again = made(scene, SETTINGS, wanted=0.9 * first.error, seconds=60, cache=path)
    assert "continued" in again.origin
    whole = made(scene, SETTINGS, wanted=0.9 * first.error, seconds=60)
    np.testing.assert_array_equal(again.picture.mean, whole.picture.mean)
    idle = made(scene, SETTINGS, wanted=1.0, seconds=60, cache=path)
    np.testing.assert_array_equal(idle.picture.mean, again.picture.mean)


def test_another_scene_has_another_kept_file():
    a, b = room(make.diffuse(0.5)), room(make.diffuse(0.4))
    assert cache_file(a, SETTINGS) == cache_file(a, SETTINGS)
    assert cache_file(a, SETTINGS) != cache_file(b, SETTINGS)


def test_a_reference_of_another_size_is_refused(tmp_path):
    path = tmp_path / "r.exr"
    write(path, np.ones((4, 6, 3), np.float32), "float")
    assert isinstance(given(path, 6, 4), Reference)
    with pytest.raises(ValueError, match="6x4 pixels, the render 8x4"):
        given(path, 8, 4)
