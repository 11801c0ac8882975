"""MikkTSpace by hand: flat maps, mirrored halves, triangles without a map or without an area."""

from __future__ import annotations

import numpy as np
import pytest

from pt_engine.scene.tangent_space import tangent_space


def sheet(columns, u):
    """Two triangles per unit square along x, in z = 0, with uv = (u(x), y)."""
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]], np.float32)
    xy = (corners + [[[k, 0]] for k in range(columns)]).reshape(-1, 3, 2).astype(np.float32)
    points = np.concatenate([xy, np.zeros((*xy.shape[:2], 1), np.float32)], axis=2)
    uv = np.stack([u(xy[..., 0]), xy[..., 1]], axis=2).astype(np.float32)
    return points, np.broadcast_to(np.float32([0, 0, 1]), points.shape).copy(), uv


@pytest.mark.parametrize("turn", [1, -1])
def test_a_map_without_bend(turn):
    """u = ±x: t = ±x̂ everywhere, the bitangent sign · n × t along +v."""
    tangent, sign = tangent_space(*sheet(4, lambda x: turn * x))
    np.testing.assert_allclose(tangent, np.broadcast_to([turn, 0, 0], tangent.shape), atol=1e-6)
    np.testing.assert_array_equal(sign, turn)


def test_mirrored_halves_share_nothing():
    """u = |x − 2|: both sides keep their own direction, also at the vertices on the mirror."""
    tangent, sign = tangent_space(*sheet(4, lambda x: np.abs(x - 2)))
    side = np.repeat([-1, 1], 4)[:, None]
    np.testing.assert_allclose(tangent[..., 0], side * np.ones(3), atol=1e-6)
    np.testing.assert_array_equal(sign, side * np.ones(3))


def test_directions_are_weighted_by_angle():
    """Two triangles of one vertex, 45° each there, u along x̂ and along (1, s): t ∝ x̂ + (1, s)/√(1 + s²)."""
    s = 0.5
    points = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], np.float32)
    points = np.concatenate([points, np.zeros((2, 3, 1), np.float32)], axis=2)
    x, y = points[..., 0], points[..., 1]
    uv = np.stack([x, y], axis=2)
    uv[1, 2] = (-s, 1 + s)  # ∂p/∂u of the second triangle, whose two other corners are shared, turns
    t2 = uv[1, 1:] - uv[1, 0]
    along = np.linalg.solve(t2, points[1, 1:, :2])[0]  # rows ∂p/∂u, ∂p/∂v
    expected = np.array([1, 0]) + along / np.linalg.norm(along)
    normals = np.zeros_like(points)
    normals[..., 2] = 1
    tangent, _ = tangent_space(points, normals, uv)
    np.testing.assert_allclose(tangent[0, 0, :2], expected / np.linalg.norm(expected), atol=1e-6)
    np.testing.assert_array_equal(tangent[0, 0], tangent[1, 0])
    np.testing.assert_allclose(tangent[0, 1], [1, 0, 0], atol=1e-6)  # the corner it has alone


def test_triangles_without_a_map_follow_their_neighbours_and_collapsed_ones_borrow():
    points, normals, uv = sheet(3, lambda x: -x)
    uv[2:4] = uv[1, 1]  # the middle square has no area on the map
    points[5, 2] = points[5, 1]  # and the last triangle none at all
    tangent, sign = tangent_space(points, normals, uv)
    assert np.isfinite(tangent).all()
    np.testing.assert_allclose(tangent[:2, :, 0], -1, atol=1e-6)
    np.testing.assert_array_equal(tangent[5, 1], tangent[4, 2])
    assert set(np.unique(sign)) <= {-1, 1}


def test_no_map_at_all():
    """Along x with a left hand: what MikkTSpace begins with."""
    points, normals, uv = sheet(2, np.zeros_like)
    tangent, sign = tangent_space(points, normals, uv * 0)
    np.testing.assert_array_equal(tangent, np.broadcast_to([1, 0, 0], tangent.shape))
    np.testing.assert_array_equal(sign, -1)
