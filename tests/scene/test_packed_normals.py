"""Normals in 2 × 16 bits: how far they move, and that they move once."""

from __future__ import annotations

import numpy as np

from pt_engine.scene.packed_normals import packed


def directions() -> np.ndarray:
    n = np.random.default_rng(3).normal(size=(5000, 3))
    n[::7] *= [1, 1, 0]
    n[:6] = np.concatenate([np.eye(3), -np.eye(3)])
    return (n / np.linalg.norm(n, axis=1, keepdims=True)).astype(np.float32)


def test_a_normal_moves_by_a_cell_at_most():
    """Half a cell is 1/65535 along x and y, √6 times that on the octahedron, √3 times more on the sphere."""
    n = directions()
    moved = packed(n)
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), 1, atol=1e-6)
    assert np.linalg.norm(moved - n, axis=1).max() < 18**0.5 / 65535


def test_what_is_packed_stays():
    once = packed(directions())
    np.testing.assert_allclose(packed(once), once, atol=1e-6)


def test_an_axis_comes_out_beside_itself():
    """0 lies between two of the 65536 numbers."""
    up = packed(np.float32([[0, 0, 1]]))[0]
    assert 1e-5 < up[0] < 2e-5
