"""Vectors against float64, and frames that are frames."""

import numpy as np
import pytest

from pt_engine.core import vectors
from pt_engine.core.frames import frame, to_local, to_world

rng = np.random.default_rng(7)


def directions(n=100_000):
    v = rng.normal(size=(3, n))
    return (v / np.linalg.norm(v, axis=0)).astype(np.float32)


def test_products_agree_with_float64():
    a, b = rng.normal(size=(2, 3, 1000)).astype(np.float32)
    exact = np.float64
    np.testing.assert_allclose(vectors.dot(a, b), (a.astype(exact) * b).sum(0), atol=2e-6)
    np.testing.assert_allclose(vectors.cross(a, b), np.cross(a.astype(exact), b, axis=0), atol=2e-6)
    np.testing.assert_allclose(vectors.length(a), np.linalg.norm(a.astype(exact), axis=0), rtol=3e-7)
    assert vectors.dot(a, b[:, :1]).shape == (1000,)
    assert vectors.dot(a, b).dtype == vectors.cross(a, b).dtype == np.float32


def test_normalize_is_unit_and_leaves_zero():
    v = (rng.normal(size=(3, 1000)) * 10.0 ** rng.uniform(-15, 15, 1000)).astype(np.float32)
    np.testing.assert_allclose(np.linalg.norm(vectors.normalize(v).astype(float), axis=0), 1, atol=3e-7)
    assert not vectors.normalize(np.zeros((3, 4), np.float32)).any()


def test_reflection_keeps_the_normal_part_and_turns_the_rest():
    w, n = directions(), directions()
    r = vectors.reflect(w, n)
    np.testing.assert_allclose(vectors.dot(r, n), vectors.dot(w, n), atol=1e-6)
    tangential = w - vectors.dot(w, n) * n
    np.testing.assert_allclose(r - vectors.dot(r, n) * n, -tangential, atol=2e-6)


def test_difference_of_products_is_correctly_rounded():
    """a b − c d with c d ≈ a b: plain float32 loses every digit, this rounds once."""
    a, b = rng.uniform(1, 2, (2, 10_000)).astype(np.float32)
    c, d = np.nextafter(a, np.float32(3)), np.nextafter(b, np.float32(0))
    exact = a.astype(np.float64) * b - c.astype(np.float64) * d
    np.testing.assert_array_equal(vectors.difference_of_products(a, b, c, d), exact.astype(np.float32))


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -1, 0), (0, 1e-20, -1), (0, 0, -0.0)])
def test_frame_is_orthonormal_and_right_handed_on_the_axes(axis):
    n = np.array(axis, np.float32)[:, None]
    if not n.any():
        n = np.array([[1.0], [0.0], [-0.0]], np.float32)
    check_frame(n)


def test_frame_is_orthonormal_and_right_handed_everywhere():
    check_frame(directions())
    near_south = directions() * np.float32([[1e-4], [1e-4], [0]]) + np.float32([[0], [0], [-1]])
    check_frame(vectors.normalize(near_south))


def check_frame(n):
    s, t = frame(n)
    for a, b, expected in ((s, s, 1), (t, t, 1), (s, t, 0), (s, n, 0), (t, n, 0)):
        np.testing.assert_allclose(vectors.dot(a, b), expected, atol=2e-6)
    np.testing.assert_allclose(vectors.cross(s, t), n, atol=2e-6)


def test_to_world_inverts_to_local():
    n, w = directions(), directions()
    s, t = frame(n)
    np.testing.assert_allclose(to_world(s, t, n, to_local(s, t, n, w)), w, atol=2e-6)
    np.testing.assert_allclose(to_local(s, t, n, n)[2], 1, atol=1e-6)


def test_lanes_do_not_depend_on_the_batch():
    """The same lanes give the same bits alone and in a crowd, for any alignment."""
    a, b = directions(1001), directions(1001)
    for part in (slice(0, 1), slice(1, 4), slice(3, 1000)):
        some_a, some_b = a[:, part].copy(), b[:, part].copy()
        np.testing.assert_array_equal(vectors.dot(a, b)[part], vectors.dot(some_a, some_b))
        np.testing.assert_array_equal(vectors.normalize(a)[:, part], vectors.normalize(some_a))


def test_turning_round_is_a_product_with_the_sign():
    rng = np.random.default_rng(3)
    a = rng.normal(size=(3, 1000)).astype(np.float32)
    sign = rng.normal(size=1000).astype(np.float32)
    sign[:2] = 0.0, -0.0
    expected = a * np.copysign(np.float32(1), sign)
    vectors.flipped(a, sign)
    np.testing.assert_array_equal(a, expected)


def test_nothing_but_zero_is_zero():
    """Of either sign; the smallest denormal and NaN are something."""
    a = np.zeros((3, 5), np.float32)
    a[0, 1], a[1, 2], a[2, 3], a[:, 4] = -0.0, 1e-45, np.nan, -np.inf
    assert vectors.nonzero3(a).tolist() == [False, False, True, True, True]
