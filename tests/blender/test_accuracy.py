"""The error in Blender: passes in a multilayer EXR, target error, what the panel and the status say."""

import bpy
import numpy as np
import pytest
from support.engine_scene import HEIGHT, WIDTH, engine_scene, exr
from support.exr import channels_of

from pt_engine.blender import accuracy_panel, words
from pt_engine.blender.record import Session
from pt_engine.render.forecast import Prediction


def layers(path):
    """Channel name without the view layer → (height, width)."""
    return {name.split(".", 1)[-1]: values for name, values in channels_of(path).items()}


def test_passes_come_in_the_multilayer_file(tmp_path):
    """Standard Error above 0 where there is light; counts; (A + B) / 2 is the image of 8 samples."""
    scene = engine_scene(samples=8)
    own = scene.view_layers[0].pt_engine
    own.use_pass_standard_error = own.use_pass_sample_count = own.use_pass_halves = True
    exr(scene, tmp_path / "a.exr", multilayer=True)
    bpy.ops.render.render(write_still=True)
    found = layers(tmp_path / "a.exr")
    assert found["Sample Count.X"].shape == (HEIGHT, WIDTH)
    assert (found["Sample Count.X"] == 8).all()
    for c in "RGB":
        mean = 0.5 * (found[f"Half A.{c}"] + found[f"Half B.{c}"])
        np.testing.assert_allclose(mean, found[f"Combined.{c}"], rtol=1e-5, atol=1e-6)
        assert (found[f"Standard Error.{c}"] >= 0).all()
        assert (found[f"Standard Error.{c}"] > 0).mean() > 0.2


def test_without_them_there_is_only_the_picture(tmp_path):
    scene = engine_scene()
    exr(scene, tmp_path / "a.exr", multilayer=True)
    bpy.ops.render.render(write_still=True)
    assert {name.rsplit(".", 1)[0] for name in layers(tmp_path / "a.exr")} == {"Combined"}


@pytest.mark.parametrize("kind", ["IMAGE", "PIXELS"])
def test_a_target_error_ends_the_render(kind):
    scene = engine_scene(samples=0)
    own = scene.pt_engine
    own.target_error, own.target_of, own.target_percentile = 0.1, kind, 90
    bpy.ops.render.render()
    stats = Session.last.statistics()
    assert stats["stopped_by"] == "target"
    assert stats["samples"] >= own.min_samples
    assert stats["prediction"]["target"] == pytest.approx(0.1)
    assert words.error_lines(stats)[1].endswith("the target error is reached")
    assert accuracy_panel.SECTIONS


def test_a_prediction_in_words():
    found = Prediction(0.01, 190.0, (170.0, 220.0), 400.0, (360.0, 440.0), 40.0, None)
    assert words.prediction(found) == "reaches 1 % in 3:10 (2:50 to 3:40)"
