"""Sets of small numbers: the same answer whether few are compared or many looked up."""

from __future__ import annotations

import numpy as np
import pytest

from pt_engine.core.subset import FEW, Subset


@pytest.mark.parametrize("size", [0, 1, FEW, FEW + 1, 200])
def test_members_are_found(size):
    rng = np.random.default_rng(size)
    members = rng.permutation(256)[:size]
    table = np.zeros(256, np.bool_)
    table[members] = True
    numbers = rng.integers(0, 256, 5000).astype(np.uint8)
    subset = Subset(table)
    assert subset.empty == (size == 0)
    np.testing.assert_array_equal(subset.has(numbers), np.isin(numbers, members))
