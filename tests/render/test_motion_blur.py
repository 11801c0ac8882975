"""Motion blur against closed forms: what share of the shutter's time a pixel sees what moves."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from support import scenes as make
from support.motion import moving

from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare

SIZE = 20
QUADRATURE = (np.arange(64) + 0.5) / 64  # places across a pixel
SHINING = make.emission(1.0)


def seen(snapshot, samples=128, **settings):
    """Radiance by column, and its standard error, of the middle rows' mean."""
    result = make.rendered(snapshot, SIZE, samples=samples, **settings)
    rows = slice(SIZE // 2 - 2, SIZE // 2 + 2)
    # all pixels see the same times: the rows' errors are taken as fully correlated
    error = np.sqrt(result.film.variance_of_mean()[rows, :, 0]).max(axis=0)
    return result.image()[rows, :, 0].mean(axis=0), error


def columns(share, left=-2.0, right=2.0):
    """Means over each pixel's width of a function of the place across the image."""
    edge = np.linspace(left, right, SIZE + 1)
    return np.array([share(a + (b - a) * QUADRATURE).mean() for a, b in pairwise(edge)])


def assert_agree(found, expected, z=4.5):
    """Within z standard errors; below 1/128, where all samples may agree by chance, those say nothing."""
    value, error = found
    np.testing.assert_array_less(np.abs(value - expected), z * error + 1.5 / 128)


def crossing(shutter=(1, 1)):
    """A shining unit square, its centre moving from x = −½ to ½, seen from above."""
    snapshot = make.scene([(make.quad(), np.eye(4), SHINING)], make.orthographic((0, 0, 5), (0, 0, 0), 4.0))
    path = [make.translation(x, 0, 0) for x in (-0.5, 0.0, 0.5)]
    return moving(snapshot, {0: path}, shutter=shutter)


def test_a_moving_edge_is_a_linear_ramp():
    """At x the square is there while |x − c(t)| < ½ with c = t − ½: a share of 1 − |x| of the time."""
    assert_agree(seen(crossing()), columns(lambda x: np.maximum(1 - np.abs(x), 0)))


@pytest.mark.parametrize("power", [1, 2])
def test_with_a_shutter_curve_the_edge_is_its_distribution(power):
    """Openness tᵖ: the time has distribution F = tᵖ⁺¹, and the share at x is F(x + 1) − F(x)."""
    curve = np.linspace(0, 1, 257) ** power

    def share(x):
        return np.clip(x + 1, 0, 1) ** (power + 1) - np.clip(x, 0, 1) ** (power + 1)

    assert_agree(seen(crossing(curve)), columns(share))


def test_a_turning_camera_smears_by_angle():
    """Yaw ψ uniform in ±0.2: a column at angle θ sees a target of half-angle b while |θ + ψ| < b."""
    yaw, half = 0.2, 0.15
    strip = make.mesh([(x, 10, z) for z in (-5, 5) for x in (-10 * np.tan(half), 10 * np.tan(half))],
                      [(0, 1, 3), (0, 3, 2)])  # fmt: skip
    camera = make.perspective((0, 0, 0), (0, 1, 0))
    cameras = [replace(camera, matrix=turn(a) @ camera.matrix) for a in (-yaw, 0, yaw)]
    snapshot = moving(make.scene([(strip, np.eye(4), SHINING)], camera), cameras=cameras)

    def share(tangent):
        angle = np.arctan(tangent)
        low, high = np.maximum(angle - half, -yaw), np.minimum(angle + half, yaw)
        return np.maximum(high - low, 0) / (2 * yaw)

    assert_agree(seen(snapshot), columns(share, -0.5, 0.5))


def turn(angle, axis=2):
    """4×4 rotation about an axis."""
    c, s = np.cos(angle), np.sin(angle)
    m = np.eye(4)
    i, j = [k for k in range(3) if k != axis]
    m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
    return m


def test_a_zooming_camera_smears_along_the_radius():
    """Its half width w shrinks from 1 to ½: at x of it a target of tangent h is seen while |x| w < h."""
    half = 0.3
    camera = make.perspective((0, 0, 1), (0, 0, 0), tangent=1.0)
    frames = [replace(camera, frame=(-w, w, -w, w)) for w in (1.0, 0.75, 0.5)]
    snapshot = make.scene([(make.quad(2 * half), np.eye(4), SHINING)], frames[1])

    def share(x):
        shut = 2 * (1 - half / np.maximum(np.abs(x), 1e-9))  # w = 1 − t/2 < half/|x| from this t on
        return 1 - np.clip(shut, 0, 1)

    assert_agree(seen(moving(snapshot, cameras=frames)), columns(share, -1, 1))


def test_a_growing_mesh_is_a_ramp_about_its_rim():
    """Half width h grows from ½ to 1½: x is covered while h > |x|, a share of clip(1½ − |x|, 0, 1)."""
    square = make.quad(2.0)
    steps = [square.vertices * np.float32(h) for h in (0.5, 1.0, 1.5)]
    snapshot = make.scene([(square, np.eye(4), SHINING)], make.orthographic((0, 0, 5), (0, 0, 0), 4.0))
    expected = columns(lambda x: np.clip(1.5 - np.abs(x), 0, 1))
    assert_agree(seen(moving(snapshot, meshes={0: steps})), expected)


def test_a_half_turn_sweeps_the_whole_disc():
    """A needle from the centre turned by exactly π in two steps: every angle of a half circle, equally long.

    A thin rectangle of half width e covers points at radius r for an angle of 2 arcsin(e/r) of the π.
    """
    e = 0.1
    needle = make.mesh([(0, -e, 0), (2, -e, 0), (2, e, 0), (0, e, 0)], [(0, 1, 2), (0, 2, 3)])
    snapshot = make.scene([(needle, np.eye(4), SHINING)], make.orthographic((0, 0, 5), (0, 0, 0), 4.0))
    result = make.rendered(moving(snapshot, {0: [np.eye(4), turn(np.pi)]}), 32, samples=128, sampler="sobol")
    image = result.image()[..., 0]
    y, x = (np.mgrid[:32, :32] + 0.5) / 32 * 4 - 2
    r = np.hypot(x, y)
    ring = (r > 0.8) & (r < 1.7)
    angle = np.arctan2(y, x)
    swept, other = (
        ring & (angle > 0.25) & (angle < np.pi - 0.25),
        ring & (angle < -0.25) & (angle > 0.25 - np.pi),
    )
    upper, lower = image[swept].mean(), image[other].mean()
    expected = (2 * np.arcsin(e / r[swept]) / np.pi).mean()
    # one side of the diameter or the other: both are a half turn, but never some of each
    assert min(upper, lower) == 0
    assert abs(max(upper, lower) - expected) < 0.03 * expected  # of the needle's 128 places


def test_the_mean_over_seeds_is_the_integral_over_time_whatever_the_number_of_samples():
    """Two samples a pixel: fixed times would see two copies, random ones the ramp, on average."""
    scene, n = prepare(crossing()), 64
    settings = [
        RenderSettings(SIZE, SIZE, samples=2, seed=k, threads=1, pixel_filter="BOX") for k in range(n)
    ]
    rows = np.array([render(scene, one).image()[8:12, :, 0].mean(axis=0) for one in settings])
    value, error = rows.mean(axis=0), rows.std(axis=0) / np.sqrt(n)
    expected = columns(lambda x: np.maximum(1 - np.abs(x), 0))
    np.testing.assert_array_less(np.abs(value - expected), 4.5 * error + 1.5 / n)


def test_sobol_times_are_stratified():
    """64 samples, twice 32 strata: an edge errs by far less than 1/√64."""
    value, _ = seen(crossing(), samples=64, sampler="sobol")
    expected = columns(lambda x: np.maximum(1 - np.abs(x), 0))
    assert np.abs(value - expected).max() < 2.5 / 32  # an edge errs by one stratum at most, and there are two
