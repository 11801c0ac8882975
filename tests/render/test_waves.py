"""Waves of paths are joined where their living paths fit into one; nobody's radiance or history is lost."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from pt_engine.core.samplers import Independent
from pt_engine.render.dimensions import LaneSampler
from pt_engine.render.path_state import HISTORY
from pt_engine.render.survivors import Wavefront, runs
from pt_engine.scene.accel import FAR
from pt_engine.scene.scene import Rays


def scene(tracked):
    """What a wavefront asks of a scene: whether its paths keep their history, and nothing more of it."""
    return SimpleNamespace(tracks_history=tracked, history=lambda rays: {})


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        ([], []),
        ([7, 2, 8, 1], [(0, 2), (2, 4)]),
        ([10, 10, 10], [(0, 1), (1, 2), (2, 3)]),
        ([0, 0, 10, 0], [(0, 4)]),
        ([3, 3, 3, 3, 3], [(0, 3), (3, 5)]),
    ],
)
def test_runs_hold_what_fits_in_order(sizes, expected):
    assert [(run.start, run.stop) for run in runs(sizes, 10)] == expected


@pytest.mark.parametrize("tracked", [False, True])
def test_joined_waves_keep_every_path(tracked):
    """Three waves of 100 of which a quarter lives: one wave, and all 300 radiances reach their slots."""
    n, lanes = 300, 100
    rng = np.random.default_rng(5)
    front = Wavefront(SimpleNamespace(lanes=lanes), scene(tracked), n)
    sampler = Independent(3)
    state = sampler.state(np.arange(n), np.zeros(n, np.int64))
    rays = Rays(*(rng.random((3, n), np.float32) for _ in range(2)), np.full(n, FAR, np.float32))
    waves = front.start(rays, LaneSampler(sampler, state))
    assert [wave.path.size for wave in waves] == [lanes] * 3
    lives = rng.random(n) < 0.25
    expected = rng.random((3, n), np.float32)
    density = rng.random(n, np.float32)
    for k, (path, ray) in enumerate(waves):
        span = slice(k * lanes, (k + 1) * lanes)
        path.L, path.pdf = expected[:, span], density[span]
        ray.tfar[~lives[span]] = -1
        if tracked:
            for name in HISTORY:
                path._history[name][:] = np.arange(n)[span]
    (only,) = front.joined(waves)
    np.testing.assert_array_equal(only.path.slot, np.flatnonzero(lives))
    np.testing.assert_array_equal(only.path.random.view(np.uint32), state[:, lives])
    np.testing.assert_array_equal(only.path.pdf, density[lives])
    np.testing.assert_array_equal(only.rays.d, rays.d[:, lives])
    if tracked:
        for name in HISTORY:
            np.testing.assert_array_equal(only.path._history[name], np.flatnonzero(lives))
    np.testing.assert_array_equal(front.finish([only]), expected)


def test_waves_that_do_not_fit_stay_apart():
    front = Wavefront(SimpleNamespace(lanes=10), scene(tracked=False), 20)
    sampler = Independent(0)
    state = sampler.state(np.arange(20), np.zeros(20, np.int64))
    rays = Rays(np.zeros((3, 20), np.float32), np.ones((3, 20), np.float32), np.ones(20, np.float32))
    waves = front.start(rays, LaneSampler(sampler, state))
    assert [a.path is b.path for a, b in zip(front.joined(waves), waves, strict=True)] == [True, True]
