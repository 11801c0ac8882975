"""Image lookups on tiny images, against values computed by hand."""

import numpy as np
import pytest

from pt_engine.textures import environment, lookup
from pt_engine.textures.texels import Whole


def grid(extension, form="float32"):
    """A 3×2 image: red is the column, green the row, both in 255ths; bottom row first."""
    rgba = np.zeros((2, 3, 4), np.float32)
    rgba[..., 0], rgba[..., 1], rgba[..., 3] = np.arange(3), np.arange(2)[:, None], 254  # not quite opaque
    scale = {"uint8": 1, "uint16": 257}.get(form, 1 / 255)
    return lookup.Grid(Whole.of((rgba * np.float32(scale)).astype(form)), extension)


FORMATS = ["uint8", "uint16", "float16", "float32"]


def red(found):
    """Columns, and rows, of (4, n) texels."""
    values, _ = found
    return values[0] * 255, values[1] * 255


def at(*u):
    return np.array(u, np.float32)


@pytest.mark.parametrize("form", FORMATS)
def test_closest_takes_the_texel_that_holds_the_point(form):
    column, row = red(grid(lookup.EXTEND, form).closest(at(0.1, 0.4, 0.9), at(0.2, 0.49, 0.51)))
    np.testing.assert_allclose(column, [0, 1, 2], atol=1e-4)
    np.testing.assert_allclose(row, [0, 0, 1], atol=1e-4)


@pytest.mark.parametrize("form", FORMATS)
def test_linear_is_exact_at_centres_and_halfway(form):
    u = at(0.5 / 3, 1 / 3, 0.5, 2 / 3)
    column, _ = red(grid(lookup.EXTEND, form).linear(u, np.full(4, 0.25, np.float32)))
    np.testing.assert_allclose(column, [0, 0.5, 1, 1.5], atol=1e-4)
    _, row = red(grid(lookup.EXTEND, form).linear(at(0.5, 0.5, 0.5), at(0.25, 0.5, 0.75)))
    np.testing.assert_allclose(row, [0, 0.5, 1], atol=1e-4)


@pytest.mark.parametrize(
    ("extension", "expected"),
    [
        # u = −0.5/3, 0, 1, 1 + 0.5/3: one texel before the first centre, the edges, one after the last
        (lookup.REPEAT, [2, 1, 1, 0]),
        (lookup.EXTEND, [0, 0, 2, 2]),
        (lookup.MIRROR, [0, 0, 2, 2]),
        (lookup.CLIP, [0, 0, 1, 0]),
    ],
)
def test_extension_past_the_edges(extension, expected):
    u = at(-0.5 / 3, 0, 1, 1 + 0.5 / 3)
    column, _ = red(grid(extension).linear(u, np.full(4, 0.25, np.float32)))
    np.testing.assert_allclose(column, expected, atol=1e-4)


def test_mirror_and_repeat_far_away():
    u = np.full(1, 0.25, np.float32)
    v = np.full(1, 0.25, np.float32)
    repeat, mirror = grid(lookup.REPEAT), grid(lookup.MIRROR)
    np.testing.assert_allclose(repeat.linear(u + 7, v)[0], repeat.linear(u, v)[0], atol=1e-6)
    np.testing.assert_allclose(mirror.linear(u + 2, v)[0], mirror.linear(u, v)[0], atol=1e-6)
    np.testing.assert_allclose(mirror.linear(2 - u, v)[0], mirror.linear(u, v)[0], atol=1e-6)


def test_clip_is_transparent_outside():
    out, inside = grid(lookup.CLIP).closest(at(-0.1, 1.1, 0.5), at(0.5, 0.5, -0.2))
    assert not out.any()
    assert not inside.any()


def test_cubic_weights_sum_to_one_and_a_constant_stays():
    t = np.linspace(0, 1, 11, dtype=np.float32)
    np.testing.assert_allclose(sum(lookup.bspline(t)), 1, atol=1e-6)
    flat = lookup.Grid(Whole.of(np.full((2, 3, 4), 0.3, np.float32)), lookup.EXTEND)
    np.testing.assert_allclose(flat.cubic(t, t)[0], 0.3, atol=1e-6)


@pytest.mark.parametrize("extension", list(lookup.WRAPS))
@pytest.mark.parametrize("interpolation", ["closest", "linear", "cubic"])
def test_hostile_coordinates_stay_finite(extension, interpolation):
    u = at(np.nan, np.inf, -np.inf, 1e30, -1e30, 3e9)
    with np.errstate(all="ignore"):
        out, _ = getattr(grid(extension), interpolation)(u, u[::-1].copy())
    assert np.isfinite(out[:, 3:]).all()


def sphere(n=200):
    d = np.random.default_rng(1).normal(size=(3, n)).astype(np.float32)
    return d / np.sqrt((d * d).sum(axis=0))


def test_equirectangular_is_its_own_inverse():
    d = sphere()
    back = environment.equirectangular_direction(*environment.equirectangular_uv(d))
    np.testing.assert_allclose(back, d, atol=2e-6)


def test_equirectangular_lies_as_in_blender():
    d = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32).T
    u, v = environment.equirectangular_uv(d)
    np.testing.assert_allclose(u[:2], [0.5, 0.25], atol=1e-6)
    np.testing.assert_allclose(v, [0.5, 0.5, 1], atol=1e-6)


def test_mirror_ball_is_its_own_inverse():
    d = sphere()
    back = environment.mirror_ball_direction(*environment.mirror_ball_uv(d))
    np.testing.assert_allclose(back, d, atol=3e-5)
