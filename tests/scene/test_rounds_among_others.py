"""Curves and points with what else builds trees: motion, ray visibility, links, sharing, catchers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import random_directions, shoot
from support.motion import moving, standing_at
from support.strands import among, cloud, strand, tuft

from pt_engine.core.raykind import RayKind
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene import instancing
from pt_engine.scene.accel import FAR
from pt_engine.scene.features import ON
from pt_engine.scene.nearer import clear, closest
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Linking, Visibility
from pt_engine.scene.snapshot_io import load_snapshot, save_snapshot

UP = np.eye(4)
CAMERA = make.perspective((0, -6, 3), (0, 0, 0.5), 0.5)
GREY, RED = make.diffuse(0.6, "grey"), make.diffuse((0.8, 0.2, 0.1), "red")
FLOOR = make.quad(12.0)
SETTINGS = RenderSettings(24, 16, samples=4, threads=1, max_depth=4)
PATH = [make.translation(-1, 0, 0.5), make.translation(1, 0.3, 0.9)]
TUFT, DROPS = tuft(30, 5, 0.06, "THICK"), cloud([(1, 0, 0.6), (-1, 1, 0.7)], 0.3)
BOX, BALL = 2, 3  # rows of `stage`: the tuft and the drops are ahead
N = 4_000


def stage(lights=()):
    """A tuft, drops, a box, a ball and a floor."""
    objects = [
        (make.box(1.0), PATH[0], RED),
        (make.sphere(0.5, 12, smooth=True), make.translation(0.3, -1, 0.5), GREY),
        (FLOOR, make.translation(0, 0, -0.2), GREY),
        (make.quad(0.1), make.translation(0, 0, 4), GREY),
    ]
    return among(make.scene(objects, CAMERA, lights, make.world(0.4)), [TUFT], [DROPS])


def with_bits(snapshot, bits):
    """Instances' `Visibility` bits, by row."""
    visibility = snapshot.instances.visibility.copy()
    for row, value in bits.items():
        visibility[row] = value
    return replace(snapshot, instances=replace(snapshot.instances, visibility=visibility))


def without(snapshot, row):
    """An instance shrunk to nothing, in the floor."""
    matrix = snapshot.instances.matrix.copy()
    matrix[row, :3, :3] *= 1e-9
    matrix[row, :3, 3] = 0, 0, -0.2
    return replace(snapshot, instances=replace(snapshot.instances, matrix=matrix))


def image(scene):
    return render(scene, SETTINGS).image()


def rays(seed=1):
    """From around toward the middle, (3, N)."""
    rng = np.random.default_rng(seed)
    o = random_directions(N, seed) * [4, 4, 2] + [0, 0, 2.1]
    d = rng.uniform(-1, 1, (N, 3)) * [1.2, 1.2, 0.6] + [0, 0, 0.6] - o
    return o, d / np.linalg.norm(d, axis=1, keepdims=True)


def test_a_box_moves_among_curves():
    """A slice is the scene of that moment, bit for bit; what is round is in both."""
    snapshot = moving(stage(), {BOX: PATH})
    made = prepare(snapshot)
    assert made.features["motion blur"] == made.features["curves and points"] == ON
    slice_ = made.slices.at(0.3)
    slice_.slices = None  # rendered as it is
    found = image(slice_)
    np.testing.assert_array_equal(found, image(prepare(standing_at(snapshot, slice_.time))))
    assert not np.array_equal(found, image(prepare(standing_at(snapshot, 0.0))))


def assert_slices_are_still_scenes(snapshot, exact=True):
    """A slice is the very picture of the scene that stands still at its time; another time's is not."""
    slice_ = prepare(snapshot).slices.at(0.3)
    slice_.slices = None  # rendered as it is
    found, expected = image(slice_), image(prepare(standing_at(snapshot, slice_.time)))
    if exact:
        np.testing.assert_array_equal(found, expected)
    else:
        assert np.median(np.abs(found - expected)) < 1e-6
        assert abs(found.mean() - expected.mean()) < 0.01 * expected.mean()
    assert np.abs(found - image(prepare(standing_at(snapshot, 0.0)))).max() > 0.05


MOVED = [make.translation(0, 0, 0), make.translation(0.5, 0, 0.2)]
STRETCHED = [np.eye(4), np.diag([1.0, 1, 1.8, 1])]


@pytest.mark.parametrize(
    "who", [(0,), (1,), (0, 1), (0, BOX), (0, 1, BOX)], ids=["curves", "points", "both", "curves, box", "all"]
)
def test_curves_and_points_move(who):
    """Each alone, together, beside triangles that move."""
    assert_slices_are_still_scenes(moving(stage(), {k: PATH if k == BOX else MOVED for k in who}))


def test_curves_and_points_are_stretched():
    """Hulls are large enough for all times, those of the still scene for its own: t is rounded otherwise."""
    assert_slices_are_still_scenes(moving(stage(), {0: STRETCHED, 1: STRETCHED}), exact=False)


def bent(thing):
    """Its points at three times: as they are in the middle, and leaning over; thinner and thicker."""
    lean = np.array([1.0, 0.4, 0], np.float32)
    points = [thing.points + k * lean * thing.points[:, 2:] for k in (-0.5, 0, 0.5)]
    return np.array(points), np.array([thing.radius * f for f in (0.8, 1, 1.2)])


@pytest.mark.parametrize("shape", ["LINEAR", "THICK", "RIBBON"])
def test_curves_bend_and_points_move_apart(shape):
    """Straight pieces are exactly those of the still scene; splines keep the number of their pieces."""
    snapshot = stage()
    first, curves = len(snapshot.meshes), tuple(replace(c, shape=shape) for c in snapshot.curves)
    snapshot = replace(snapshot, curves=curves)
    rounds = {first: bent(curves[0]), first + 1: bent(snapshot.points[0])}
    assert_slices_are_still_scenes(moving(snapshot, {BOX: PATH}, rounds=rounds), shape == "LINEAR")


@pytest.mark.parametrize("row", [0, 1, BALL], ids=["curves", "points", "ball"])
def test_what_the_camera_does_not_see(row):
    """Camera rays find what they would without it, diffuse ones and shadow rays what they would of all."""
    seen = stage()
    apart, gone = with_bits(seen, {row: Visibility.ALL & ~Visibility.CAMERA}), without(seen, row)
    made, whole, rest = (prepare(snapshot) for snapshot in (apart, seen, gone))
    assert made.features["ray visibility"] == ON
    o, d = (np.ascontiguousarray(a.T, np.float32) for a in rays())
    far = np.full(N, FAR, np.float32)
    assert np.allclose(made.geometry.origin, rest.geometry.origin, atol=1e-6)
    kinds = np.where(np.arange(N) % 2, RayKind.CAMERA, RayKind.DIFFUSE | RayKind.REFLECTION).astype(np.int32)
    hits = closest(made.accel, o, d, far.copy(), kinds)
    for kind, expected in ((RayKind.CAMERA, rest), (RayKind.DIFFUSE | RayKind.REFLECTION, whole)):
        lanes = np.flatnonzero(kinds == kind)
        there = closest(expected.accel, o, d, far.copy(), 0)
        same = np.isclose(hits.t[lanes], there.t[lanes], rtol=1e-5)
        assert np.count_nonzero(~same) <= 2, (
            kind
        )  # a ray through a hull's edge may find either of its triangles
    assert np.count_nonzero(closest(rest.accel, o, d, far.copy(), 0).t != hits.t) >= 10
    blocked = clear(made.accel, o, d, far.copy(), RayKind.SHADOW) == 0
    assert np.count_nonzero(blocked != (whole.accel.visible(o, d, far.copy()) == 0)) <= 2


@pytest.mark.parametrize("nested", [False, True])
def test_curves_among_shared_instances(nested, monkeypatch):
    """Rays find the same as where each ball has records of its own, to rounding."""
    balls = [make.translation(*p) for p in np.random.default_rng(2).uniform(-2, 2, (12, 3)) * [1, 1, 0.5]]
    ball = make.sphere(0.4, 10, smooth=True)
    snapshot = among(
        make.scene([(ball, m, RED) for m in balls], CAMERA),
        [TUFT, TUFT],
        [DROPS],
        [UP, make.translation(0.03, 0.02, 0.5), UP],
    )
    mesh = np.where(snapshot.instances.mesh < len(balls), 0, snapshot.instances.mesh)
    snapshot = replace(snapshot, instances=replace(snapshot.instances, mesh=mesh.astype(np.int32)))
    plain = prepare(snapshot)

    def all_alike(*args):
        found = instancing.candidates(*args)
        return found._replace(nested=np.full(len(found.nested), nested))

    monkeypatch.setattr(instancing, "MANY", 0)
    monkeypatch.setattr("pt_engine.scene.placing.candidates", all_alike)
    shared = prepare(snapshot)
    assert shared.geometry.shared is not None
    assert len(shared.geometry.records) < len(plain.geometry.records)
    a, b = (shoot(scene, *rays()) for scene in (plain, shared))
    both, here, there = np.intersect1d(a.lanes, b.lanes, return_indices=True)
    assert abs(len(a.lanes) - len(b.lanes)) <= 4
    assert len(a.lanes) - len(both) <= 4
    a, b = a.si.take(here), b.si.take(there)
    names = [
        np.array([scene.instances.names[k] for k in si.instance]) for scene, si in ((plain, a), (shared, b))
    ]
    same = names[0] == names[1]
    assert np.count_nonzero(~same) <= 4
    rounds = np.char.startswith(names[0], "round")
    assert min(rounds.sum(), (~rounds).sum()) > 200
    np.testing.assert_allclose(b.t[same], a.t[same], rtol=2e-5, atol=2e-5)
    np.testing.assert_allclose(b.p[:, same], a.p[:, same], atol=2e-5)
    np.testing.assert_allclose(b.ng[:, same], a.ng[:, same], atol=1e-3)


def linked(snapshot, receives, blocks, **rows):
    """Sets of two, by row: receivers, blockers and emitters that are not of set 0."""
    sets = {
        name: np.zeros(len(snapshot.instances.mesh), np.int32) for name in ("receiver", "blocker", "emitter")
    }
    for name, which in rows.items():
        sets[name][which] = 1
    return replace(
        snapshot, linking=Linking(np.array(receives, np.uint8), np.array(blocks, np.uint8), **sets)
    )


def test_curves_that_are_no_blockers_cast_no_shadow():
    """A lamp's light on the floor is then that of a scene without them; by default it is not."""
    lamp = (make.quad(0.5), make.translation(0, 0, 9) @ np.diag([1.0, -1, -1, 1]), make.emission(600.0))
    floor = make.scene([(FLOOR, UP, GREY), lamp], make.perspective((0, -1, 7), (0, 0, 0), 0.5))
    thick = tuft(40, 5, 0.1, "THICK")
    snapshot = with_bits(among(floor, [thick]), {0: Visibility.SHADOW})
    links = linked(snapshot, [[1, 1], [1, 1]], [[1, 1], [1, 0]], blocker=[0], emitter=[2])
    depth = {"samples": 16, "max_depth": 2}
    bare, shaded, through = (make.rendered(s, 12, **depth).image()[..., 0] for s in (floor, snapshot, links))
    assert shaded.mean() < 0.98 * bare.mean()
    np.testing.assert_allclose(through.mean(), bare.mean(), rtol=1e-3)  # the same paths


def test_curves_that_receive_no_light_are_dark():
    """Of a lamp's set; the floor under them is lit all the same."""
    lamp = (
        make.quad(1.0),
        make.translation(0, -5, 5) @ make.looking((0, 0, 0), (0, 1, -1)),
        make.emission(60.0),
    )
    camera = make.orthographic((0, -5, 0), (0, 0, 0), 0.1)
    snapshot = among(
        make.scene([(FLOOR, make.translation(0, 0, -2), GREY), lamp], camera), [strand(POST, 0.1)]
    )
    links = linked(snapshot, [[1, 1], [1, 0]], [[1, 1], [1, 1]], receiver=[0], emitter=[2])
    depth = {"samples": 4, "max_depth": 2}
    assert make.rendered(snapshot, 4, **depth).image()[..., :3].min() > 0
    assert (make.rendered(links, 4, **depth).image()[..., :3] == 0).all()


POST = [(0, 0, -1), (0, 0, 1)]


def test_a_strand_that_is_a_holdout_cuts_a_hole():
    camera = make.orthographic((0, -5, 0), (0, 0, 0), 0.1)
    snapshot = among(make.scene([(FLOOR, UP, GREY)], camera, sky=make.world(1.0)), [strand(POST, 0.1)])
    held = with_bits(snapshot, {0: Visibility.ALL | Visibility.HOLDOUT})
    settings = {"samples": 2, "film_transparent": True}
    assert (make.rendered(snapshot, 4, **settings).image()[..., 3] == 1).all()
    assert (make.rendered(held, 4, **settings).image() == 0).all()


def test_a_strand_that_catches_shadows_shows_nothing_without_them():
    """Under a sky, with nothing to shade it, a catcher is as clear as the film."""
    camera = make.orthographic((0, -5, 0), (0, 0, 0), 0.1)
    base = make.scene([(make.quad(1e-3), make.translation(0, 0, -3), GREY)], camera, sky=make.world(1.0))
    caught = with_bits(among(base, [strand(POST, 0.1)]), {0: Visibility.ALL | Visibility.CATCHER})
    found = make.rendered(caught, 6, samples=64, film_transparent=True).image()
    np.testing.assert_allclose(found[..., 3], 0, atol=0.02)
    near = (make.sphere(0.5, 8), make.translation(0, -2, 1.0), GREY)
    shaded = among(make.scene([near], camera, sky=make.world(1.0)), [strand(POST, 0.1)])
    shaded = with_bits(shaded, {0: Visibility.ALL | Visibility.CATCHER})
    assert make.rendered(shaded, 6, samples=64, film_transparent=True).image()[..., 3].mean() > 0.015


def test_strands_shine_also_where_some_objects_cast_no_shadow_in_their_light():
    """They are no lights to sample, so scattered rays that find them count."""
    camera = make.orthographic((0, -5, 0), (0, 0, 0), 0.1)
    wall = (make.quad(1.0), make.looking((0, 0, 0), (0, -1, 0)), GREY)
    base = make.scene([(make.quad(1e-3), make.translation(0, 0, -9), make.emission(5.0)), wall], camera)
    snapshot = among(base, [strand(np.array(POST) + [0.4, -0.3, 0], 0.2)])
    links = linked(snapshot, [[1, 1], [1, 1]], [[1, 1], [1, 0]], blocker=[2], emitter=[0])
    plain, found = (make.rendered(s, 8, samples=32, max_depth=2).image()[..., 0] for s in (snapshot, links))
    assert plain.mean() > 0.1
    np.testing.assert_allclose(found.mean(), plain.mean(), rtol=0.02)


def test_a_saved_scene_is_the_same(tmp_path):
    """With motion and hidden objects, through a file."""
    snapshot = with_bits(moving(stage(), {BOX: PATH}), {0: Visibility.ALL & ~Visibility.CAMERA})
    path = tmp_path / "scene.npz"
    save_snapshot(snapshot, path)
    np.testing.assert_array_equal(image(prepare(load_snapshot(path))), image(prepare(snapshot)))
