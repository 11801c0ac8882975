"""Decoding: colour spaces, alpha, formats, and what is said of images that cannot be used."""

import numpy as np
import pytest

from pt_engine.scene.snapshot import ImageData
from pt_engine.textures import colorspace, images

oiio = pytest.importorskip("OpenImageIO")


def encoded(pixels, suffix, tmp_path, **settings):
    """An image file's bytes; `pixels` top row first."""
    path = str(tmp_path / f"image.{suffix}")
    height, width, channels = pixels.shape
    spec = oiio.ImageSpec(width, height, channels, "uint8" if pixels.dtype == np.uint8 else "float")
    if channels == 4:
        spec.attribute("oiio:UnassociatedAlpha", 1)
    out = oiio.ImageOutput.create(path)
    assert out.open(path, spec)
    out.write_image(np.ascontiguousarray(pixels))
    out.close()
    with open(path, "rb") as file:
        data = np.frombuffer(file.read(), np.uint8)
    return ImageData("test", encoded=data, suffix=f".{suffix}", **settings)


def sample(image, alpha_used=False, u=0.5, v=0.5):
    store = images.TextureStore([image])
    texture = store.texture(0, "Closest", "EXTEND", alpha_used)
    return texture.sample(np.array([u], np.float32), np.array([v], np.float32))


def srgb(c):
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


def test_srgb_bytes_are_linearised(tmp_path):
    image = encoded(np.full((1, 1, 3), (0, 128, 255), np.uint8), "png", tmp_path)
    color, alpha = sample(image)
    np.testing.assert_allclose(color[:, 0], [0, srgb(128 / 255), 1], atol=1e-6)
    assert alpha[0] == 1


def test_srgb_is_filtered_before_it_is_linearised(tmp_path):
    pixels = np.zeros((1, 2, 3), np.uint8)
    pixels[0, 1] = 200
    store = images.TextureStore([encoded(pixels, "png", tmp_path)])
    half = np.array([0.5], np.float32)
    color, _ = store.texture(0, "Linear", "EXTEND", False).sample(half, half)
    np.testing.assert_allclose(color[:, 0], srgb(100 / 255), atol=1e-6)


def test_data_stays_as_it_is(tmp_path):
    image = encoded(np.full((1, 1, 3), 128, np.uint8), "png", tmp_path, colorspace="Non-Color")
    np.testing.assert_allclose(sample(image)[0], 128 / 255, atol=1e-6)


def test_float_images_keep_their_range(tmp_path):
    pixels = np.full((1, 1, 3), (0.25, 7.5, 1e4), np.float32)
    image = encoded(pixels, "exr", tmp_path, colorspace="Linear Rec.709")
    np.testing.assert_allclose(sample(image)[0][:, 0], [0.25, 7.5, 1e4], rtol=1e-3)


def test_first_row_is_the_bottom(tmp_path):
    pixels = np.zeros((2, 1, 3), np.uint8)
    pixels[1] = 255  # the file's last row
    image = encoded(pixels, "png", tmp_path)
    assert sample(image, v=0.1)[0][0, 0] == pytest.approx(1)
    assert sample(image, v=0.9)[0][0, 0] == pytest.approx(0)


def test_straight_alpha_multiplies_colour_unless_alpha_is_used(tmp_path):
    pixels = np.full((1, 1, 4), (255, 255, 255, 51), np.uint8)
    image = encoded(pixels, "png", tmp_path, colorspace="Linear Rec.709")
    color, alpha = sample(image)
    np.testing.assert_allclose(color[:, 0], 0.2, atol=1e-6)
    color, alpha = sample(image, alpha_used=True)
    np.testing.assert_allclose(color[:, 0], 1, atol=1e-6)
    np.testing.assert_allclose(alpha, 0.2, atol=1e-6)


@pytest.mark.parametrize(
    ("mode", "color", "alpha"), [("CHANNEL_PACKED", 1, 0.2), ("NONE", 1, 1), ("PREMUL", 1, 0.2)]
)
def test_other_alpha_modes_leave_colour_alone(tmp_path, mode, color, alpha):
    pixels = np.full((1, 1, 4), (255, 255, 255, 51), np.uint8)
    image = encoded(pixels, "png", tmp_path, colorspace="Linear Rec.709", alpha_mode=mode)
    c, a = sample(image)
    np.testing.assert_allclose(c[:, 0], color, atol=1e-6)
    np.testing.assert_allclose(a, alpha, atol=1e-6)


def test_grey_images_become_rgb(tmp_path):
    image = encoded(np.full((1, 1, 1), 51, np.uint8), "png", tmp_path, colorspace="Non-Color")
    np.testing.assert_allclose(sample(image)[0], 0.2, atol=1e-6)


def test_a_named_space_goes_through_the_config(tmp_path):
    pixels = np.full((1, 1, 3), (0.5, 0.5, 0.5), np.float32)
    image = encoded(pixels, "exr", tmp_path, colorspace="ACEScg")
    color, _ = sample(image)
    np.testing.assert_allclose(color[:, 0], 0.5, rtol=2e-3)  # both spaces' white is neutral


@pytest.mark.parametrize("space", ["no such space", "ACES nonsense"])
def test_an_unknown_space_is_taken_as_linear_and_named(tmp_path, space):
    image = encoded(np.full((1, 1, 3), 0.5, np.float32), "exr", tmp_path, colorspace=space)
    color, _ = sample(image)
    np.testing.assert_allclose(color, 0.5, rtol=1e-3)
    (note,) = images.TextureStore([image]).texture(0, "Linear", "REPEAT", False).notes
    assert space in note
    assert "scene-linear" in note


@pytest.mark.parametrize(
    "image",
    [
        ImageData("gone", problem="no such file"),
        ImageData("broken", encoded=np.frombuffer(b"this is no image", np.uint8), suffix=".png"),
        ImageData("empty", encoded=np.zeros(0, np.uint8), suffix=".jpg"),
    ],
)
def test_unusable_images_say_why(image):
    with pytest.raises(images.ImageError, match=image.name):
        sample(image)


def test_a_damaged_file_is_told_in_one_line():
    """OpenImageIO's PNG reader says it twice, in two lines."""
    cut = np.frombuffer(b"\x89PNG\r\n\x1a\n", np.uint8)
    with pytest.raises(images.ImageError) as told:
        sample(ImageData("cut", encoded=cut, suffix=".png"))
    assert "\n" not in str(told.value)


def test_no_such_image():
    with pytest.raises(images.ImageError):
        images.TextureStore([]).texture(3, "Linear", "REPEAT", False)


def test_srgb_curve_is_continuous():
    c = np.array([0.04044, 0.04046, -1.0, 0.0, 1.0], np.float32)
    out = colorspace.srgb_to_linear(c)
    assert abs(out[1] - out[0]) < 1e-5
    np.testing.assert_allclose(out[2:], [0, 0, 1], atol=1e-6)


def test_nonfinite_pixels_become_black(tmp_path):
    pixels = np.full((1, 1, 4), (np.nan, 1, np.inf, 1), np.float32)
    color, alpha = sample(ImageData("hot", colorspace="Linear Rec.709", pixels=pixels))
    assert not color.any()
    assert alpha[0] == 0
