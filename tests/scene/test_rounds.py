"""Curves and points: what rays meet is the closed form, found through hulls that miss nothing."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.hits import lanes_of, random_directions, shoot
from support.strands import cloud, nearest, rays_at, snapshot, strand, tuft

from pt_engine.scene import nearer
from pt_engine.scene.accel import FAR, MISS
from pt_engine.scene.features import ON
from pt_engine.scene.hulls import Hulls
from pt_engine.scene.prepare import prepare
from pt_engine.scene.round_accel import RoundAccel
from pt_engine.scene.snapshot import Graph, Link, Node
from pt_engine.scene.wave import Rays

N = 20_000
FEW = 4_000  # of those that are tried on every piece
UPRIGHT = [(0, 0, -1), (0, 0, 1)]
SHAPES = ["RIBBON", "THICK", "LINEAR"]


def across(z=0.9, width=0.2, seed=0):
    """Parallel rays along +Y: their x, origins and directions."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-width, width, N)
    o = np.stack([x, np.full(N, -3.0), rng.uniform(-z, z, N)], axis=1)
    return x, o, np.tile([0.0, 1.0, 0.0], (N, 1))


@pytest.mark.parametrize("shape", SHAPES)
def test_an_upright_strand_is_as_wide_as_twice_its_radius(shape):
    """|x| ≤ r hits, at 3 − √(r² − x²), on a ribbon at 3; normals (x, −√(r² − x²), 0)/r of all shapes alike.

    t to 4e-6: x as float32 near the silhouette, where dt/dx grows without bound.
    """
    x, o, d = across()
    shot = shoot(prepare(snapshot([strand(UPRIGHT, 0.1, shape)])), o, d)
    hit = np.isin(np.arange(N), shot.lanes)
    np.testing.assert_array_equal(hit, np.abs(x.astype(np.float32)) <= np.float32(0.1))
    x = x[shot.lanes]
    depth = np.sqrt(np.maximum(0.01 - x * x, 0))
    np.testing.assert_allclose(shot.si.t, 3.0 - depth * (shape != "RIBBON"), atol=4e-6)
    expected = np.stack([x, -depth, np.zeros_like(x)]) / 0.1
    np.testing.assert_allclose(shot.si.ng, expected, atol=2e-3)  # √ at the silhouette, again
    assert (shot.si.facing > 0).all()


def test_a_cones_hit_is_that_of_its_quadratic():
    """Radius ρ = 0.2 − 0.05 (z + 1) about Z: |x, y| = ρ(z) at every hit, to float32's digits of o + t d."""
    rng = np.random.default_rng(3)
    scene = prepare(snapshot([strand(UPRIGHT, [0.2, 0.1], "THICK")]))
    o = random_directions(N, 5) * 3
    target = np.stack(
        [rng.uniform(-0.2, 0.2, N), rng.uniform(-0.2, 0.2, N), rng.uniform(-0.8, 0.8, N)], axis=1
    )
    shot = shoot(scene, o, target - o)
    p = shot.si.p.astype(np.float64) + scene.geometry.origin[:, None]
    round_ = np.hypot(p[0], p[1]) < 0.3
    assert round_.sum() > N / 3
    z = p[2, round_]
    np.testing.assert_allclose(np.hypot(p[0], p[1])[round_], 0.2 - 0.05 * (z + 1), atol=3e-6)
    inside = np.abs(z) < 0.99
    along = shot.rays.o[:, shot.lanes] + shot.si.t * shot.rays.d[:, shot.lanes]
    np.testing.assert_allclose(along[:, round_][:, inside], shot.si.p[:, round_][:, inside], atol=3e-6)


def test_a_points_sphere_has_the_area_of_its_disk():
    """Rays whose distance from the centre is less than r hit, all others don't."""
    rng = np.random.default_rng(1)
    scene = prepare(snapshot(points=[cloud([(0.1, 0.2, 0.3)], 0.3)]))
    o = random_directions(N, 7) * 2
    d = rng.uniform(-0.5, 0.5, (N, 3)) - o
    shot = shoot(scene, o, d)
    away = np.array([0.1, 0.2, 0.3]) - o
    unit = d / np.linalg.norm(d, axis=1, keepdims=True)
    distance = np.linalg.norm(np.cross(away, unit), axis=1)
    hit = np.isin(np.arange(N), shot.lanes)
    near = np.abs(distance - 0.3) < 1e-6  # float32 of the rays
    np.testing.assert_array_equal(hit[~near], distance[~near] < 0.3)
    p = shot.si.p + scene.geometry.origin[:, None]
    np.testing.assert_allclose(shot.si.ng, (p - np.array([[0.1], [0.2], [0.3]])) / 0.3, atol=2e-5)


@pytest.mark.parametrize("radius", [0.05, 0.005])
@pytest.mark.parametrize("shape", SHAPES)
def test_hulls_miss_nothing_that_is_in_them(shape, radius):
    """From outside, the hit through the hulls is the nearest of all pieces, for shadow rays too.

    Two of 4,000 may differ: rays within rounding of a hull's edge, or between two triangles of one.
    """
    scene = prepare(snapshot([tuft(8, 6, radius, shape)]))
    o, d = rays_at(scene, FEW)
    far = np.full(FEW, FAR, np.float32)
    hits, expected = scene.accel.intersect(o, d, far.copy()), nearest(scene, o, d)
    met = np.isfinite(expected)
    assert 0.3 < met.mean() < 0.9
    found = hits.prim != MISS
    assert np.count_nonzero(found != met) <= 2
    both = found & met
    assert np.count_nonzero(np.abs(hits.t[both] - expected[both]) > 1e-5) <= 2
    assert np.count_nonzero((scene.accel.visible(o, d, far.copy()) == 0) != met) <= 2


@pytest.mark.parametrize("shape", SHAPES)
def test_rays_that_leave_a_strand_neither_meet_it_again_nor_slip_through_others(shape):
    """Onward, in all directions, what is met is what a search of all pieces from there meets, to 2 in 1,000.

    That much is lost where a ray begins within a hull and leaves it by its open end. As in Cycles a curve
    never meets itself, however it is bent.
    """
    scene = prepare(snapshot([tuft(8, 6, 0.02, shape)]))
    o, d = rays_at(scene, FEW)
    rays = Rays(o, d, np.full(FEW, FAR, np.float32))
    found = scene.intersect(rays)
    si = scene.surface(rays, found, np.flatnonzero(found.hits.prim != MISS))
    wo = np.ascontiguousarray(random_directions(si.size, 3).T, np.float32)
    onward = Rays(si.start(wo), wo, np.full(si.size, FAR, np.float32), 0, si.strand)
    hits, expected = scene.intersect(onward).hits, nearest(scene, onward.o, onward.d, si.strand)
    assert np.count_nonzero((hits.prim != MISS) != np.isfinite(expected)) <= 0.002 * si.size
    rounds = scene.geometry.rounds
    again = hits.prim != MISS
    assert 0.01 < again.mean() < 0.9
    assert (rounds.strand_of(hits.prim[again]) != si.strand[again]).all()
    clear = scene.accel.visible(onward.o, wo, np.full(si.size, FAR, np.float32), 0, si.strand)
    np.testing.assert_array_equal(clear == 0, again)


def test_a_tubes_inner_wall_is_met_through_its_open_end():
    """Rays through the disk at z = 1 toward points (r cos φ, r sin φ, z) of the wall, whose back they see.

    From there they go through the rest of their own tube.
    """
    rng = np.random.default_rng(4)
    phi, turn = rng.uniform(0, 2 * np.pi, (2, N))
    wall = np.stack([0.5 * np.cos(phi), 0.5 * np.sin(phi), rng.uniform(-0.9, 0.9, N)], axis=1)
    r = 0.45 * np.sqrt(rng.random(N))
    through = np.stack([r * np.cos(turn), r * np.sin(turn), np.ones(N)], axis=1)
    scene = prepare(snapshot([strand(UPRIGHT, 0.5)]))
    shot = shoot(scene, 2 * through - wall, wall - through)
    assert len(shot.lanes) == N
    np.testing.assert_allclose(shot.si.p + scene.geometry.origin[:, None], wall.T, atol=3e-6)
    np.testing.assert_allclose(shot.si.ng, -wall.T / 0.5 * [[1], [1], [0]], atol=1e-5)
    assert (shot.si.back == 1).all()
    wo = np.ascontiguousarray(random_directions(N, 3).T, np.float32)
    onward = Rays(shot.si.start(wo), wo, np.full(N, FAR, np.float32), 0, shot.si.strand)
    assert (scene.intersect(onward).hits.prim == MISS).all()


@pytest.mark.parametrize("shape", ["THICK", "LINEAR"])
def test_a_wide_straight_tube_has_no_gaps(shape):
    """Its pieces' hulls overlap in line, where triangles at one place hide one another."""
    points = np.linspace((0.6, -0.8, 0), (-0.6, 0.8, 0), 5)
    scene = prepare(snapshot([strand(points, 0.5, shape)]))
    o, d = rays_at(scene, FEW)
    found = scene.accel.intersect(o, d, np.full(FEW, FAR, np.float32)).prim != MISS
    assert np.count_nonzero(found != np.isfinite(nearest(scene, o, d))) <= 2


def test_rays_on_the_edges_of_hulls_go_on(monkeypatch):
    """What is beyond one triangle may be before its neighbour: of 40,000 none passes 4,096, but 20 or so."""
    snap, rng, count = snapshot([tuft(8, 6, 0.05, "THICK")]), np.random.default_rng(0), 40_000
    scene, hull = prepare(snap), Hulls(snap).meshes[0]
    a, b, _ = hull.vertices[hull.triangles[rng.integers(0, len(hull.triangles), count)]].transpose(1, 0, 2)
    target, d = a + rng.random((count, 1)) * (b - a) - scene.geometry.origin, random_directions(count)
    o, d = (np.ascontiguousarray(x.T, np.float32) for x in (target - 3 * d, d))
    far, calls, closest = np.full(count, FAR, np.float32), [], nearer.closest
    monkeypatch.setattr(nearer, "closest", lambda *a: (calls.append(1), closest(*a))[1])
    scene.accel.intersect(o, d, far.copy())
    scene.accel.visible(o, d, far.copy())
    assert len(calls) < 100


@pytest.mark.parametrize("away", [0.0, 100.0])
def test_thin_hair_far_from_the_zero_is_still_found(away):
    """Radius 2⁻¹⁰ at 200 from the zero, where float32 steps by 2⁻¹⁶: right but next to the silhouette."""
    radius, x0 = 2.0**-10, 2 * away
    x, o, d = across(width=2 * radius)
    points = np.array(UPRIGHT) + [x0, 0, 0]
    scene = prepare(snapshot([strand(points, radius), strand(np.array(UPRIGHT) - [x0, 0, 0], radius)]))
    shot = shoot(scene, o + [x0, 0, 0], d)
    hit = np.isin(np.arange(N), shot.lanes)
    clear = np.abs(np.abs(x) - radius) > max(away, 1) * 2.0**-22
    np.testing.assert_array_equal(hit[clear], np.abs(x[clear]) < radius)


def test_a_matrix_moves_strands_and_scales_radii_by_the_cube_root_of_its_determinant():
    """Scales (1, 1, 8): a strand along Z grows to 8 times its length and 2 times its radius, hull and all."""
    matrix = np.diag([1.0, 1.0, 8.0, 1.0])
    x, o, d = across(z=7.9, width=0.4)
    for shape in SHAPES:
        shot = shoot(prepare(snapshot([strand(UPRIGHT, 0.1, shape)], matrices=[matrix])), o, d)
        hit = np.isin(np.arange(N), shot.lanes)
        np.testing.assert_allclose(hit.mean(), 0.5, atol=0.02)
        assert np.count_nonzero(hit != (np.abs(x) <= 0.2)) <= 2


def test_strands_know_their_length_place_and_thickness():
    """Keys at heights 0, 1, 3: at z intercept z/3, length 3, thickness linear from 0.2 to 0.08 at the tip."""
    points = [(0, 0, 0), (0, 0, 1), (0, 0, 3)]
    graph = hair_info("Intercept")
    scene = prepare(snapshot([strand(points, [0.1, 0.08, 0.04], "LINEAR")], material=graph))
    _, o, d = across(z=1.4)
    shot = shoot(scene, o + [0, 0, 1.5], d)
    lanes = lanes_of(scene, shot.si)
    z = (shot.rays.o[2, shot.lanes] + scene.geometry.origin[2]).astype(np.float64)
    intercept, length, _, thickness = lanes.strand()
    np.testing.assert_allclose(length, 3, rtol=1e-6)
    np.testing.assert_allclose(intercept, z / 3, atol=0.02)  # a cone's normal stands r·dr/L from its foot
    expected = 2 * np.interp(3 * intercept, [0, 1, 3], [0.1, 0.08, 0.04])
    np.testing.assert_allclose(thickness, expected, rtol=1e-5)
    np.testing.assert_allclose(lanes.rounds.tangent, np.array([[0], [0], [1]]) + 0 * intercept, atol=1e-6)


def hair_info(output):
    """A material that shines with an output of Hair Info."""
    nodes = (
        Node("HairInfo", "Hair Info"),
        Node("Emission", "Emission", {"Color": Link(0, output), "Strength": 1.0}),
    )
    return Graph("info", nodes, {"Surface": Link(1, "Emission")})


def test_strands_that_shine_are_seen():
    """A tube of radiance 1 that fills the view gives 1, though no emitter sampling knows of it."""
    camera = make.orthographic((0, -5, 0), (0, 0, 0), 0.1)
    image = make.rendered(snapshot([strand(UPRIGHT, 0.1)], material=make.emission(1.0), camera=camera), 4)
    np.testing.assert_allclose(image.image()[..., :3], 1.0, rtol=1e-5)


def test_white_hair_under_a_white_sky_cannot_be_seen():
    """The furnace: albedo 1 in uniform light 1 gives 1, whatever is met on the way; to 4 standard errors."""
    for shape in SHAPES:
        scene = snapshot([tuft(30, 5, 0.03, shape)], material=make.diffuse(1.0), world=make.world(1.0))
        image = make.rendered(scene, 24, samples=32, max_depth=64).image()[..., 0]
        error = image.std() / np.sqrt(image.size) + 1e-4
        assert (
            abs(image.mean() - 1) < 4 * error + 0.003
        )  # paths of more than 64 bounces, between tubes, are cut


def test_scenes_without_curves_have_none_of_it():
    scene = prepare(
        make.scene([(make.quad(), np.eye(4), make.diffuse())], make.perspective((0, -5, 0), (0, 0, 0)))
    )
    assert scene.geometry.rounds is None
    assert type(scene.accel).__name__ == "Accel"
    assert scene.features["curves and points"] != ON


# ------------------------------------------------------------------ hard cases


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(
    ("points", "radius"),
    [
        ([(0, 0, 0)], 0.1),
        ([(0, 0, 0), (0, 0, 0)], 0.1),
        ([(0, 0, 0), (0, 0, 1)], 0.0),
        ([(0, 0, 0), (0, 0, 1)], -1.0),
        ([(0, 0, 0), (0, np.nan, 1)], 0.1),
        ([(0, 0, 0), (0, 0, np.inf)], 0.1),
        ([(0, 0, 0), (0, 0, 1)], np.nan),
        ([(0, 0, 0), (0, 0, 1e30)], 0.1),
        (np.zeros((0, 3)), 0.1),
    ],
    ids=["one point", "no length", "no radius", "negative", "NaN", "infinite", "NaN radius", "far", "none"],
)
def test_curves_that_are_nothing_are_not_there(shape, points, radius):
    scene = prepare(snapshot([strand(points, radius, shape)]))
    _, o, d = across()
    shot = shoot(scene, o, d)
    assert len(shot.lanes) == 0


@pytest.mark.parametrize("shape", SHAPES)
def test_the_rest_of_a_damaged_curve_stays(shape):
    """Keys repeat, have no place, fold back, end in a tip: what is hit has finite points and unit normals."""
    points = [(0, 0, -1), (0, 0, -1), (0, 0, -0.5), (0, 0, -0.5), (0, 0, 0), (0, 0, -0.2), (0.1, 0, 0.5),
              (np.nan, 0, 0), (0, 0, 0.6), (0, 0, 1)]  # fmt: skip
    radius = [0.1, 0.1, 0.1, 0.05, 0.1, 0, 0.1, 0.1, 0.1, 0]
    _, o, d = across(z=1.2)
    shot = shoot(prepare(snapshot([strand(points, radius, shape)])), o, d)
    assert len(shot.lanes) > N / 10
    assert np.isfinite(shot.si.p).all()
    np.testing.assert_allclose(np.linalg.norm(shot.si.ng, axis=0), 1, atol=1e-5)


def test_points_without_a_place_or_a_radius_are_not_there():
    points = [(np.nan, 0, 0), (0, 0, 0), (0, 0, 0.5), (0, np.inf, 0), (0, 0, -0.5)]
    scene = prepare(snapshot(points=[cloud(points, [0.1, 0.0, -1.0, 0.1, 0.1])]))
    x, o, d = across()
    shot = shoot(scene, o, d)
    hit = np.isin(np.arange(N), shot.lanes)
    np.testing.assert_array_equal(hit, np.hypot(x, o[:, 2] + 0.5) < 0.1)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("radius", [1e-5, 1e-7])
def test_rays_from_afar_pass_thin_hulls_in_a_few_steps(shape, radius, monkeypatch):
    """From 100 away a ray is known to 1e-5: it must not go from one side of a prism to the next for ever."""
    scene = prepare(snapshot([strand([(-1, 0, 0), (1, 0.5, 0)], radius, shape)]))
    rng, steps = np.random.default_rng(3), []
    tried = RoundAccel._tried
    monkeypatch.setattr(RoundAccel, "_tried", lambda *args: steps.append(1) or tried(*args))
    way = rng.uniform(-1, 1, N)
    o = np.stack([way, (way + 1) / 4 + rng.uniform(-3e-5, 3e-5, N), np.full(N, 100.0)], axis=1)
    shoot(scene, o, np.tile([0.0, 0.0, -1.0], (N, 1)))
    assert 0 < len(steps) <= 40
