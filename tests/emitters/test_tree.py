"""The light tree's groups hold what is in them; cells are found where surfaces are."""

import numpy as np
import pytest
from support.chi2 import chi2_counts
from support.lamps import DELTA, SIZED, floor, triangles

from pt_engine.core.distributions import AliasTables
from pt_engine.emitters.base import Lamp
from pt_engine.emitters.faces import Faces
from pt_engine.emitters.outline import joined, of_lamps
from pt_engine.emitters.places import Places
from pt_engine.emitters.tree import LightTree


def outlines(faces=30):
    lamps = [
        Lamp(data, np.ones(3), data.matrix[:3, 3]) for data in (SIZED | DELTA).values() if data.kind != "SUN"
    ]
    return joined(of_lamps(lamps, np.full(len(lamps), 10.0)), Faces(triangles(faces)).outlines())


def test_groups_hold_their_emitters():
    """Boxes inside of boxes, axes within cones: angle to the group's axis + own spread ≤ the group's."""
    emitters = outlines()
    count = len(emitters.intensity)
    tree = LightTree(emitters, np.full(count, 1.0 / count))
    np.testing.assert_array_equal(tree.emitter_at[tree.leaf_of], np.arange(count))
    np.testing.assert_allclose(tree.groups.intensity[1], emitters.intensity.sum())
    np.testing.assert_allclose(tree.weight[1], 1.0)
    for emitter, leaf in enumerate(tree.leaf_of):
        group = (1 << tree.levels) + leaf
        while group := group >> 1:
            outer = tree.groups.take(np.array([group]))
            assert (outer.low[0] <= emitters.low[emitter]).all()
            assert (outer.high[0] >= emitters.high[emitter]).all()
            cos = emitters.axis[emitter] @ outer.axis[0]
            angle = np.arccos(np.clip(abs(cos) if outer.twofold[0] else cos, -1, 1))
            assert min(angle + emitters.spread[emitter], np.pi) <= outer.spread[0] + 1e-6
            assert emitters.reach[emitter] <= outer.reach[0]


def test_emitters_are_drawn_from_a_group_by_their_weights():
    """χ² for a group in the middle of the tree."""
    emitters = outlines()
    chance = np.full(len(emitters.intensity), 1.0 / len(emitters.intensity))
    tree, n = LightTree(emitters, chance), 100_000
    group = (1 << (tree.levels - 3)) + 3
    drawn = tree.draw(np.full(n, group, np.int32), np.random.default_rng(1).random(n, np.float32))
    first = int(tree.first_leaf(np.array([group]))[0])
    weights = tree.weight[(1 << tree.levels) + first :][:8]
    assert chi2_counts(np.bincount(drawn - first, minlength=8), n * weights / weights.sum()) > 1e-4


def test_tables_of_different_lengths_side_by_side():
    """χ² of draws from each, and of what is left of the uniform numbers."""
    rng, n = np.random.default_rng(2), 100_000
    blocks = [rng.random((3, 5)), np.array([[0.0, 2.0, 1.0, 0.0]]), np.zeros((1, 3))]
    tables = AliasTables(blocks)
    assert tables.size == 22
    for first, weights in ((5, blocks[0][1]), (15, blocks[1][0]), (19, np.array([1.0, 0.0, 0.0]))):
        drawn, rest = tables.sample(np.full(n, first), len(weights), rng.random(n, np.float32))
        counts = np.bincount(drawn, minlength=len(weights))
        assert (counts[weights == 0] == 0).all()
        assert chi2_counts(counts, n * weights / weights.sum()) > 1e-4
        assert chi2_counts(np.histogram(rest, 20, (0, 1))[0], np.full(20, n / 20)) > 1e-4


@pytest.mark.parametrize("part", [1.0, 0.05])
@pytest.mark.parametrize("turn", [0.0, 0.3, np.pi / 4])
def test_every_point_on_a_surface_is_in_a_place(turn, part):
    """Both sides of a tilted square, its edges and corners, also at 45° where two axes are as near.

    `part` of it has all emitters: a finer grid lies there.
    """
    vertices, faces = floor()
    c, s = np.cos(turn), np.sin(turn)
    vertices = (vertices @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])).astype(np.float32)
    places = Places(vertices, faces, 4000, True, (part * vertices.min(axis=0), part * vertices.max(axis=0)))
    b = np.random.default_rng(3).random((2, 5000))
    b[:, :50] = np.round(b[:, :50])
    e1, e2 = vertices[1] - vertices[0], vertices[3] - vertices[0]
    p = vertices[0] + b[0][:, None] * e1 + b[1][:, None] * e2
    normal = np.cross(e1, e2)
    normal /= np.sqrt(normal @ normal)
    for side in (1.0, -1.0):
        n = np.repeat((side * normal)[:, None], len(p), axis=1).astype(np.float32)
        number = places.number(np.ascontiguousarray(p.T, np.float32), n)
        assert (number > 0).all()
        np.testing.assert_allclose(places.receivers.normal[number - 1], n.T, atol=1e-6)
        outside = np.maximum(places.receivers.low[number - 1] - p, p - places.receivers.high[number - 1])
        assert outside.max() < 1e-5
    size = (places.receivers.high - places.receivers.low).max(axis=1)
    assert size.min() < 0.07 if part < 1 else size.max() > 0.1
