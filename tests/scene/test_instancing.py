"""Instances that share records: rays find what they find among triangles of their own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import column, lanes_of, placed, random_directions, rotation, shoot, unit
from support.motion import moving

from pt_engine.core.raykind import RayKind
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene import instancing
from pt_engine.scene.accel import FAR, MISS
from pt_engine.scene.box_tree import BoxTree
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Visibility
from pt_engine.scene.wave import Rays

CAMERA = make.perspective((0, -5, 0), (0, 0, 0))
GREY, RED = make.diffuse(0.5), make.diffuse((0.8, 0.1, 0.1))
SHEAR = np.array([[1, 0.7, 0], [0, 1, -0.4], [0, 0, 1]])
MATRICES = [
    placed(rotation(1), (3, 0, 0)),
    placed(rotation(2) * 0.05, (-3, 1, 0)),
    placed(rotation(3) @ np.diag([-1, 2, 0.3]), (0, 4, 1)),
    placed(SHEAR @ rotation(4), (0, -4, -1)),
    placed(np.diag([1, 1, -1]), (0.2, 0.3, 0.1)),
    placed(rotation(5), (0.4, 0.1, 0.2)),  # inside of the one before
]
WAYS = ["copied", "nested"]


def crowd(smooth: bool = False):
    """Balls and boxes, each with two materials, two lamps and a floor that are there once."""
    ball, box = make.sphere(1.0, 12, smooth=smooth), make.box(1.0)
    parts = [(mesh, m, material) for m in MATRICES for mesh in (ball, box) for material in (GREY, RED)]
    moved = [
        (mesh, m @ make.translation(0.3 * k, 0.17 * k, -0.11 * k), a) for k, (mesh, m, a) in enumerate(parts)
    ]
    lamps = [(make.quad(), make.translation(x, 0, 9), make.emission(900.0)) for x in (0, 6)]
    return joined(make.scene([*moved, *lamps, (make.quad(20.0), make.translation(0, 0, -6), GREY)], CAMERA))


def joined(snapshot):
    """The same with each mesh once."""
    once = list({id(mesh): mesh for mesh in snapshot.meshes}.values())
    number = np.array(
        [next(k for k, m in enumerate(once) if m is mesh) for mesh in snapshot.meshes], np.int32
    )
    instances = replace(snapshot.instances, random=np.linspace(0, 1, len(number), dtype=np.float32))
    return replace(snapshot, meshes=tuple(once), instances=replace(instances, mesh=number))


@pytest.fixture(params=WAYS, name="way")
def _way(request, monkeypatch):
    return lambda snapshot: shared(snapshot, request.param, monkeypatch)


def shared(snapshot, way: str, monkeypatch):
    """Prepare with all sharing that there can be."""
    with monkeypatch.context() as patch:
        patch.setattr(instancing, "MANY", 0)

        def all_alike(*args):
            found = instancing.candidates(*args)
            return found._replace(nested=np.full(len(found.nested), way == "nested"))

        patch.setattr("pt_engine.scene.placing.candidates", all_alike)
        return prepare(snapshot)


def rays(n: int, seed: int = 0):
    """Origins within 8 of the middle, some of them inside of things, and directions."""
    rng = np.random.default_rng(seed)
    return rng.uniform(-5, 5, (n, 3)), random_directions(n, seed + 1)


def test_rays_find_the_same(way):
    """The same triangle of the same instance, at t, n and bound up to rounding; back faces are back faces.

    Rays within rounding of an edge may find its other side: fewer than 1 in 2,000.
    """
    snapshot = crowd()
    one, other = prepare(snapshot), way(snapshot)
    a, b = shoot(one, *rays(20_000)), shoot(other, *rays(20_000))
    assert other.geometry.shared is not None
    assert len(other.geometry.records) < 0.3 * len(one.geometry.records)
    both = np.flatnonzero((a.found.hits.prim != MISS) & (b.found.hits.prim != MISS))
    assert len(both) > 5_000
    assert abs(len(a.lanes) - len(b.lanes)) <= 10
    here, there = (np.searchsorted(s.lanes, both) for s in (a, b))
    a_si, b_si = a.si.take(here), b.si.take(there)
    first = [g.first_triangle.take(si.instance) for g, si in ((one.geometry, a_si), (other.geometry, b_si))]
    same = (a_si.instance == b_si.instance) & (a_si.prim - first[0] == b_si.prim - first[1])
    assert np.count_nonzero(~same) < len(both) / 2000
    np.testing.assert_allclose(b_si.t[same], a_si.t[same], rtol=2e-5, atol=2e-5)
    np.testing.assert_allclose(b_si.ng[:, same], a_si.ng[:, same], atol=1e-5)
    np.testing.assert_allclose(b_si.p[:, same], a_si.p[:, same], atol=2e-5)
    np.testing.assert_allclose(b_si.facing[same], a_si.facing[same], atol=1e-5)
    assert (b_si.bound[same] >= 0.5 * a_si.bound[same]).all()
    assert (b_si.bound < 1e-4).all()
    names = [s.geometry.surface_material.take(si.surface) for s, si in ((one, a_si), (other, b_si))]
    np.testing.assert_array_equal(names[0][same], names[1][same])


def test_shadows_are_the_same(way):
    """Whether anything lies within a distance; a ray that is switched off reads as blocked."""
    snapshot = crowd()
    one, other = prepare(snapshot), way(snapshot)
    o, d = rays(20_000, 5)
    tfar = np.random.default_rng(7).uniform(-1, 6, len(o)).astype(np.float32)
    seen = [s.accel.visible(column(o - s.geometry.origin), unit(d), tfar.copy()) for s in (one, other)]
    assert np.count_nonzero(seen[0] != seen[1]) <= 10
    assert set(np.unique(seen[1])) == {-1, 0}
    assert (seen[1][tfar < 0] == 0).all()


@pytest.mark.parametrize("matrix", [*MATRICES, placed(rotation(6) * 1e-3, (50, 60, 70))])
def test_no_ray_hits_where_it_starts(way, matrix):
    """From inside a closed box every ray ends on another face; from a face none meets that face again.

    A box of 10⁻³ at 110 has vertices, and points on it, quantised to 10⁻² of its size.
    """
    speck = make.quad(1e-3)
    parts = [(make.box(2.0), m, GREY) for m in (matrix,)]
    parts += [(parts[0][0], make.translation(-90, -90, -90), GREY), (speck, make.translation(-99, 9, 9), RED)]
    scene = way(joined(make.scene(parts, CAMERA)))
    n = 20_000
    first = shoot(scene, np.repeat(matrix[None, :3, 3], n, axis=0), random_directions(n, 1))
    assert first.si.size >= n - 1
    for k in range(2):
        w = random_directions(n, 2 + k).T.astype(np.float32)[:, : first.si.size]
        w = np.ascontiguousarray(w)
        rays_ = Rays(first.si.start(w), w, np.full(first.si.size, FAR, np.float32))
        found = scene.intersect(rays_)
        inward = np.einsum("ij,ij->j", w, first.si.ng) > 0
        again = found.hits.prim // 2 == first.si.prim // 2
        assert np.count_nonzero(again & (found.hits.instance == first.si.instance)) == 0
        assert np.count_nonzero(found.hits.prim[inward] == MISS) <= (40 if matrix[0, 3] == 50 else 2)


def test_shading_reads_the_instance(way):
    """Normals, object space, Random and Location of each instance, also where records are shared."""
    snapshot = crowd(smooth=True)
    one, other = prepare(snapshot), way(snapshot)
    a, b = shoot(one, *rays(5000, 3)), shoot(other, *rays(5000, 3))
    n = min(a.si.size, b.si.size)
    ball = [s.geometry.surface_smooth.take(shot.si.surface) for s, shot in ((one, a), (other, b))]
    if n != a.si.size or n != b.si.size or not np.array_equal(*ball):
        pytest.fail("a ray found something else: choose other rays")
    lanes = [
        lanes_of(s, x.si.take(np.flatnonzero(c)), smooth=True)
        for s, x, c in zip((one, other), (a, b), ball, strict=True)
    ]
    same = lanes[0].si.instance == lanes[1].si.instance
    assert same.mean() > 0.999
    for read in ("object_position", "object_random", "object_location", "object_normal"):
        x, y = (np.atleast_2d(getattr(lane, read)())[:, same] for lane in lanes)
        np.testing.assert_allclose(y, x, atol=2e-3 if read == "object_position" else 2e-4, err_msg=read)
    np.testing.assert_allclose(lanes[1].ns[:, same], lanes[0].ns[:, same], atol=2e-4)


def test_the_picture_is_the_same(way):
    """The same random numbers: pixels agree to 1e-3 but for those of whose 80 rays one met an edge.

    Such a path goes elsewhere: fewer than 1 in 50 pixels, and each by no more than its noise.
    """
    snapshot = crowd(smooth=True)
    settings = RenderSettings(24, 24, samples=16, threads=1, max_depth=5)
    a, b = (render(scene, settings).image()[..., :3] for scene in (prepare(snapshot), way(snapshot)))
    assert a.mean() > 0.05
    assert np.count_nonzero(np.abs(a - b).max(axis=2) > 1e-3 * a.max()) <= 11
    assert b.mean() == pytest.approx(a.mean(), rel=0.02)


def test_who_may_share(monkeypatch):
    """Several of a kind, moderate matrices, sound vertices, no emitters; another material is another kind."""
    monkeypatch.setattr(instancing, "MANY", 0)
    box, broken = make.box(1.0), make.mesh([(0, 0, 0), (np.nan, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    at, flat = make.translation(1, 2, 3), np.diag([1.0, 1.0, 0.0, 1.0])
    parts = (
        [(box, at, GREY)] * 2
        + [(box, at, RED)] * 3
        + [(box, flat, GREY), (broken, at, GREY), (broken, at, GREY)]
    )
    parts += [(make.quad(), at, GREY), (box, np.diag([1e9, 1e9, 1e9, 1]), GREY), (box, at, GREY)]
    sharing = instancing.candidates(
        joined(make.scene(parts, CAMERA)), np.arange(len(parts)) == len(parts) - 1
    )
    assert sharing.prototype.tolist() == [0, 0, 1, 1, 1, -1, -1, -1, -1, -1, -1]
    assert sharing.sample.tolist() == [0, 2]


def test_few_triangles_keep_their_own_records():
    """A scene that would spare little has none of it."""
    scene = prepare(crowd())
    assert scene.geometry.shared is None
    assert shoot(scene, *rays(10)).found.hits.instance is None


@pytest.mark.parametrize("count", [1, 7, 8, 9, 200])
def test_a_tree_finds_the_boxes_on_the_way(count):
    """All boxes with t_in ≤ min(t_out, tfar), by brute force in float64, and few others; nearest first."""
    rng = np.random.default_rng(count)
    low = rng.uniform(-3, 3, (count, 3))
    high = low + rng.exponential(0.3, (count, 3)) * rng.integers(0, 2, (count, 3))  # some are flat
    o, d = rng.uniform(-4, 4, (3, 500)).astype(np.float32), random_directions(500, count).T.astype(np.float32)
    d[:, :60] = np.eye(3, dtype=np.float32)[rng.integers(0, 3, 60)].T * rng.choice([-1, 1], 60)
    tfar = rng.uniform(-1, 8, 500).astype(np.float32)
    pairs = BoxTree(low, high).pairs(o, d, tfar)
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = ((c[:, :, None] - o) / d for c in (low, high))
    a, b = np.where(np.isnan(a), -np.inf, a), np.where(np.isnan(b), np.inf, b)
    enters, leaves = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
    met = (np.maximum(enters, 0) <= np.minimum(leaves, tfar)) & (tfar >= 0)
    found = np.zeros_like(met)
    found[pairs.box, pairs.ray] = True
    assert not (met & ~found).any()
    assert (found & ~met).sum() <= 5
    assert (np.diff(pairs.ray) >= 0).all()
    assert (np.diff(pairs.enters)[np.diff(pairs.ray) == 0] >= 0).all()


def test_of_nothing_nothing_is_found():
    empty = BoxTree(np.zeros((0, 3)), np.zeros((0, 3)))
    ray = np.zeros((3, 1), np.float32)
    assert len(empty.pairs(ray, ray + 1, np.ones(1, np.float32)).ray) == 0


def test_motion_among_shared_instances(way):
    """What moves keeps records of its own, between those of the still and those that are shared."""
    path = [placed(rotation(7), (x, -1.0, 0.5)) for x in (-1.0, 0.0, 1.0)]
    snapshot = crowd(smooth=True)
    moved = moving(snapshot, {1: path, len(snapshot.instances.mesh) - 1: path})
    settings = RenderSettings(24, 16, samples=4, threads=1, max_depth=4)
    plain, ready = prepare(moved), way(moved)
    assert ready.geometry.shared is not None
    theirs, ours = (render(scene.slices.at(0.3), settings).image() for scene in (plain, ready))
    close = np.isclose(ours, theirs, rtol=1e-3, atol=1e-3).all(axis=-1)
    assert close.mean() > 0.95  # rounding may send a path elsewhere
    assert theirs[..., :3].std() > 0.01


def test_what_some_rays_do_not_see_has_triangles_of_its_own(way):
    """Kinds of rays find the same among shared instances: those that they do not see are not shared."""
    snapshot = crowd()
    bits = snapshot.instances.visibility.copy()
    bits[1::3] &= ~np.uint8(Visibility.CAMERA)
    bits[2::5] &= ~np.uint8(Visibility.SHADOW)
    snapshot = replace(snapshot, instances=replace(snapshot.instances, visibility=bits))
    one, other = prepare(snapshot), way(snapshot)
    assert other.geometry.shared is not None
    o, d = rays(20_000, 11)
    o, d = column(o - one.geometry.origin), unit(d)
    for kind, bit in ((RayKind.CAMERA, Visibility.CAMERA), (RayKind.DIFFUSE, Visibility.DIFFUSE)):
        found = [
            s.intersect(Rays(o, d, np.full(o.shape[1], FAR, np.float32), kind)).hits for s in (one, other)
        ]
        who = [
            s.geometry.instance_of(hits, np.arange(o.shape[1]))
            for s, hits in zip((one, other), found, strict=True)
        ]
        met = (found[0].prim != MISS) & (found[1].prim != MISS)
        assert np.count_nonzero((found[0].prim == MISS) != (found[1].prim == MISS)) <= 10
        assert np.count_nonzero(who[0][met] != who[1][met]) <= 10  # rays along an edge that two share
        assert ((bits[who[1][met]] & bit) != 0).all()
    far = np.full(o.shape[1], 3, np.float32)
    clear = [s.accel.visible(o, d, far.copy()) for s in (one, other)]
    assert np.count_nonzero(clear[0] != clear[1]) <= 10
