"""Waves of one unit: each path goes on with its own ray and numbers, and small waves become one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from support import scenes as make

from pt_engine.core.raykind import RayKind
from pt_engine.core.samplers import Independent
from pt_engine.render.dimensions import LaneSampler
from pt_engine.render.schedule import Unit
from pt_engine.render.waves import Waves
from pt_engine.render.worker import by_sample
from pt_engine.scene.prepare import prepare
from pt_engine.scene.wave import Rays

N, LANES = 100, 30


@pytest.fixture(name="waves")
def _waves():
    square = (make.quad(1.0), np.eye(4), make.diffuse(0.5))
    scene = prepare(make.scene([square], make.orthographic((0, 0, 3), (0, 0, 0), 2.0)))
    numbers = np.arange(3 * N, dtype=np.float32).reshape(3, N)
    rays = Rays(numbers, -numbers, numbers[0].copy(), RayKind.CAMERA)
    sampler = Independent()
    lanes = LaneSampler(sampler, sampler.state(np.arange(N), np.zeros(N, np.int64)))
    return Waves(scene, rays, lanes, SimpleNamespace(lanes=LANES, clamp=None)), lanes


def test_paths_keep_rays_and_numbers_when_waves_are_joined(waves):
    """Four waves of 25; a quarter of each goes on, so that all that are left fit in one."""
    waves, lanes = waves
    sizes: dict[int, list[int]] = {}
    for bounce, path, rays in waves.along(range(3)):
        sizes.setdefault(bounce, []).append(path.size)
        np.testing.assert_array_equal(rays.o[0], path.slot)
        np.testing.assert_array_equal(rays.d, -rays.o)
        np.testing.assert_array_equal(rays.tfar, path.slot)
        np.testing.assert_array_equal(path.random.view(np.uint32), lanes.state[:, path.slot])
        some = np.flatnonzero(path.slot % 4 == 0)
        going = path.take(some)
        going.pdf = path.pdf.take(some)
        waves.go_on(going, Rays(*(row.take(some, axis=-1) for row in rays[:3])))
    assert sizes == {0: [25, 25, 25, 25], 1: [25], 2: [25]}
    assert [path.slot.tolist() for path in waves.left()] == [list(range(0, N, 4))]


def test_waves_that_do_not_fit_stay_apart(waves):
    waves, _ = waves
    for _, path, rays in waves.along(range(2)):
        waves.go_on(path, rays)
    assert [path.size for path in waves.left()] == [25, 25, 25, 25]


def test_lanes_pixel_by_pixel_are_put_sample_by_sample():
    """Lane (pixel, sample) → slot (sample, pixel)."""
    unit = Unit(np.arange(6, dtype=np.int32), 0, 4)
    pixel, sample = np.meshgrid(np.arange(6), np.arange(4), indexing="ij")
    lanes = (10 * sample + pixel).astype(np.float32).reshape(-1)
    expected = (10 * np.arange(4)[:, None] + np.arange(6)).reshape(-1)
    np.testing.assert_array_equal(by_sample(unit, lanes), expected)
    np.testing.assert_array_equal(by_sample(unit, np.stack([lanes] * 3)), [expected] * 3)
