"""Rays that do not see every object find what they would if the others were not there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import random_directions

from pt_engine.core.raykind import RayKind
from pt_engine.scene.accel import FAR, Accel
from pt_engine.scene.geometry import place
from pt_engine.scene.prepare import prepare
from pt_engine.scene.sighted import SETS, Sighted, sighted, trees_of
from pt_engine.scene.snapshot import Linking, Visibility

GREY = make.diffuse(0.5)
N = 20_000
KINDS = {
    RayKind.CAMERA: Visibility.CAMERA,
    RayKind.DIFFUSE | RayKind.REFLECTION: Visibility.DIFFUSE,
    RayKind.GLOSSY | RayKind.REFLECTION: Visibility.GLOSSY,
    RayKind.DIFFUSE | RayKind.TRANSMISSION: Visibility.TRANSMISSION,
    RayKind.SHADOW: Visibility.SHADOW,
}


def crowd(seed=3):
    """Forty boxes, some in each other's planes, each hidden from kinds of rays drawn at random."""
    rng = np.random.default_rng(seed)
    rows = [(make.box(0.5), make.translation(*np.round(rng.uniform(-2, 2, 3), 1)), GREY) for _ in range(40)]
    snapshot = make.scene(rows, make.perspective((0, -5, 0), (0, 0, 0)))
    bits = rng.integers(0, 32, 40).astype(np.uint8)
    return replace(snapshot, instances=replace(snapshot.instances, visibility=bits))


def rays(seed=5):
    rng = np.random.default_rng(seed)
    o = np.ascontiguousarray(rng.uniform(-3, 3, (N, 3)).T, np.float32)
    return o, np.ascontiguousarray(random_directions(N, seed).T, np.float32)


@pytest.fixture(name="many", scope="module")
def _many():
    snapshot = crowd()
    return snapshot, place(snapshot)


def trees(snapshot, placed, spare):
    """With triangles stored several times, or once."""
    bits = snapshot.instances.visibility
    classes, kind = np.unique(bits, return_inverse=True)
    order = [bit for bit in KINDS.values() if bit != Visibility.SHADOW]
    rows = [np.ones(len(classes), np.bool_)]
    rows += [(classes & bit) != 0 for bit in (*order, Visibility.SHADOW)]
    return Sighted(trees_of(placed, kind, np.stack(rows), spare))


@pytest.mark.parametrize("spare", [-1, 1 << 20])
def test_each_kind_of_ray_finds_what_it_sees(many, spare):
    """Against a tree of the visible instances alone, ray by ray; kinds mixed among the lanes."""
    snapshot, placed = many
    made = trees(snapshot, placed, spare)
    o, d = rays()
    kinds = np.array(list(KINDS), np.int32)[np.arange(N) % len(KINDS)]
    found = made.intersect(o, d, np.full(N, FAR, np.float32), kinds)
    clear = made.visible(o, d, np.full(N, 2, np.float32), kinds)
    of_triangle = np.repeat(snapshot.instances.visibility, np.diff(placed.first_triangle))
    for kind, bit in KINDS.items():
        lanes = np.flatnonzero(kinds == kind)
        seen = np.flatnonzero(of_triangle & bit)
        plain = Accel(placed.vertices, placed.triangles[seen])
        here = np.ascontiguousarray(o[:, lanes]), np.ascontiguousarray(d[:, lanes])
        hits = plain.intersect(*here, np.full(len(lanes), FAR, np.float32))
        np.testing.assert_array_equal(found.t[lanes], hits.t)
        met = hits.prim >= 0
        assert (found.prim[lanes] >= 0).tolist() == met.tolist()
        assert ((of_triangle[found.prim[lanes][met]] & bit) != 0).all()
        np.testing.assert_array_equal(clear[lanes], plain.visible(*here, np.full(len(lanes), 2, np.float32)))


def test_a_ray_that_is_off_stays_off(many):
    made = trees(*many, -1)
    o, d = rays()
    off = np.full(N, -1, np.float32)
    assert (made.intersect(o, d, off.copy(), RayKind.CAMERA).prim < 0).all()
    assert (made.visible(o, d, off) == 0).all()


def test_all_seen_by_all_is_a_plain_tree():
    snapshot = make.scene([(make.box(), np.eye(4), GREY)], make.perspective((0, -5, 0), (0, 0, 0)))
    assert isinstance(sighted(place(snapshot), snapshot.instances), Accel)
    assert prepare(snapshot).features["ray visibility"].startswith("off")


def test_lights_of_a_set_pass_what_is_no_blocker():
    """Two sheets above each other; the upper one casts no shadow in the light of set 1."""
    rows = [(make.quad(), make.translation(0, 0, z), GREY) for z in (1, 2)]
    snapshot = make.scene(rows, make.perspective((0, -5, 0), (0, 0, 0)))
    ones = np.ones((1, 2), np.uint8)
    blocks = np.array([[1, 1], [1, 0]], np.uint8)
    sets = np.array([0, 1], np.int32)
    links = Linking(ones, blocks, np.zeros(2, np.int32), sets, np.zeros(2, np.int32))
    made = sighted(place(snapshot), snapshot.instances, links)
    kinds = np.array([RayKind.SHADOW + (s << SETS) for s in (0, 1, 0, 1)], np.int32)
    z = np.array([0.0, 0.0, -1.0, -1.0], np.float32)  # from between the sheets, and from below both
    o = np.stack([np.full(4, 0.1, np.float32), np.full(4, 0.1, np.float32), z])
    up = np.repeat(np.array([[0], [0], [1]], np.float32), 4, axis=1)
    clear = made.visible(o, up, np.full(4, FAR, np.float32), kinds)
    assert clear.tolist() == [0, -1, 0, 0]
