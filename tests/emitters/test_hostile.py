"""Zero sizes, edge-on, behind, touching, inside, far: every number stays finite and means what it says."""

import numpy as np
import pytest
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh
from support.lamps import DELTA, SIZED, environment_map, lamp, lights, placed, points, triangles, up

from pt_engine.emitters.lights import Lights
from pt_engine.emitters.triangle import TriangleEmitters
from pt_engine.scene.snapshot import Visibility

PLACES = np.array(
    [
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 2.0),  # at the centre of most lamps
        (0.3, -0.4, 1.5),  # at the centre of the tilted ones
        (0.0, 0.0, 1.6),  # on a sphere of radius 0.4
        (5.0, 0.0, 2.0),  # in the plane of the untilted ones
        (0.0, 0.0, 9.0),  # behind
        (1e-7, 0.0, 1.9999999),
        (1e5, -1e5, 1e4),
        (1e-30, 0.0, 0.0),
    ],
    np.float32,
).T


def hostile_numbers():
    """Every corner and middle of the unit cube of uniforms."""
    line = np.array([0.0, 1e-7, 0.5, 0.99999994], np.float32)
    return np.stack([g.ravel() for g in np.meshgrid(line, line, line)])


@pytest.mark.parametrize("name", [*SIZED, *DELTA])
def test_everything_is_finite_everywhere(name):
    """Unit directions (10⁻³ where the lamp is nearer than rounding), finite weights and densities ≥ 0."""
    scene = lights({**SIZED, **DELTA}[name])
    u = hostile_numbers()
    p, u = np.repeat(PLACES, u.shape[1], axis=1), np.tile(u, PLACES.shape[1])
    s = scene.sample(p, up(p.shape[1]), u)
    for value in s[:4]:
        assert np.isfinite(value).all()
    assert (s.pdf >= 0.0).all()
    assert (s.weight >= 0.0).all()
    length = np.sqrt((s.wo.astype(np.float64) ** 2).sum(axis=0))
    shining = s.weight.any(axis=0) & (s.distance > 1e-5)
    np.testing.assert_allclose(length[shining], 1.0, atol=1e-3)
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        for d in (s.wo, -s.wo, up(p.shape[1])):
            for lanes, radiance, pdf, _ in scene.intersect(p, d, np.full(p.shape[1], np.inf, np.float32)):
                assert np.isfinite(radiance).all()
                assert np.isfinite(pdf).all()
                assert lanes.size == pdf.size == radiance.shape[1]


def test_an_environment_is_finite_at_its_poles():
    scene = lights(environment=environment_map())
    n = hostile_numbers().shape[1]
    s = scene.sample(points(n), up(n), hostile_numbers())
    assert np.isfinite(s.weight).all()
    poles = [[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [-1, -0.0, 0], [0, 0, 1.0000001]]
    assert (scene.environment_pdf(np.array(poles, np.float32).T.copy()) > 0.0).all()


def test_triangles_touched_and_degenerate():
    """A triangle without area gives nothing; one that is touched or seen edge-on stays finite."""
    vertices = np.array([[(0, 0, 1)] * 3, [(0, 0, 0), (1, 0, 0), (0, 1, 0)]], np.float32)
    ones = np.ones((2, 3), np.float32)
    emitters = TriangleEmitters(vertices, ones, np.zeros(2, np.bool_), np.full(2, 1e-6, np.float32))
    scene, n = lights(triangles=emitters), hostile_numbers().shape[1]
    for place in ((0, 0, 0), (0.2, 0.2, 0), (2, 0, 0), (0.2, 0.2, -1e-6)):
        s = scene.sample(points(n, place), up(n), hostile_numbers())
        assert (s.emitter == 1).all()
        assert np.isfinite(np.concatenate([*s.wo, s.distance, *s.weight, s.pdf])).all()
        assert (s.distance >= 0.0).all()


def test_nothing_shines():
    """Black lamps, lamps without area and scenes without lamps are the same: nothing, and no choice."""
    black = lamp("POINT", power=0.0), lamp("AREA", size=(0.0, 0.0)), lamp("AREA", placed(scale=(0, 1, 1)))
    for scene in (lights(), lights(*black), lights(lamp("SUN", power=float("nan")))):
        assert scene.description.total == 0
        s = scene.sample(points(3), up(3), np.zeros((3, 3), np.float32))
        assert not s.weight.any()
        assert not list(scene.intersect(points(3), up(3), np.ones(3, np.float32)))


def test_lamps_with_size_but_no_mis_or_no_shadow_are_found_by_sampling_alone():
    """Then no ray meets them, and their samples are weighed as a point's."""
    far, middle = np.full(1, np.inf, np.float32), np.full((3, 1), 0.5, np.float32)
    plain = lights(lamp("POINT", radius=0.3)).sample(points(1), up(1), middle)
    no_mis, no_shadow = {"use_mis": False}, {"cast_shadow": False}
    for settings, met, shadow in (({}, 1, True), (no_mis, 0, True), (no_shadow, 0, False)):
        scene = lights(lamp("POINT", radius=0.3, **settings))
        assert sum(h.lanes.size for h in scene.intersect(points(1), up(1), far)) == met
        s = scene.sample(points(1), up(1), middle)
        assert s.delta == (met == 0)
        assert (s.distance > 0.0).all() == shadow
        np.testing.assert_array_equal(s.weight, plain.weight)


def test_camera_rays_see_the_lamps_that_are_visible_to_them():
    seen = lamp("POINT", radius=0.3, visibility=Visibility.ALL, use_mis=False)
    scene = lights(seen, lamp("AREA", placed(x=0.1)))
    camera = np.array([True, False, True, False])
    t = np.array([np.inf, np.inf, 1.0, 1.0], np.float32)
    found = {tuple(h.lanes.tolist()) for h in scene.intersect(points(4), up(4), t, camera) if h.lanes.size}
    assert found == {(0,), (1,)}
    assert sum(h.lanes.size for h in scene.intersect(points(4), up(4), t, True)) == 2
    assert sum(h.lanes.size for h in scene.intersect(points(4), up(4), t, None)) == 2


def test_recentring_moves_the_lamps():
    """A scene a million metres away gives the same samples as one at the origin, bit for bit."""
    away = np.array([1e6, -2e6, 5e5])
    u = np.random.default_rng(0).random((3, 100), np.float32)
    here = lights(SIZED["rectangle"]).sample(points(100), up(100), u)
    matrix = SIZED["rectangle"].matrix.copy()
    matrix[:3, 3] += away
    moved = lamp("AREA", matrix, shape="RECTANGLE", size=(2.0, 0.3))
    there = Lights([moved], origin=away, scene_radius=3.0).sample(points(100), up(100), u)
    np.testing.assert_allclose(there.wo, here.wo, atol=1e-6)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("shift", [0.0, 100.0])
def test_shadow_rays_do_not_hit_the_triangle_they_aim_at(scale, shift):
    """Rays are cut by the light triangle's own bound γ₆ |n|·max|vertex|: no false shadow in 200 000."""
    rng = np.random.default_rng(9)
    emitters = triangles(20)
    vertices = ((emitters.vertices + shift) * scale).astype(np.float32)
    normal = np.cross(vertices[:, 1] - vertices[:, 0], vertices[:, 2] - vertices[:, 0])
    normal /= np.sqrt((normal**2).sum(axis=1, keepdims=True))
    bound = 6 * 2.0**-24 * (np.abs(normal) * np.abs(vertices).max(axis=1)).sum(axis=1)
    bound = bound.astype(np.float32)
    scene = lights(triangles=TriangleEmitters(vertices, emitters.radiance, emitters.varies, bound))
    n = 200_000
    p = ((rng.uniform(-2, 2, (3, n)) * [[1], [1], [0]] + shift) * scale).astype(np.float32)
    s = scene.sample(p, up(n), rng.random((3, n), np.float32))
    hit = np.zeros(n, np.bool_)
    for number, corners in enumerate(vertices):
        one = rtcore_scene.EmbreeScene()
        TriangleMesh(one, corners[None])
        lanes = np.flatnonzero(s.emitter == number)
        tfar = s.distance[lanes].copy()
        blocked = one.run(p[:, lanes].T.copy(), s.wo[:, lanes].T.copy(), dists=tfar, query="OCCLUDED")
        hit[lanes] = np.asarray(blocked) == 0
    assert hit.sum() == 0
