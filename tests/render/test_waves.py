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
from pt_engine.render.survivors import sorted_by_batch
from pt_engine.render.vertices import Vertices
from pt_engine.render.waves import Waves
from pt_engine.render.worker import by_sample
from pt_engine.scene.accel import Hits
from pt_engine.scene.prepare import prepare
from pt_engine.scene.wave import Intersection, Rays

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


def arrived(path, rays, kept):
    """Vertices of the lanes that `kept` marks, in three groups; what is found has the ray's number in it."""
    number = rays.tfar.astype(np.int32)
    found = Intersection(
        Hits(rays.tfar + 1, rays.tfar + 2, rays.tfar + 3, number + 4, number + 5), number + 6
    )
    group = np.where(kept, path.slot % 3, 3).astype(np.uint8)
    order, spans = sorted_by_batch(group, 3)
    order = order[: spans[-1][1].stop if spans else 0]
    return Vertices(path.take(order), rays, found, order, spans)


def check(vertices):
    """Each path has its own ray and hit; spans are groups in order, each of lanes all of that group."""
    slot = vertices.path.slot
    np.testing.assert_array_equal(vertices.rays.o[0].take(vertices.lanes), slot)
    np.testing.assert_array_equal(vertices.rays.d[1].take(vertices.lanes), -(slot + N))
    for k, row in enumerate((vertices.rays.tfar, *vertices.found.hits, vertices.found.surface)):
        np.testing.assert_array_equal(row.take(vertices.lanes), slot + k)
    groups, spans = zip(*vertices.spans, strict=True)
    assert list(groups) == sorted(set(groups))
    assert [span.start for span in spans] == [0, *(span.stop for span in spans[:-1])]
    assert spans[-1].stop == vertices.size
    for group, span in vertices.spans:
        assert (slot[span] % 3 == group).all()


@pytest.mark.parametrize(
    ("kept", "sizes"),
    [
        ([5, 5, 5, 5], [20]),  # all wait for the last
        ([12, 12, 12, 12], [24, 24]),  # three times 12 is more than a wave of 30
        ([25, 5, 25, 5], [25, 25, 10]),  # full ones do not wait
        ([5, 5, 5, 25], [25, 15]),
        ([5, 0, 5, 0], [10]),  # the last to arrive has nobody left, but others wait for it
        ([0, 0, 0, 3], [3]),
        ([0, 0, 0, 0], []),
    ],
)
def test_few_paths_wait_to_scatter_together(waves, kept, sizes):
    """Of each wave of 25 so many are left; at most half of 30 lanes wait. The next bounce has them all."""
    waves, _ = waves
    seen: list[int] = []
    coming, flying = iter(kept), 0
    for bounce, path, rays in waves.along(range(2)):
        if bounce == 1:
            flying += path.size
            continue
        for vertices in waves.together(arrived(path, rays, path.slot % 25 < next(coming))):
            check(vertices)
            seen.append(vertices.size)
            waves.go_on(vertices.path, vertices.rays.take(vertices.lanes))
            vertices.path.pdf = np.zeros(vertices.size, np.float32)
    assert seen == sizes
    assert flying == sum(kept)


def test_lanes_pixel_by_pixel_are_put_sample_by_sample():
    """Lane (pixel, sample) → slot (sample, pixel)."""
    unit = Unit(np.arange(6, dtype=np.int32), 0, 4)
    pixel, sample = np.meshgrid(np.arange(6), np.arange(4), indexing="ij")
    lanes = (10 * sample + pixel).astype(np.float32).reshape(-1)
    expected = (10 * np.arange(4)[:, None] + np.arange(6)).reshape(-1)
    np.testing.assert_array_equal(by_sample(unit, lanes), expected)
    np.testing.assert_array_equal(by_sample(unit, np.stack([lanes] * 3)), [expected] * 3)
