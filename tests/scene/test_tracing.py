"""Ambient occlusion and bevel where the answer is known, and wherever they are asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import placed, shoot

from pt_engine.core import keyed
from pt_engine.core.samplers import SAMPLERS
from pt_engine.scene.arrivals import Arrivals
from pt_engine.scene.bevel import cubic_root
from pt_engine.scene.lanes import Lanes
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, Link, MeshData, Node

CAMERA = make.perspective((0, 0, 5), (0, 0, 0))
GREY = make.diffuse(0.5)
N = 20_000


def shining(node: Node, socket: str) -> Graph:
    """Emission of an output of a node."""
    light = Node("Emission", "light", {"Color": Link(0, socket), "Strength": 1.0})
    return Graph("shining", (node, light), {"Surface": Link(1, "Emission")})


def occlusion(distance: float = 1e3, samples: int = 4, normal: object = None, **props: object) -> Graph:
    inputs = {"Color": (1.0, 1.0, 1.0, 1.0), "Distance": distance, "Normal": normal}
    return shining(Node("AmbientOcclusion", "ao", inputs, {"samples": samples, **props}), "AO")


ROUND = shining(Node("Bevel", "bevel", {"Radius": 0.3, "Normal": None}, {"samples": 4}), "Normal")


def noise(n: int, bounce: int = 0) -> np.ndarray:
    return keyed.noise(SAMPLERS["independent"](3).state(np.arange(n), np.zeros(n, np.int64)), bounce)


def looks(scene, origin: object, n: int = N) -> Lanes:
    """`n` looks at one place from above."""
    si = shoot(scene, np.tile(np.asarray(origin, float), (n, 1)), np.tile([0.0, 0, -1], (n, 1))).si
    return Lanes(scene, si, Arrivals.by(1, n)._replace(noise=noise(n)), False)


def value(scene, lanes: Lanes) -> np.ndarray:
    """What the first material that shines shines with."""
    batch = next(b for b in scene.materials.batches if b.has_emission)
    return np.broadcast_to(batch.emission(lanes), (3, lanes.n))


def wall(height: float = 1e4) -> MeshData:
    """A square wall over the x = 0 plane's upper half, facing +x."""
    h = height / 2
    return make.mesh([(0, -h, -1), (0, h, -1), (0, h, h), (0, -h, h)], [(0, 1, 2), (0, 2, 3)], name="wall")


def corner(graph: Graph) -> object:
    """A floor with `graph`, and a grey wall along its middle."""
    return prepare(make.scene([(make.quad(2e4), np.eye(4), graph), (wall(), np.eye(4), GREY)], CAMERA))


def within(values: np.ndarray, expected: float, z: float = 4.0) -> None:
    error = max(float(values.std()) / np.sqrt(values.size), 1e-6)
    assert (
        abs(float(values.mean(dtype=np.float64)) - expected) < z * error + 1e-3
    )  # 10⁻³: the wall has an end


def test_a_wall_hides_half_of_the_sky() -> None:
    """At a floor's edge with an endless wall half of the cosine-weighted hemisphere is open."""
    scene = corner(occlusion())
    within(value(scene, looks(scene, (1e-2, 0, 0.5)))[0], 0.5)


def test_a_wall_hides_less_from_afar() -> None:
    """Up to height h at distance d a wall hides (1 − cos φ)/2, tan φ = h/d, of the hemisphere."""
    low = make.mesh([(0, -1e4, 0), (0, 1e4, 0), (0, 1e4, 3), (0, -1e4, 3)], [(0, 1, 2), (0, 2, 3)])
    graph = occlusion(1e6)
    scene = prepare(make.scene([(make.quad(2e4), np.eye(4), graph), (low, np.eye(4), GREY)], CAMERA))
    within(value(scene, looks(scene, (4.0, 0, 0.5)))[0], 1 - (1 - 4 / 5) / 2)


def test_only_what_is_near_counts() -> None:
    """Walls beyond the distance hide nothing; at distance d = D/2 from one, ∫ over the cap beyond is ¼-ish.

    Rays of length D meet the wall where ω·x > d/D: the projected share of that cap about x at the horizon,
    half of it above, is (acos c − c √(1 − c²))/π with c = d/D.
    """
    for distance, expected in ((0.9, 0.0), (2.0, (np.arccos(0.5) - 0.5 * np.sqrt(0.75)) / np.pi)):
        scene = corner(occlusion(distance))
        within(value(scene, looks(scene, (1.0, 0, 0.5)))[0], 1 - expected)


def test_only_the_own_object_counts() -> None:
    """Another object's wall hides nothing; the own one behind it does."""
    scene = corner(occlusion(only_local=True))
    assert (value(scene, looks(scene, (0.01, 0, 0.5), 500)) == 1).all()
    floor, other = make.quad(2e4), wall()
    both = make.mesh(
        np.concatenate([floor.vertices, other.vertices]),
        np.concatenate([floor.triangles, other.triangles + len(floor.vertices)]),
    )
    screen = make.mesh(
        [(0.005, -1, -1), (0.005, 1, -1), (0.005, 1, 1), (0.005, -1, 1)], [(0, 1, 2), (0, 2, 3)]
    )
    graph = occlusion(only_local=True)
    scene = prepare(make.scene([(both, np.eye(4), graph), (screen, np.eye(4), GREY)], CAMERA))
    within(value(scene, looks(scene, (0.01, 0, 0.5)))[0], 0.5)


def test_inside_looks_the_other_way() -> None:
    """From a closed box's face every inner ray ends on the box, every outer one is free."""
    for inside, expected in ((True, 0.0), (False, 1.0)):
        scene = prepare(make.scene([(make.box(), np.eye(4), occlusion(inside=inside))], CAMERA))
        assert (value(scene, looks(scene, (0.2, 0.3, 3.0), 500)) == expected).all()


def test_without_random_numbers_all_is_open() -> None:
    """Shadow rays and sampled emitters do not look around: 1, and the normal as it is, as in Cycles."""
    scene = corner(occlusion())
    lanes = looks(scene, (0.01, 0, 0.5), 7)
    bare = Lanes(scene, lanes.si, Arrivals.by(1, 7), False)
    assert (value(scene, bare) == 1).all()
    assert bare.bevelled(np.ones(1, np.float32), 4, 0, bare.ns) is bare.ns


def test_lanes_do_not_depend_on_their_neighbours() -> None:
    """Any selection of lanes gives the same bits, for occlusion and for bevels."""
    scene = corner(occlusion())
    lanes = looks(scene, (0.01, 0, 0.5), 300)
    some = np.random.default_rng(1).permutation(300)[:40]
    came = Arrivals.by(1, 300)._replace(noise=noise(300)).take(some)
    part = Lanes(scene, lanes.si.take(some), came, False)
    np.testing.assert_array_equal(value(scene, lanes)[:, some], value(scene, part))
    radius = np.full(1, 0.3, np.float32)
    np.testing.assert_array_equal(
        lanes.bevelled(radius, 3, 9, lanes.ns)[:, some], part.bevelled(radius, 3, 9, part.ns)
    )


def test_numbers_are_uniform_and_keyed() -> None:
    """Means and correlations of other keys, bounces and points of the spread within 5 standard errors."""
    other = SAMPLERS["independent"](3).state(np.arange(N), np.ones(N, int))
    rows = [
        *keyed.uniforms(keyed.bits(noise(N), 1), 0),
        *keyed.uniforms(keyed.bits(noise(N), 2), 0),
        *keyed.uniforms(keyed.bits(noise(N, 1), 1), 0),
        *keyed.uniforms(keyed.bits(keyed.noise(other, 0), 1), 0),
    ]
    for row in rows:
        assert abs(row.mean() - 0.5) < 5 / np.sqrt(12 * N)
        assert row.min() >= 0
        assert row.max() < 1
    correlation = np.corrcoef(rows) - np.eye(len(rows))
    assert np.abs(correlation).max() < 5 / np.sqrt(N)
    sixteen = np.array([keyed.uniforms(keyed.bits(noise(50), 1), k) for k in range(16)])  # (16, 2, lanes)
    for lane in (sixteen * 4).astype(int).transpose(2, 0, 1):
        assert len({tuple(cell) for cell in lane}) == 16  # one in each cell of 4 × 4


def test_the_cubic_is_inverted() -> None:
    """F(x) = ξ with F = 10 x² − 20 x³ + 15 x⁴ − 4 x⁵, to some roundings."""
    xi = np.linspace(0.002, 0.995, 500).astype(np.float32)
    x = cubic_root(xi).astype(float)
    np.testing.assert_allclose(10 * x**2 - 20 * x**3 + 15 * x**4 - 4 * x**5, xi, atol=3e-6)


def test_a_bevel_leaves_planes_and_tilts_edges() -> None:
    """In the middle of a box's face the normal is the face's; on its edge it is the mean of two faces'."""
    scene = prepare(make.scene([(make.box(), np.eye(4), ROUND)], CAMERA))
    flat = looks(scene, (0.1, 0.2, 3.0), 200)
    np.testing.assert_allclose(flat.bevelled(np.full(1, 0.3, np.float32), 4, 1, flat.ns), flat.ns, atol=1e-5)
    edge = looks(scene, (1 - 1e-4, 0.2, 3.0), 200)
    normal = edge.bevelled(np.full(1, 0.3, np.float32), 256, 1, edge.ns).mean(axis=1)
    np.testing.assert_allclose(normal[0], normal[2], atol=0.02)
    assert abs(normal[1]) < 0.02
    assert normal[0] > 0.6


def test_a_bevel_stops_at_the_object() -> None:
    """Another box that touches does not round the face, nor one in front of it."""
    boxes = [(make.box(), placed(np.eye(3), (2 * k, 0, 0)), ROUND) for k in range(2)]
    lid = (make.quad(8.0), placed(np.eye(3), (0, 0, 1.1)), GREY)
    scene = prepare(make.scene([*boxes, lid], CAMERA))
    n = 300
    si = shoot(scene, np.tile([0.5, 0.2, 1.05], (n, 1)), np.tile([0.0, 0, -1], (n, 1))).si
    lanes = Lanes(scene, si, Arrivals.by(1, n)._replace(noise=noise(n)), False)
    np.testing.assert_allclose(
        lanes.bevelled(np.full(1, 0.4, np.float32), 4, 1, lanes.ns), lanes.ns, atol=1e-5
    )


def test_blurred_paths_do_without_bevels() -> None:
    """After a bounce of density below 8 sr⁻¹ the normal is as it was, as in Cycles."""
    scene = prepare(make.scene([(make.box(), np.eye(4), ROUND)], CAMERA))
    lanes = looks(scene, (1 - 1e-4, 0.2, 3.0), 50)
    came = Arrivals.by(1, 50)._replace(noise=noise(50), sharpness=np.full(50, 7.9, np.float32))
    blurred = Lanes(scene, lanes.si, came, False)
    np.testing.assert_array_equal(blurred.bevelled(np.full(1, 0.3, np.float32), 4, 1, blurred.ns), blurred.ns)


@pytest.mark.parametrize("threads", [1, 3])
def test_pictures_do_not_depend_on_threads(threads: int) -> None:
    """An occluded, bevelled corner is the same, bit for bit, however the work is cut."""
    node = Node("AmbientOcclusion", "ao", {"Color": make.WHITE, "Distance": 1.0}, {"samples": 2})
    round_ = Node("Bevel", "bevel", {"Radius": 0.2, "Normal": None}, {"samples": 2})
    surface = Node("BsdfDiffuse", "d", {"Color": Link(0, "Color"), "Normal": Link(1, "Normal")})
    graph = Graph("m", (node, round_, surface), {"Surface": Link(2, "BSDF")})
    view = make.perspective((4, -5, 3), (0, 0, 0))
    objects = [(make.box(), np.eye(4), graph), (make.quad(20.0), placed(np.eye(3), (0, 0, -1)), graph)]
    snapshot = replace(make.scene(objects, view), world=make.world(1.0))
    one = make.rendered(snapshot, 24, samples=4, threads=1).image()
    other = make.rendered(snapshot, 24, samples=4, threads=threads, lanes=97).image()
    np.testing.assert_array_equal(one, other)
