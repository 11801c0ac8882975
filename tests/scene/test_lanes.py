"""What shader programs see: positions, normals and sides, object data, and any selection of lanes alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import lanes_of, placed, random_directions, rotation, shoot

from pt_engine.core import vectors
from pt_engine.core.raykind import RayKind
from pt_engine.core.view import View
from pt_engine.scene.arrivals import Arrivals
from pt_engine.scene.attributes import color_layer, generated_layer, position_layer, tangent_layer, uv_layer
from pt_engine.scene.geometry import flatten
from pt_engine.scene.lanes import Lanes
from pt_engine.scene.moved import moved, steps
from pt_engine.scene.prepare import prepare
from pt_engine.scene.raised_normal import raised_normal
from pt_engine.scene.sky_lanes import SkyLanes

CAMERA = make.perspective((0, 0, 5), (0, 0, 0))
GREY = make.diffuse(0.5)


def with_all_layers(snapshot):
    """A prepared scene with every attribute table, whatever its materials read."""
    scene, geometry = prepare(snapshot), flatten(snapshot)
    scene.layers["uv", "map"] = uv_layer(snapshot, geometry, "map")
    scene.layers["color", "paint"] = color_layer(snapshot, geometry, "paint")
    scene.layers["generated", ""] = generated_layer(snapshot, geometry)
    scene.layers["position", ""] = position_layer(snapshot, geometry)
    scene.layers["tangent", "map"] = tangent_layer(snapshot, geometry, "map")
    return scene


def zoo(count=6):
    """Balls with uv and colour, each turned, scaled and mirrored in its own way."""
    rng = np.random.default_rng(8)
    ball = make.sphere(1.0, 10)
    corners = np.arange(3 * len(ball.triangles), dtype=np.int32).reshape(-1, 3)
    p = ball.vertices[ball.triangles.ravel()]
    ball = replace(
        ball,
        corner_index=corners,
        uvs={"map": np.ascontiguousarray(p[:, :2])},
        colors={"paint": np.concatenate([p, p[:, :1]], axis=1)},
    )
    scales = rng.uniform(0.3, 1.2, (count, 3)) * rng.choice([-1, 1], (count, 3))
    matrices = [placed(rotation(k) @ np.diag(s), (4 * k, 0, 0)) for k, s in enumerate(scales)]
    snapshot = make.scene([(ball, m, GREY) for m in matrices], CAMERA)
    instances = replace(
        snapshot.instances,
        random=rng.random(count).astype(np.float32),
        color=rng.random((count, 4)).astype(np.float32),
        pass_index=np.arange(count, dtype=np.int32) * 3,
    )
    return replace(snapshot, instances=instances), np.array(matrices)


@pytest.fixture(name="hits", params=["outside", "inside"])
def _hits(request):
    """Scene, hits all over the balls from one side, and the instances' matrices."""
    snapshot, matrices = zoo()
    scene = with_all_layers(snapshot)
    place = np.repeat(matrices[:, :3, 3], 300, axis=0)
    d = random_directions(len(place), 2)
    o = place if request.param == "inside" else place - 1.4 * d + 0.05 * random_directions(len(place), 3)
    return scene, shoot(scene, o, d), matrices, request.param


FIELDS = ("p", "ng", "wi", "bound", "facing", "prim", "t", "u", "v", "surface", "instance", "emitter", "back")
ATTRIBUTES = {
    "position": lambda lanes: lanes.position,
    "ns": lambda lanes: lanes.ns,
    "material": lambda lanes: lanes.material,
    "uv": lambda lanes: lanes.uv("map"),
    "color": lambda lanes: lanes.color("paint"),
    "generated": lambda lanes: lanes.generated(),
    "object position": lambda lanes: lanes.object_position(),
    "tangent": lambda lanes: lanes.object_tangent("map")[0],
    "edges": lambda lanes: np.stack(lanes.edges()),
    "barycentric": lambda lanes: lanes.barycentric(),
    "object random": lambda lanes: lanes.object_random(),
    "object color": lambda lanes: lanes.object_color(),
    "object index": lambda lanes: lanes.object_index(),
    "object location": lambda lanes: lanes.object_location(),
    "ray length": lambda lanes: lanes.ray_length,
    "backfacing": lambda lanes: lanes.backfacing,
}


@pytest.mark.parametrize("name", FIELDS)
def test_parts_and_takes_are_the_same_lanes(hits, name):
    """A slice of a take of a slice: index arithmetic, nothing else."""
    _, shot, _, _ = hits
    si = shot.si
    whole = getattr(si, name)
    span, index = slice(40, 400), np.random.default_rng(1).permutation(360)[:200]
    part = si.part(span)
    np.testing.assert_array_equal(getattr(part, name), whole[..., span])
    np.testing.assert_array_equal(getattr(part.take(index), name), whole[..., span][..., index])
    np.testing.assert_array_equal(
        getattr(si.take(index).part(slice(5, 50)), name), whole[..., index][..., 5:50]
    )
    assert si.part(slice(0, 0)).size == si.take(np.zeros(0, np.intp)).size == 0
    assert part.take(index).size == 200


@pytest.mark.parametrize("name", ATTRIBUTES)
def test_no_lane_depends_on_its_neighbours(hits, name):
    """Bit for bit the same in any selection, alone as well; and float32 throughout."""
    scene, shot, _, _ = hits
    read = ATTRIBUTES[name]
    whole = read(lanes_of(scene, shot.si, smooth=True))
    assert whole.shape[-1] == shot.si.size
    assert whole.dtype in (np.float32, np.int32)
    for index in (np.array([7]), np.random.default_rng(2).permutation(shot.si.size)[:123]):
        some = read(lanes_of(scene, shot.si.take(index), smooth=True))
        np.testing.assert_array_equal(some, whole[..., index])


def test_everything_faces_the_viewer(hits):
    """ng·wi ≥ 0; ns on ng's side, and unit; backfacing as the side says, mirrored or not."""
    scene, shot, _, side = hits
    lanes = lanes_of(scene, shot.si, smooth=True)
    assert vectors.dot(lanes.ng, lanes.wi).min() >= 0
    assert vectors.dot(lanes.ng, lanes.ns).min() > 0
    np.testing.assert_allclose(vectors.length(lanes.ns), 1, atol=1e-6)
    np.testing.assert_array_equal(lanes.backfacing, 0 if side == "outside" else 1)
    flat = lanes_of(scene, shot.si)
    assert flat.ns is flat.ng


def test_shading_normals_are_the_ellipsoids(hits):
    """Inverse transpose of the ball's n = p: within the faceting, π/10 across a triangle's edge, squared."""
    scene, shot, matrices, side = hits
    lanes = lanes_of(scene, shot.si, smooth=True)
    inverse = np.linalg.inv(matrices[:, :3, :3])[shot.si.instance]
    world = lanes.position.astype(np.float64).T - matrices[shot.si.instance, :3, 3]
    n = np.einsum("nji,nj->ni", inverse, np.einsum("nij,nj->ni", inverse, world))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    cosine = (lanes.ns.T * n).sum(axis=1) * (1 if side == "outside" else -1)
    assert cosine.min() > 1 - 0.05
    assert np.median(cosine) > 1 - 0.005


def test_object_space_and_what_hangs_on_it(hits):
    """On the ball object position = (1 − u − v) a + … ; uv and colour were painted from it.

    Rounding: 2⁻²⁴ of the 10 that the scene is wide, over a scale of 0.3.
    """
    scene, shot, _, _ = hits
    lanes = lanes_of(scene, shot.si, smooth=True)
    p = lanes.object_position()
    np.testing.assert_allclose(lanes.uv("map"), p[:2], atol=1e-5)
    np.testing.assert_allclose(lanes.color("paint"), p[[0, 1, 2, 0]], atol=1e-5)
    np.testing.assert_allclose(lanes.generated(), p * 0.5 + 0.5, atol=1e-5)


def test_edges_are_the_triangles_and_turned_from_behind(hits):
    """Corner 0 + u·(edge to 1) + v·(edge to 2) is where the ray has hit; to rounding."""
    scene, shot, matrices, side = hits
    lanes = lanes_of(scene, shot.si)
    si, turned = shot.si, 1 if side == "outside" else -1
    corner, _, _ = scene.layer("position", "").corners(si.prim, si.instance)
    place = matrices[si.instance]
    world = np.einsum("nij,jn->in", place[:, :3, :3], corner.astype(np.float64)) + place[:, :3, 3].T
    first, second = (edge * turned for edge in lanes.edges())
    np.testing.assert_allclose(world + si.u * first + si.v * second, lanes.position, atol=1e-4)


def test_object_info(hits):
    scene, shot, matrices, _ = hits
    lanes, instance = lanes_of(scene, shot.si), shot.si.instance
    np.testing.assert_array_equal(instance, np.repeat(np.arange(6), 300)[shot.lanes])
    np.testing.assert_array_equal(lanes.object_random(), scene.instances.random[instance])
    np.testing.assert_array_equal(lanes.object_color(), scene.instances.color[instance].T)
    np.testing.assert_array_equal(lanes.object_index(), 3 * instance)
    np.testing.assert_allclose(lanes.object_location(), matrices[instance, :3, 3].T)
    np.testing.assert_array_equal(lanes.material, 1)


@pytest.mark.parametrize("away", [0.0, 1e4, 1e6])
def test_positions_are_in_the_world_however_far_it_is(away):
    """Recentred by `origin`: the position is exact to float32 of the world's own numbers."""
    centre = np.array([away, -away / 2, away / 4])
    scene = prepare(make.scene([(make.sphere(1.0, 64), placed(rotation(), centre), GREY)], CAMERA))
    d = random_directions(500, 4)
    shot = shoot(scene, centre + 3 * d, -d)
    np.testing.assert_allclose(shot.si.t, 2, atol=0.002)  # recentred: no digit of the distance is lost
    p = lanes_of(scene, shot.si).position
    assert p.dtype == np.float32
    np.testing.assert_allclose(p, (centre + d).T, atol=0.002 + 2.0**-23 * away)
    np.testing.assert_allclose(lanes_of(scene, shot.si).object_location(), centre[:, None] * np.ones(500))


def test_how_a_ray_came_is_what_the_program_sees():
    scene = prepare(make.scene([(make.quad(), np.eye(4), GREY)], CAMERA))
    si = shoot(scene, np.tile((0.1, 0.2, 3), (4, 1)), np.tile((0, 0, -1), (4, 1))).si
    names = ("kind", "depth", "passed", "diffuse_depth", "glossy_depth", "transmission_depth", "portal_depth")
    rows = {name: np.arange(k, k + 4, dtype=np.int32) for k, name in enumerate(names)}
    came = Arrivals.by(0, 4)._replace(travelled=np.arange(4, dtype=np.float32), **rows)
    lanes = Lanes(scene, si, came, False)
    assert lanes.ray_kind.tolist() == [0, 1, 2, 3]
    assert lanes.depth.tolist() == [1, 2, 3, 4]
    assert lanes.transparent_depth.tolist() == [2, 3, 4, 5]
    for k, kind in enumerate(("diffuse", "glossy", "transmission", "portal")):
        assert lanes.depth_of(kind).tolist() == list(range(3 + k, 7 + k))
    np.testing.assert_allclose(lanes.ray_length, [3, 4, 5, 6])  # with what came before a transparent surface


def test_a_moved_lane_reads_attributes_where_it_has_moved(hits):
    """uv is linear in object space on the ball's facets: Δuv = M⁻¹ step; the steps lie in the face.

    Seen from inside attributes change the other way, as in Cycles.
    """
    scene, shot, _, side = hits
    turn = -1 if side == "inside" else 1
    scene.pixel_angle = 0.05  # larger than a pixel, so that differences show in float32
    lanes = lanes_of(scene, shot.si)
    dx, dy = steps(lanes, 0.1)
    for step in (dx, dy):
        assert np.abs(vectors.dot(step, lanes.ng)).max() <= 1e-6 * vectors.length(step).max()
        there = moved(lanes, step)
        change = lanes.to_object_vector(step)[:2]
        np.testing.assert_allclose(there.uv("map") - lanes.uv("map"), turn * change, atol=2e-5)
        np.testing.assert_allclose(there.position, lanes.position + step, atol=1e-6)
    np.testing.assert_allclose(
        vectors.dot(vectors.cross(dx, dy), lanes.ng), vectors.length(dx) ** 2, rtol=1e-4
    )


def test_lanes_of_one_object_see_what_they_see_among_those_of_others(hits):
    """One matrix for all is the matrix of each: not a bit differs from lanes gathered one by one."""
    scene, shot, _, _ = hits
    whole, name = lanes_of(scene, shot.si), shot.si.instance
    index = np.flatnonzero(name == name[0])
    assert 0 < len(index) < whole.n
    alone = lanes_of(scene, shot.si.take(index))
    for value in ("object_position", "object_normal"):
        np.testing.assert_array_equal(getattr(alone, value)(), getattr(whole, value)()[:, index])
    step = np.ones((3, whole.n), np.float32)
    there = moved(alone, step[:, index]).uv("map")
    np.testing.assert_array_equal(there, moved(whole, step).uv("map")[:, index])


def test_each_normal_is_raised_for_itself_whatever_was_asked_before(hits):
    scene, shot, _, _ = hits
    lanes = lanes_of(scene, shot.si)
    normals = [
        vectors.normalize(lanes.ng + np.float32(a) * random_lanes(lanes.n, k)) for k, a in ((1, 1), (2, 3))
    ]
    for normal in (*normals, normals[0]):
        np.testing.assert_array_equal(lanes.raised(normal), raised_normal(lanes.ng, lanes.wi, normal))


def random_lanes(n, seed):
    return np.random.default_rng(seed).normal(size=(3, n)).astype(np.float32)


def test_the_sky_sees_directions():
    """Position, normal and Generated are the ray's direction, as in Blender; it has no object."""
    d = np.ascontiguousarray(random_directions(5, 6).T, np.float32)
    sky = SkyLanes(d, Arrivals.by(RayKind.CAMERA, 5), View())
    for value in (sky.position, sky.generated(), sky.object_position(), -sky.wi, -sky.ns, -sky.ng):
        np.testing.assert_array_equal(value, d)
    zeros = (sky.uv(""), sky.color(""), sky.barycentric(), sky.object_random(), sky.object_color())
    assert all(
        (z == 0).all() and z.shape[-1] == 5 for z in (*zeros, sky.object_index(), sky.object_location())
    )
    assert sky.ray_length.min() >= 1e30
    assert (sky.depth == 1).all()
    assert (sky.backfacing == 0).all()
