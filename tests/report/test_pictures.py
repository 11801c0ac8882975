"""Two image files: errors by formula, FLIP, and the z-test where noise is known."""

from __future__ import annotations

import numpy as np
import OpenImageIO as oiio
import pytest

from pt_engine.report import optional as packages
from pt_engine.report.pictures import compare_files, lines, picture_of

RNG = np.random.default_rng(5)


def write(path, **layers):
    """A multi-layer EXR: (height, width, 3) each, named `ViewLayer.NAME.R` … ; `plain` has no layer."""
    names = [
        c if name == "plain" else f"ViewLayer.{name.replace('_', ' ')}.{c}" for name in layers for c in "RGB"
    ]
    values = np.concatenate(list(layers.values()), axis=2).astype(np.float32)
    spec = oiio.ImageSpec(values.shape[1], values.shape[0], values.shape[2], oiio.FLOAT)
    spec.channelnames = names
    out = oiio.ImageOutput.create(str(path))
    assert out.open(str(path), spec)
    assert out.write_image(np.ascontiguousarray(values))
    out.close()
    return path


def test_errors_are_their_formulas(tmp_path):
    """x = R + 0.1 on R = 0.5: MSE 0.01, relMSE 0.01 / (0.25 + 0.01 · 0.25)."""
    a = write(tmp_path / "a.exr", plain=np.full((8, 9, 3), 0.6))
    b = write(tmp_path / "b.exr", plain=np.full((8, 9, 3), 0.5))
    found = compare_files(a, b)
    assert found["mse"] == pytest.approx(0.01, rel=1e-5)
    assert found["relmse"] == pytest.approx(0.01 / 0.2525, rel=1e-5)
    assert found["z"] is None


def test_flip_of_equal_images_is_zero_and_grows_with_the_difference(tmp_path):
    values = RNG.uniform(0, 1, (32, 32, 3))
    a = write(tmp_path / "a.exr", plain=values)
    near = write(tmp_path / "n.exr", plain=values * 1.02)
    far = write(tmp_path / "f.exr", plain=values * 1.5)
    flips = [compare_files(x, a)["flip"] for x in (a, near, far)]
    assert flips[0] == pytest.approx(0, abs=1e-6)
    assert 0 < flips[1] < flips[2] < 1


@pytest.mark.parametrize(("shift", "differs"), [(0.0, False), (0.05, True)])
def test_z_test_uses_the_standard_errors(tmp_path, shift, differs):
    """Noise of 0.1 a pixel on 1024 pixels: the mean is known to 0.003, so 0.05 is 11 standard errors."""
    sigma = np.full((32, 32, 3), 0.1)
    noise = [np.repeat(RNG.normal(0, 0.1, (32, 32, 1)), 3, axis=2) for _ in range(2)]
    a = write(tmp_path / "a.exr", Combined=0.5 + shift + noise[0], Standard_Error=sigma)
    b = write(tmp_path / "b.exr", Combined=0.5 + noise[1], Standard_Error=sigma)
    found = compare_files(a, b)
    assert (found["p"] < 1e-3) is differs
    assert ("more than noise" in "\n".join(lines(found))) is differs


def test_standard_errors_of_single_samples_know_nothing(tmp_path):
    """Blender's passes have 0 where nothing is known: with noise of 0 any difference were beyond it."""
    images = [RNG.uniform(0, 1, (16, 16, 3)) for _ in range(2)]
    zero = np.zeros((16, 16, 3))
    a, b = (
        write(tmp_path / f"{k}.exr", Combined=image, Standard_Error=zero) for k, image in enumerate(images)
    )
    assert compare_files(a, b)["z"] is None


def test_pixels_whose_noise_nobody_knows_have_no_say(tmp_path):
    """A pass of one sample is NaN: no test where all are, and none of the others' certainty is theirs."""
    values = np.full((32, 32, 3), 0.5)
    sigma = np.full_like(values, 0.1)
    one = write(tmp_path / "one.exr", Combined=values + 1, Standard_Error=sigma * np.nan)
    plain = write(tmp_path / "b.exr", plain=values)
    found = compare_files(one, plain)
    assert found["z"] is None
    assert "that knows it" in "\n".join(lines(found))
    sigma[:8] = np.inf
    values = values + np.repeat(RNG.normal(0, 0.1, (32, 32, 1)), 3, axis=2)
    values[:8] += 10
    some = write(tmp_path / "some.exr", Combined=values, Standard_Error=sigma)
    assert compare_files(some, plain)["p"] > 1e-3


def test_without_flip_evaluator_a_line_says_how_to_get_it(tmp_path, monkeypatch):
    a = write(tmp_path / "a.exr", plain=np.ones((8, 8, 3)))

    def missing(name):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(packages.importlib, "import_module", missing)
    found = compare_files(a, a)
    assert found["flip"] is None
    assert "pip install flip-evaluator" in "\n".join(lines(found))


def test_files_that_do_not_compare_say_why(tmp_path):
    a = write(tmp_path / "a.exr", plain=np.ones((8, 8, 3)))
    b = write(tmp_path / "b.exr", plain=np.ones((8, 9, 3)))
    with pytest.raises(ValueError, match="9x8"):
        compare_files(a, b)
    (tmp_path / "c.exr").write_text("no image")
    with pytest.raises(ValueError, match=r"c\.exr can't be read"):
        compare_files(a, tmp_path / "c.exr")
    hole = np.ones((8, 8, 3))
    hole[1, 2] = np.nan
    with pytest.raises(ValueError, match="1 pixel with numbers that are not finite"):
        picture_of(write(tmp_path / "d.exr", plain=hole))
