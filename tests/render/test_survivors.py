"""Who goes on: roulette keeps the expectation, sorting keeps everybody, the film's alpha is what was seen."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_same_mean
from support.rooms import MIRROR, ROUGH, half_transparent

from pt_engine.core import vectors
from pt_engine.core.samplers import Independent
from pt_engine.render.dimensions import LaneSampler
from pt_engine.render.path_state import PathState
from pt_engine.render.survivors import RR_LIMIT, Wavefront, kill, roulette, sorted_by_batch
from pt_engine.scene.accel import FAR
from pt_engine.scene.prepare import prepare
from pt_engine.scene.wave import Rays

UP = np.eye(4)


def paths(n: int, tracked: bool = False) -> PathState:
    sampler = Independent(1)
    state = sampler.state(np.arange(n), np.zeros(n, np.int64))
    return PathState.start(LaneSampler(sampler, state), tracked)


# ------------------------------------------------------------------ roulette


@pytest.mark.parametrize(
    "beta",
    [(0.3, 0.1, 0), (0.94, 0.2, 0.9), (0.97, 1.0, 0.5), (2.0, 7.0, 1.0), (1e-4, 0, 2e-4), (1e-9, 0, 1e-8)],
)
def test_roulette_keeps_the_expectation(beta):
    """E[β′] = q · β/q = β, however small. On a lattice of u the mean is exact but for one cell of 10⁶."""
    n = 1 << 20
    path = paths(n)
    path.beta = np.array(beta, np.float32)[:, None]
    strength = vectors.max3(path.beta)
    u = ((np.arange(n) + 0.5) / n).astype(np.float32)
    roulette(path, strength, u)
    q = min(max(*beta, 0.01), 0.95)
    np.testing.assert_allclose(path.beta.mean(axis=1, dtype=np.float64), beta, rtol=2 / n / q)
    lives = strength > 0
    assert lives.mean() == pytest.approx(q, abs=2 / n)
    np.testing.assert_array_equal(lives, vectors.max3(path.beta) > 0)
    np.testing.assert_allclose(path.beta[:, lives].max(), max(beta) / q, rtol=1e-6)


def test_roulette_lets_no_path_live_for_ever():
    """Even of throughput 10 one in 20 ends; and none of throughput 0 lives, at u = 0 either."""
    path = paths(3)
    path.beta = np.array([10.0, 10.0, 0.0], np.float32)
    strength = np.array([10.0, 10.0, 0.0], np.float32)
    roulette(path, strength, np.array([0.9499, RR_LIMIT, 0.0], np.float32))
    assert (strength > 0).tolist() == [True, False, False]
    assert np.isfinite(path.beta).all()
    assert (path.beta[:, 1:] == 0).all()


def test_roulette_leaves_the_image_as_it_was():
    """From the first bounce on, dark walls: the same mean as without roulette."""
    walls = (make.box(2.0, inward=True), UP, make.shining_diffuse((0.3, 0.6, 0.1), (1.0, 0.5, 2.0)))
    snapshot = make.scene([walls], make.perspective((0.1, 0.2, -0.3), (0.5, 0.4, 0.2), 1.0))
    with_it = make.rendered(snapshot, 16, samples=128, rr_depth=2, max_depth=12)
    without = make.rendered(snapshot, 16, samples=64, integrator="path_active", max_depth=12, seed=1)
    assert_same_mean(with_it, without)
    assert sum(with_it.progress.rays.values()) < 2 * 0.7 * sum(without.progress.rays.values())


@pytest.mark.parametrize("rr_depth", [1, 2, 5])
def test_roulette_begins_at_its_depth(rr_depth):
    """Before it every path goes on: the first rr_depth edges cost the same as without."""
    walls = (make.box(2.0, inward=True), UP, make.diffuse(0.5))
    snapshot = make.scene([walls], make.perspective((0.1, 0.2, -0.3), (0.5, 0.4, 0.2), 1.0))
    early = make.rendered(snapshot, 8, samples=16, rr_depth=rr_depth, max_depth=rr_depth).progress.rays
    never = make.rendered(snapshot, 8, samples=16, integrator="path_active", max_depth=rr_depth).progress.rays
    if rr_depth > 2:  # the edge number rr_depth is the first that roulette may spare
        assert early["bounce"] >= never["bounce"] * (rr_depth - 2) / (rr_depth - 1)
    deeper = make.rendered(snapshot, 8, samples=16, rr_depth=rr_depth, max_depth=rr_depth + 3).progress.rays
    full = make.rendered(
        snapshot, 8, samples=16, integrator="path_active", max_depth=rr_depth + 3
    ).progress.rays
    assert deeper["bounce"] < full["bounce"]


# ------------------------------------------------------------------ sorting


@pytest.mark.parametrize("dead", [0, 1, 2, 7, 254, 300])
@pytest.mark.parametrize("n", [0, 1, 1000])
def test_sorting_is_a_stable_permutation_and_spans_cover_the_living(dead, n):
    dtype = np.uint8 if dead < 255 else np.uint16
    batch = np.random.default_rng(dead).integers(0, dead + 1, n).astype(dtype)
    order, spans = sorted_by_batch(batch, dead)
    assert np.array_equal(np.sort(order), np.arange(n))
    np.testing.assert_array_equal(order, np.argsort(batch, kind="stable"))
    end = 0
    for group, span in spans:
        assert span.start == end < span.stop  # one after the other, none empty
        assert (batch[order[span]] == group).all()
        end = span.stop
    assert [group for group, _ in spans] == sorted({int(b) for b in batch if b < dead})
    assert (batch[order[end:]] == dead).all()
    assert end == (batch < dead).sum()


def test_killed_lanes_sort_last():
    batch = np.array([0, 3, 1, 2, 3], np.uint8)
    kill(batch, np.array([True, False, False, True, True]), 3)
    assert batch.tolist() == [3, 3, 1, 3, 3]
    wide = np.array([0, 299], np.uint16)
    kill(wide, np.array([True, False]), 300)
    assert wide.tolist() == [300, 299]


@pytest.fixture(name="room")
def _room():
    """Four squares of different sort in a row, each a group of its own, and a gap."""
    materials = [MIRROR, make.diffuse(0.5), make.emission(2.0), ROUGH]
    objects = [(make.quad(1.0), make.translation(k, 0, 0), m) for k, m in enumerate(materials)]
    return prepare(make.scene(objects, make.perspective((0, 0, 5), (0, 0, 0))))


def test_survivors_are_sorted_and_the_others_radiance_is_kept(room):
    """Each path's L reaches its own slot, whether it ends now or at the end."""
    n = 500
    x = np.random.default_rng(2).uniform(-1.5, 4.5, n)
    o = np.stack([x, 0.1 + 0 * x, 3 + 0 * x]).astype(np.float32) - room.geometry.origin[:, None].astype(
        np.float32
    )
    rays = Rays(o, np.tile(np.float32([[0], [0], [-1]]), n), np.full(n, FAR, np.float32))
    path = paths(n)
    path.L = np.arange(3 * n, dtype=np.float32).reshape(3, n)
    expected = path.L.copy()
    found = room.intersect(rays)
    front = Wavefront(SimpleNamespace(max_depth=9, transparent_depth=8), room, n)
    going, lanes, spans = front.survivors(path, found)
    scattering = (np.floor(x + 0.5) == 0) | (np.floor(x + 0.5) == 1) | (np.floor(x + 0.5) == 3)
    assert sorted(lanes) == np.flatnonzero(scattering).tolist()
    np.testing.assert_array_equal(going.slot, lanes)
    np.testing.assert_array_equal(going.L, expected[:, lanes])
    assert [group for group, _ in spans] == [0, 1, 2]
    assert room.materials.batches[room.groups[2].batch].delta_only  # the mirror last
    assert (np.floor(x[lanes[spans[2][1]]] + 0.5) == 0).all()
    going.L[:] += 1
    expected[:, lanes] += 1
    np.testing.assert_array_equal(front.finish(going), expected)


@pytest.mark.parametrize("bounces", [0, 1, 2])
def test_the_last_edge_scatters_no_more(room, bounces):
    """max_depth edges: after max_depth − 1 bounces nothing survives."""
    n = 4
    o = np.zeros((3, n), np.float32) + np.float32([[1 - room.geometry.origin[0]], [0.1], [3]])
    rays = Rays(o, np.tile(np.float32([[0], [0], [-1]]), n), np.full(n, FAR, np.float32))
    path = paths(n)
    path.bounces = bounces
    front = Wavefront(SimpleNamespace(max_depth=3, transparent_depth=8), room, n)
    going, _, _ = front.survivors(path, room.intersect(rays))
    assert going.size == (n if bounces < 2 else 0)


# ------------------------------------------------------------------ alpha


@pytest.mark.parametrize("integrator", ["path", "path_active", "path_fixed"])
def test_a_transparent_film_counts_what_hides_the_sky(integrator):
    """Alpha: opaque 1, empty 0, veil 1 − τ; a mirror is opaque though it shows the sky."""
    tau, n = 0.4, 2000
    objects = [
        (make.quad(1.0), make.translation(-1, 0, 0), make.diffuse(0.5)),
        (make.quad(1.0), make.translation(0, 0, 0), half_transparent(tau)),
        (make.quad(1.0), make.translation(1, 0, 0), MIRROR),
    ]
    camera = make.orthographic((0.5, 0, 3), (0.5, 0, 0), 4.0)  # squares of one pixel each, and a gap
    snapshot = make.scene(objects, camera, sky=make.world(1.0))
    image = make.rendered(snapshot, 4, samples=n, film_transparent=True, integrator=integrator).image()
    # the squares lie between pixel rows: half of two rows each
    row = image[1:3].sum(axis=0)
    np.testing.assert_allclose(row[[0, 2], 3], 1, atol=0.08)  # 5 standard errors of two half-covered pixels
    assert abs(row[1, 3] - (1 - tau)) < 0.08
    assert (image[0] == 0).all()
    assert (image[:, 3] == 0).all()
    mirror = image[1:3, 2]
    np.testing.assert_allclose(mirror[:, 0], 0.9 * mirror[:, 3], rtol=1e-4)  # premultiplied


def test_coloured_veils_leave_the_mean_of_what_they_let_through():
    """1 − mean(τ_r, τ_g, τ_b), over two layers: their product."""
    sheet = make.shader("BsdfTransparent", "coloured", Color=(1.0, 0.5, 0.25, 1.0))
    objects = [(make.quad(9.0), make.translation(0, 0, k), sheet) for k in (0, 1)]
    snapshot = make.scene(objects, make.orthographic((0, 0, 3), (0, 0, 0), 1.0), sky=make.world(1.0))
    image = make.rendered(snapshot, 4, samples=4, film_transparent=True, integrator="path_active").image()
    np.testing.assert_allclose(image[..., 3], 1 - (1 + 0.25 + 0.0625) / 3, rtol=1e-6)
    np.testing.assert_allclose(image[..., :3], 0, atol=1e-7)
