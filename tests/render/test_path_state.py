"""The state of a wavefront: what a path carries from one hit to the next."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from support import scenes as make
from support.hits import random_directions, shoot

from pt_engine.bsdfs.base import Lobe
from pt_engine.core.raykind import RayKind
from pt_engine.core.samplers import SAMPLERS
from pt_engine.render.dimensions import CAMERA, PER_BOUNCE, LaneSampler
from pt_engine.render.path_state import DEPTH_OF_LOBE, KIND_OF_LOBE, PathState, mis
from pt_engine.scene.prepare import prepare
from pt_engine.scene.shading import Scattered
from pt_engine.scene.wave import Found, Rays

UP = np.eye(4)
N = 40


def lane_sampler(n=N, name="independent") -> LaneSampler:
    sampler = SAMPLERS[name](7)
    return LaneSampler(sampler, sampler.state(np.arange(n), np.arange(n) % 5))


def start(tracked: bool, n: int = N) -> PathState:
    return PathState.start(lane_sampler(n), tracked)


def hits(n=N):
    """Points on a ball, seen from outside."""
    scene = prepare(
        make.scene([(make.sphere(1.0, 16), UP, make.diffuse(0.5))], make.perspective((0, 0, 5), (0, 0, 0)))
    )
    d = random_directions(n, 3)
    return shoot(scene, 3 * d, -d).si


def scattered(n=N, lobe=Lobe.DIFFUSE, seed=5) -> Scattered:
    rng = np.random.default_rng(seed)
    wo = random_directions(n, seed).T.astype(np.float32)
    weight, pdf = rng.random((3, n), np.float32), rng.random(n, np.float32)
    return Scattered(np.ascontiguousarray(wo), weight, pdf, np.full(n, lobe, np.uint8))


# ------------------------------------------------------------------ weights


def test_the_power_heuristic():
    """w(p, q) = p²/(p² + q²), and the two weights of one direction sum to 1."""
    p, q = np.random.default_rng(1).uniform(0.01, 50, (2, 1000)).astype(np.float32)
    w = mis(p, q)
    np.testing.assert_allclose(
        w, p.astype(float) ** 2 / (p.astype(float) ** 2 + q.astype(float) ** 2), rtol=1e-5
    )
    np.testing.assert_allclose(w + mis(q, p), 1, rtol=1e-6)
    assert w.dtype == np.float32


@pytest.mark.parametrize(
    ("p", "q", "w"),
    [
        (np.inf, 1.0, 1.0),
        (np.inf, 0.0, 1.0),
        (1.0, 0.0, 1.0),
        (1e30, 1e30, 0.5),
        (1e-25, 1e-25, 0.5),
        (1e30, 1e-30, 1.0),
        (1e-30, 1e30, 0.0),
        (0.0, 1.0, 0.0),
        (1.0, 1e38, 0.0),
    ],
)
def test_weights_of_extreme_densities(p, q, w):
    """By ratio: squares that would overflow or vanish do neither, and nothing warns."""
    got = mis(np.array([p], np.float32), np.array([q], np.float32))
    np.testing.assert_allclose(got, w, atol=1e-12)


# ------------------------------------------------------------------ the way of a path


@pytest.mark.parametrize("tracked", [False, True])
def test_camera_paths(tracked):
    """β = 1, L = 0, density ∞ (nothing competes with the camera's own ray), slot by slot."""
    path = start(tracked)
    assert path.size == N
    assert (path.beta == 1).all()
    assert (path.L == 0).all()
    assert np.isinf(path.pdf).all()
    assert path.slot.tolist() == list(range(N))
    assert (path.kind == RayKind.CAMERA).all()
    for row in (path.depth, path.passed, path.travelled):
        assert row.shape == (N,)
        assert (row == 0).all()


@pytest.mark.parametrize("tracked", [False, True])
def test_a_path_takes_all_it_has_along(tracked):
    """Selection and slices move β, L, slot and random numbers together; history where it is kept."""
    path = start(tracked)
    path.beta, path.L = np.random.default_rng(2).random((2, 3, N), np.float32)
    path.scatter(hits(), scattered())
    index = np.random.default_rng(3).permutation(N)[:17]
    for some, where in ((path.take(index), index), (path.part(slice(3, 9)), np.arange(3, 9))):
        for name in ("beta", "L", "slot", "random", "kind", "depth", "passed", "travelled"):
            np.testing.assert_array_equal(getattr(some, name), getattr(path, name)[..., where], err_msg=name)
        assert some.bounces == path.bounces == 1


def test_random_numbers_belong_to_the_path_not_to_its_place():
    path, base = start(False), lane_sampler()
    index = np.array([5, 2, 30])
    np.testing.assert_array_equal(path.take(index).sampler(base).emitter(3), base.emitter(3)[:, index])


@pytest.mark.parametrize("name", ["independent", "sobol"])
def test_each_decision_has_a_dimension_of_its_own(name):
    """No two of filter, lens and the first bounces' numbers are the same row."""
    base = lane_sampler(name=name)
    rows = [*base.pixel(), *base.lens()]
    for bounce in range(4):
        rows += [base.roulette(bounce), *base.emitter(bounce), *base.bsdf(bounce)]
    assert len(rows) == CAMERA + 4 * (PER_BOUNCE - 1)  # one is left over
    assert len({row.tobytes() for row in rows}) == len(rows)
    assert all(((row >= 0) & (row < 1)).all() for row in rows)


@pytest.mark.parametrize("tracked", [False, True])
def test_scattering_multiplies_and_remembers(tracked):
    path, si, to = start(tracked), hits(), scattered(lobe=Lobe.GLOSSY | Lobe.DELTA)
    to = to._replace(pdf=np.full(N, np.inf, np.float32))
    rays = path.scatter(si, to)
    np.testing.assert_array_equal(path.beta, to.weight)
    assert np.isinf(path.pdf).all()
    assert (path.depth == 1).all()
    expected = RayKind.REFLECTION | RayKind.GLOSSY | RayKind.SINGULAR if tracked else RayKind.REFLECTION
    assert (path.kind == expected).all()
    np.testing.assert_array_equal(rays.d, to.wo)
    path.scatter(si, to)
    np.testing.assert_array_equal(path.beta, to.weight * to.weight)
    assert (path.depth == 2).all()


@pytest.mark.parametrize(
    ("lobe", "kind"),
    [
        (Lobe.DIFFUSE, RayKind.REFLECTION | RayKind.DIFFUSE),
        (Lobe.DIFFUSE | Lobe.TRANSMIT, RayKind.TRANSMISSION | RayKind.DIFFUSE),
        (Lobe.GLOSSY, RayKind.REFLECTION | RayKind.GLOSSY),
        (Lobe.GLOSSY | Lobe.TRANSMIT, RayKind.TRANSMISSION | RayKind.GLOSSY),
        (Lobe.DELTA, RayKind.REFLECTION | RayKind.GLOSSY | RayKind.SINGULAR),
        (Lobe.DELTA | Lobe.TRANSMIT, RayKind.TRANSMISSION | RayKind.GLOSSY | RayKind.SINGULAR),
    ],
)
def test_kinds_of_lobes(lobe, kind):
    """Blender's Light Path: a singular ray is a glossy one too, and each is reflected or transmitted.

    A bounce counts once: as transmission, else as a diffuse or a glossy one.
    """
    assert KIND_OF_LOBE[lobe] == kind
    counts = {name: int(table[lobe]) for name, table in DEPTH_OF_LOBE.items()}
    through = bool(kind & RayKind.TRANSMISSION)
    assert counts["transmission_depth"] == through
    assert counts["diffuse_depth"] == (not through and bool(kind & RayKind.DIFFUSE))
    assert sum(counts.values()) == 1


def test_rays_leave_on_the_side_they_go_to():
    """By the bound along the geometric normal, outward or inward."""
    si = hits()
    for sign in (1, -1):
        rays = start(False).scatter(si, scattered()._replace(wo=np.ascontiguousarray(sign * si.ng)))
        moved = ((rays.o - si.p) * si.ng).sum(axis=0)
        np.testing.assert_allclose(moved, sign * si.bound, atol=2e-7)
        assert (rays.tfar > 1e30).all()


def test_gathering_weighs_by_both_densities():
    """L += β · p²/(p² + q²) · Le, only where something was found."""
    path = start(False)
    path.beta = np.float32(0.5)
    path.pdf = np.full(N, 2.0, np.float32)
    lanes = np.array([3, 8])
    radiance = np.array([[1, 2], [3, 4], [5, 6]], np.float32)
    path.gather(Found(lanes, radiance, np.array([2.0, 0.0], np.float32)))
    np.testing.assert_allclose(path.L[:, 3], 0.5 * 0.5 * radiance[:, 0])
    np.testing.assert_allclose(path.L[:, 8], 0.5 * radiance[:, 1])
    assert (np.delete(path.L, lanes, axis=1) == 0).all()


# ------------------------------------------------------------------ passing through


CLEAR = Lobe.DELTA | Lobe.TRANSMIT | Lobe.TRANSPARENT
VEILED = SimpleNamespace(transparent_surfaces=True, has_portals=False)


def test_the_cone_of_a_ray_grows_with_its_way():
    """radius + spread·t at each surface, scattering or passed; how it widens stays; not kept unless given."""
    assert start(True).radius is None
    assert start(True).spread is None
    radius, spread = np.random.default_rng(6).random((2, N), np.float32)
    path, si = PathState.start(lane_sampler(), True, {"radius": radius, "spread": spread}), hits()
    path.scatter(si, scattered())
    np.testing.assert_allclose(path.radius, radius + spread * si.t, rtol=1e-6)
    to = scattered(lobe=CLEAR)
    path.go_on(VEILED, si, to, 9)
    np.testing.assert_allclose(path.radius, radius + 2 * spread * si.t, rtol=1e-6)
    np.testing.assert_array_equal(path.take(np.arange(3)).spread, spread[:3])


def test_passing_a_transparent_surface_is_no_bounce():
    """Density, kind and depth stay those of the last real bounce; distances add up; `passed` counts."""
    path, si = start(True), hits()
    path.go_on(VEILED, si, scattered(lobe=Lobe.DIFFUSE), 9)
    pdf, beta = path.pdf.copy(), path.beta.copy()
    lobes = np.where(np.arange(N) % 2, CLEAR, Lobe.GLOSSY).astype(np.uint8)
    to = scattered(seed=6)._replace(lobe=lobes)
    to = to._replace(pdf=np.where(np.arange(N) % 2, np.inf, to.pdf).astype(np.float32))
    path.go_on(VEILED, si, to, 9)
    through, bounced = np.arange(1, N, 2), np.arange(0, N, 2)
    np.testing.assert_array_equal(path.pdf[through], pdf[through])
    assert (path.kind[through] == RayKind.REFLECTION | RayKind.DIFFUSE).all()
    assert (path.kind[bounced] == RayKind.REFLECTION | RayKind.GLOSSY).all()
    assert (path.depth[through] == 1).all()
    assert (path.depth[bounced] == 2).all()
    assert (path.passed[through] == 1).all()
    assert (path.passed[bounced] == 0).all()
    np.testing.assert_allclose(path.travelled[through], si.t[through])
    assert (path.travelled[bounced] == 0).all()
    np.testing.assert_allclose(path.beta, beta * to.weight)
    path.go_on(VEILED, si, scattered(lobe=CLEAR, seed=7), 9)
    np.testing.assert_allclose(path.travelled[through], 2 * si.t[through], rtol=1e-6)
    assert (path.passed[through] == 2).all()


def test_camera_rays_that_pass_stay_camera_rays():
    path, si = start(True), hits()
    path.go_on(VEILED, si, scattered(lobe=CLEAR), 9)
    assert (path.kind == RayKind.CAMERA).all()
    assert np.isinf(path.pdf).all()
    assert (path.depth == 0).all()


def test_on_the_last_edge_a_path_may_only_pass():
    path, si = start(True), hits()
    lobes = np.where(np.arange(N) % 2, CLEAR, Lobe.DIFFUSE).astype(np.uint8)
    to = scattered()._replace(lobe=lobes)
    path.go_on(VEILED, si, to, max_depth=1)
    np.testing.assert_array_equal(path.beta[:, 1::2], to.weight[:, 1::2])
    assert (path.beta[:, ::2] == 0).all()


@pytest.mark.parametrize("tracked", [False, True])
def test_riding_along(tracked):
    """Fixed depth: those that have ended keep L and slot, with β = 0 and their ray off."""
    path = start(tracked)
    path.L = np.float32(3)
    here, si = path.part(slice(0, 10)), hits(10)
    to = scattered(10)
    rays = path.ride_along(here, here.scatter(si, to))
    assert isinstance(rays, Rays)
    np.testing.assert_array_equal(path.beta[:, :10], to.weight)
    assert (path.beta[:, 10:] == 0).all()
    assert (rays.tfar[:10] > 0).all()
    assert (rays.tfar[10:] < 0).all()
    np.testing.assert_array_equal(rays.d[:, :10], to.wo)
    np.testing.assert_array_equal(path.pdf[:10], to.pdf)
    assert np.isfinite(mis(path.pdf, np.ones(N, np.float32))).all()
    assert (path.L == 3).all()
    assert path.bounces == 1
    assert (path.depth[:10] == 1).all()
