"""Rows of random numbers that are made when somebody asks."""

import numpy as np

from pt_engine.core.uniforms import LazyRows


def test_rows_read_like_the_array_and_are_made_once_and_only_if_asked_for():
    whole, made = np.arange(15, dtype=np.float32).reshape(3, 5), []

    def part(rows):
        made.append(rows)
        return whole[rows]

    u = LazyRows((1, lambda: part(slice(0, 1))), (2, lambda: part(slice(1, 3))))
    assert len(u) == 3
    some = u[:, 1:4]
    assert made == []
    np.testing.assert_array_equal(some[2], whole[2, 1:4])
    np.testing.assert_array_equal(u[1], whole[1])
    np.testing.assert_array_equal(u[:, np.array([4, 0])][1], whole[1, [4, 0]])
    assert made == [slice(1, 3)]
    first, second, third = u[:, :2]
    np.testing.assert_array_equal(np.stack([first, second, third]), whole[:, :2])
    assert made == [slice(1, 3), slice(0, 1)]
