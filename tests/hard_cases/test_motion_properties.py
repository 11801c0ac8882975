"""Shutters and ways of matrices over their whole parameter spaces."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from support.spaces import EXAMPLES

from pt_engine.scene.matrix_path import MatrixPath
from pt_engine.scene.shutter import Shutter

OPENNESS = st.one_of(st.floats(0, 1), st.sampled_from([0.0, 1e-30, 1e30, -1.0, np.nan, np.inf]))


@EXAMPLES
@given(st.lists(OPENNESS, min_size=2, max_size=12))
def test_times_of_a_shutter_are_drawn_by_how_far_it_is_open(openness):
    """F(t(u)) = u to 1e-5 with F integrated anew, t within [0, 1] and growing."""
    u = np.linspace(0, 1 - 2**-24, 41)
    shutter = Shutter(np.array(openness, np.float32))
    t = np.array([shutter.time(float(x)) for x in u])
    assert np.isfinite(t).all()
    assert t.min() >= 0
    assert t.max() <= 1
    assert (np.diff(t) >= 0).all()
    s = np.array(openness, np.float32).astype(float)
    s = np.where(np.isfinite(s) & (s > 0), s, 0)
    s = s if s.any() else np.ones(len(s))
    knots = np.linspace(0, 1, len(s))
    cumulated = np.concatenate([[0], np.cumsum((s[1:] + s[:-1]) / 2) / (len(s) - 1)])
    k = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(s) - 2)
    reached = cumulated[k] + (s[k] + np.interp(t, knots, s)) / 2 * (t - knots[k])
    np.testing.assert_allclose(reached / cumulated[-1], u, atol=1e-5)


ELEMENT = st.one_of(st.floats(-3, 3), st.sampled_from([0.0, 1.0, -1.0, 1e-6, 1e6]))
MATRIX = st.lists(ELEMENT, min_size=12, max_size=12)


@EXAMPLES
@given(st.lists(MATRIX, min_size=2, max_size=4), st.floats(0, 1))
def test_ways_of_matrices_are_finite_and_lead_through_their_steps(rows, time):
    """Of any matrices, flat, mirrored and vanished ones, too: to 1e-9 of their size at each step."""
    steps = np.zeros((1, len(rows), 4, 4))
    steps[0, :, :3] = np.array(rows).reshape(-1, 3, 4)
    steps[0, :, 3, 3] = 1
    path = MatrixPath.of(steps)
    assert np.isfinite(path.at(time)).all()
    for k in range(len(rows)):
        np.testing.assert_allclose(
            path.at(k / (len(rows) - 1))[0], steps[0, k], atol=1e-9 * np.abs(steps[0, k]).max() + 1e-9
        )


def test_what_is_not_finite_at_one_step_stays_apart():
    """The other instances' ways do not know of it."""
    good = np.tile(np.eye(4), (1, 2, 1, 1))
    for bad in (np.nan, np.inf, 1e300):
        both = np.concatenate([good, np.full_like(good, bad)])
        np.testing.assert_array_equal(MatrixPath.of(both).at(0.3)[0], MatrixPath.of(good).at(0.3)[0])


@EXAMPLES
@given(st.lists(st.sampled_from([0.0, 1e-9, 0.5, 2.0]), min_size=3, max_size=3), st.booleans())
def test_what_shrinks_without_turning_does_not_turn(size, mirrored):
    """From a turned (and mirrored) body to one with axes of length 0: R diag(s(t)) at all times."""
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    begin = np.array([-1.0 if mirrored else 1.0, 1, 1])
    end = np.array(size) * begin
    steps = np.tile(np.eye(4), (1, 2, 1, 1))
    steps[0, :, :3, :3] = turn @ np.diag(begin), turn @ np.diag(end)
    for time in (0.0, 0.25, 0.5, 1.0):
        expected = turn @ np.diag((1 - time) * begin + time * end)
        np.testing.assert_allclose(MatrixPath.of(steps).at(time)[0, :3, :3], expected, atol=1e-12)
