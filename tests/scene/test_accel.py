"""Embree's answers, and rays that leave a surface: neither hit where they start nor slip through it."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.hits import Shot, column, placed, random_directions, rotation, shoot

from pt_engine.scene.accel import FAR, MISS, Accel
from pt_engine.scene.prepare import prepare
from pt_engine.scene.scene import Scene
from pt_engine.scene.wave import Rays

CAMERA = make.perspective((0, -5, 0), (0, 0, 0))
GREY = make.diffuse(0.5)
TILT = rotation(9)
N = 60_000  # of each sort of ray: 180k per case
# size, distance from the recentred world's zero; the same as in the measurements that chose the offset
PLACES = [(1e-3, 0.0), (1.0, 0.0), (1e4, 0.0), (1.0, 100.0), (1.0, 1e4), (1e3, 1e4)]


def at_a_distance(mesh, size: float, away: float) -> Scene:
    """The mesh, tilted and scaled, `away` from the zero: a far speck balances the bounding box."""
    there = placed(TILT * size, (away, away, away))
    speck = (make.quad(1e-3 * size), make.translation(-away, -away, -away), GREY)
    return prepare(make.scene([(mesh, there, GREY)] + ([speck] if away else []), CAMERA))


def onward(scene: Scene, shot: Shot, w: np.ndarray) -> Shot:
    """Rays from the hit points along world directions w (3, N)."""
    w = np.ascontiguousarray(w, np.float32)
    rays = Rays(shot.si.start(w), w, np.full(shot.si.size, FAR, np.float32))
    found = scene.intersect(rays)
    lanes = np.flatnonzero(found.hits.prim != MISS)
    return Shot(rays, found, lanes, scene.surface(rays, found, lanes))


def about_the_normal(ng: np.ndarray, seed: int, grazing: bool) -> np.ndarray:
    """(3, N) unit: cosine-distributed about ng, or within 10⁻³ to 10⁻⁶ of the surface's plane."""
    n = ng.astype(np.float64)
    v = random_directions(n.shape[1], seed).T
    if grazing:
        v -= (v * n).sum(axis=0) * n
        v /= np.linalg.norm(v, axis=0)
        v += 10.0 ** np.random.default_rng(seed).uniform(-6, -3, n.shape[1]) * n
    else:
        v += n * (1 + 1e-6)
    return (v / np.linalg.norm(v, axis=0)).astype(np.float32)


@pytest.mark.parametrize(("size", "away"), PLACES)
def test_no_ray_hits_where_it_starts_and_none_leaves_a_closed_box(size, away):
    """A convex box: a face is never seen from itself, and every ray inside ends on another.

    Self-hits: 0 of 120,000, as measured for this offset (it bounds the worst case, not the average).
    Escapes, cosine: 0 to 5·10⁻⁶ measured. Grazing: 1 to 5·10⁻⁵, for a ray 10⁻⁶ above a face meets the next
    one 10⁻⁶ from their edge, where Embree's own edge test rounds. A box of 1 at 10⁴: 1.3·10⁻⁴, since its
    vertices are quantised to 10⁻³. Bounds are four times that, or one ray of 60,000.
    """
    scene = at_a_distance(make.box(2.0), size, away)
    first = shoot(scene, np.full((N, 3), away), random_directions(N, 1))
    assert first.si.size >= N * (1 - 2e-5)
    for k, (grazing, allowed) in enumerate(((False, 2e-5), (True, 2e-4))):
        second = onward(scene, first, about_the_normal(first.si.ng, 2 + k, grazing))
        assert np.count_nonzero(first.si.prim[second.lanes] // 2 == second.si.prim // 2) == 0
        escaped = 1 - second.si.size / first.si.size
        assert escaped <= (6e-4 if away / size >= 1e4 else allowed)


@pytest.mark.parametrize(("size", "away"), PLACES)
def test_no_ray_leaving_a_convex_ball_meets_it_again(size, away):
    """20,000 triangles seen from outside: a leaving ray never meets its own triangle, nor any other.

    Grazing rays see a neighbour in 0.5 to 2.5·10⁻⁵ of cases, truly: rounded vertices tilt coplanar neighbours
    against each other by 10⁻⁶; where they are quantised to 2 % of an edge, in 10⁻³.
    """
    scene = at_a_distance(make.sphere(1.0, 72, smooth=False), size, away)
    quantised = away / size >= 1e4
    out = random_directions(N, 3)
    first = shoot(scene, away + 3 * size * out, -out + 0.3 * random_directions(N, 4))
    assert first.si.size > 0.99 * N
    for k, (grazing, allowed) in enumerate(((False, 0.0), (True, 1e-4))):
        second = onward(scene, first, about_the_normal(first.si.ng, 5 + k, grazing))
        assert np.count_nonzero(first.si.prim[second.lanes] == second.si.prim) == 0
        assert second.si.size <= N * (4e-3 if quantised else allowed)
    # and through it: rays that go on inward all reach the other side
    inward = onward(scene, first, -about_the_normal(first.si.ng, 7, grazing=False))
    assert np.count_nonzero(inward.si.prim == first.si.prim[inward.lanes]) == 0
    assert inward.si.size >= first.si.size * (1 - 5e-5)


@pytest.mark.parametrize("seed", [1, 2])
def test_slivers_are_left_cleanly(seed):
    """A disc of 20,000 needles, each 3000 times as long as wide: no ray meets the needle it starts from.

    Rounded to float32 the needles are tilted against each other by up to 10⁻³, so grazing rays do see
    neighbours; of the others fewer than 10⁻⁴ do, near the centre where needles are thinnest.
    """
    count = 20_000
    phi = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rim = np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1)
    t = np.stack([np.zeros(count), 1 + np.arange(count), 1 + (1 + np.arange(count)) % count], axis=1)
    disc = make.mesh(np.concatenate([[(0, 0, 0)], rim]), t)
    linear = rotation(seed)
    scene = prepare(make.scene([(disc, placed(linear), GREY)], CAMERA))
    rng = np.random.default_rng(seed)
    r, a = np.sqrt(rng.random(N)) * 0.99, rng.uniform(0, 2 * np.pi, N)
    target = np.stack([r * np.cos(a), r * np.sin(a), 0 * a], axis=1) @ linear.T
    first = shoot(scene, target + 2 * linear[:, 2] + rng.uniform(-1, 1, (N, 3)), -linear[:, 2] + 0 * target)
    for k, grazing in enumerate((False, True)):
        second = onward(scene, first, about_the_normal(first.si.ng, 8 + k, grazing))
        assert np.count_nonzero(first.si.prim[second.lanes] == second.si.prim) == 0
        assert grazing or second.si.size < 1e-4 * N


@pytest.mark.parametrize(("size", "away"), [(1e-3, 0.0), (1.0, 0.0), (1e4, 0.0), (1.0, 100.0)])
@pytest.mark.parametrize("integrator", ["direct_emitter", "direct_bsdf", "path"])
def test_a_flat_lamp_does_not_light_itself(integrator, size, away):
    """L = Le: the lamp's other points lie in its own plane, at cosine 0 on both ends.

    At 100 its corners are rounded to 4·10⁻⁶, which folds its two triangles a little: 10⁻³ at their edge.
    """
    there = placed(TILT * size, (away, away, away))
    lamp = (make.quad(2.0), there, make.shining_diffuse(0.9, 1.0))
    speck = (make.quad(1e-6), make.translation(-away, -away, -away), GREY)
    eye = there[:3, 3] + TILT @ (0.3 * size, 0.2 * size, 3 * size)
    snapshot = make.scene([lamp] + ([speck] if away else []), make.perspective(eye, there[:3, 3], 0.2))
    result = make.rendered(snapshot, 16, samples=8, integrator=integrator, max_depth=4)
    np.testing.assert_allclose(result.image()[..., :3], 1.0, rtol=1e-3 if away else 2e-6)


def test_barycentrics_weigh_corners_1_and_2():
    """p = (1 − u − v) a + u b + v c."""
    a, b, c = np.array([(0, 0, 0), (2, 0, 0), (0, 3, 0)], float)
    accel = Accel(np.array([a, b, c], np.float32), np.array([[0, 1, 2]], np.int32))
    u, v = np.array([0.1, 0.7, 0.3]), np.array([0.2, 0.1, 0.6])
    p = np.outer(1 - u - v, a) + np.outer(u, b) + np.outer(v, c)
    hits = accel.intersect(column(p + (0, 0, 4)), column([(0, 0, -1)] * 3), np.full(3, FAR, np.float32))
    np.testing.assert_allclose(hits.u, u, atol=1e-6)
    np.testing.assert_allclose(hits.v, v, atol=1e-6)
    np.testing.assert_allclose(hits.t, 4, rtol=1e-6)
    assert hits.prim.tolist() == [0, 0, 0]


def test_the_nearest_of_many_is_found_and_tfar_is_respected():
    """Ten sheets 1 apart: the ray from height 9.5 meets sheet 9; with tfar 0.4 none; tfar < 0 is off."""
    quads = [(make.quad(), make.translation(0, 0, k), GREY) for k in range(10)]
    scene = prepare(make.scene(quads, CAMERA))
    o = column([(0.1, 0.2, 9.5 - 4.5)] * 3)
    d = column([(0, 0, -1)] * 3)
    tfar = np.array([FAR, 0.4, -1], np.float32)
    found = scene.intersect(Rays(o, d, tfar.copy()))
    assert found.hits.prim[0] // 2 == 9
    assert found.hits.prim[1:].tolist() == [MISS, MISS]
    assert found.hits.t[0] == pytest.approx(0.5)
    assert scene.accel.visible(o, d, np.array([0.4, 0.6, 20], np.float32)).tolist() == [-1, 0, 0]


@pytest.mark.parametrize("empty", [True, False])
def test_a_shadow_ray_that_is_off_reads_as_blocked(empty):
    """With and without triangles: −1 (all bits) is clear, 0 is blocked."""
    triangles = np.zeros((0 if empty else 1, 3), np.int32) + np.arange(3, dtype=np.int32)
    accel = Accel(np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], np.float32), triangles)
    o, d = column([(0, 0, 5)] * 3), column([(0, 0, 1)] * 3)
    clear = accel.visible(o, d, np.array([-1, 1, FAR], np.float32))
    assert clear.tolist() == [0, -1, -1]
    assert clear.dtype == np.int32


def test_queries_read_any_stride_and_change_nothing_but_tfar():
    """Rows of a wider buffer, as a wavefront keeps them; Embree writes the hit's distance into tfar."""
    scene = prepare(make.scene([(make.sphere(1, 16), np.eye(4), GREY)], CAMERA))
    d = random_directions(1000, 11)
    wide = np.zeros((8, 2000), np.float32)
    wide[0:3, :1000], wide[4:7, :1000] = (4 * d).T, -d.T
    kept = wide.copy()
    tight = scene.accel.intersect(column(4 * d), column(-d), np.full(1000, FAR, np.float32))
    loose = scene.accel.intersect(wide[0:3, :1000], wide[4:7, :1000], np.full(1000, FAR, np.float32))
    for a, b in zip(tight, loose, strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(wide, kept)
