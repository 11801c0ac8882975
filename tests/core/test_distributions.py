"""Alias tables: exact probabilities read off the table, frequencies by χ², zeros never drawn."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.chi2 import chi2_counts

from pt_engine.core.distributions import AliasTable, Distribution2D

finite = st.floats(0, 2.0**100, allow_nan=False)


def table_probability(table):
    """Probability of each index as the table says it: its own bucket's `keep` and what others lend."""
    entry = table._table.view(np.uint32).reshape(-1, 2)
    keep = entry[:, 0].copy().view(np.float32).astype(np.float64)
    n = len(table)
    return (keep + np.bincount(entry[:, 1], 1 - keep, minlength=n)) / n


@given(st.lists(finite, min_size=1, max_size=300))
@settings(max_examples=200, deadline=None)
def test_table_holds_the_weights(weights):
    """To float32 rounding per bucket, for any weights, equal, zero, or 60 orders of magnitude apart."""
    weights = np.array(weights)
    table = AliasTable(weights)
    total = weights.sum()
    expected = weights / total if total > 0 else np.full(len(weights), 1 / len(weights))
    np.testing.assert_allclose(table_probability(table), expected, atol=1e-6)
    np.testing.assert_allclose(table.pmf, expected, rtol=1e-6, atol=1e-38)
    assert (table_probability(table)[(weights == 0)] == 0).all() or total == 0


@pytest.mark.parametrize("n", [1, 2, 7, 1000, 5000])
def test_frequencies_and_remainder(n):
    """χ² of the indices; the remainder is uniform in each half of the entries."""
    rng = np.random.default_rng(n)
    weights = rng.random(n) ** 4
    weights[rng.random(n) < 0.3] = 0
    weights[0] = 1
    table = AliasTable(weights)
    u = rng.random((2, 400_000), np.float32)
    for fine in (None, u[1]):
        index, rest = table.sample(u[0], fine)
        assert index.dtype == np.int32
        assert rest.dtype == np.float32
        counts = np.bincount(index, minlength=n)
        assert not counts[weights == 0].any()
        assert chi2_counts(counts, u.shape[1] * table.pmf.astype(np.float64)) > 1e-5
        assert rest.min() >= 0
        assert rest.max() < 1
        halves = np.histogram2d(index < n // 2, rest, bins=[2, 64], range=[[0, 1], [0, 1]])[0]
        expected = np.array([table.pmf[n // 2 :].sum(), table.pmf[: n // 2].sum()], np.float64)
        assert chi2_counts(halves, u.shape[1] * expected[:, None] / 64 * np.ones(64)) > 1e-5


def test_ends_of_the_interval():
    u = np.array([0, 2.0**-24, 0.5, 1 - 2.0**-24], np.float32)
    for n in (1, 3, 4097, 100_003):
        for fine in (None, u[::-1]):
            index, rest = AliasTable(np.arange(1, n + 1)).sample(u, fine)
            assert ((index >= 0) & (index < n)).all()
            assert ((rest >= 0) & (rest < 1)).all()


def test_all_zero_weights_are_uniform_and_say_so():
    table = AliasTable(np.zeros(4))
    assert table.total == 0
    np.testing.assert_array_equal(table.pmf, 0.25)
    assert set(table.sample(np.linspace(0, 0.999, 100, dtype=np.float32))[0]) == {0, 1, 2, 3}
    flat = Distribution2D(np.zeros((3, 5)))
    assert flat.total == 0
    np.testing.assert_allclose(flat.pdf(np.float32([0.1, 0.9]), np.float32([0.1, 0.9])), 1, rtol=1e-6)


@pytest.mark.parametrize("weights", [[], [-1.0, 2.0], [np.nan], [np.inf, 1.0], [[1.0]]])
def test_bad_weights_are_refused(weights):
    with pytest.raises(ValueError, match=r"weights must be|non-empty"):
        AliasTable(np.array(weights))


def test_eight_million_entries_build_in_seconds_and_draw_exactly():
    """10 s allows for a busy machine. With `fine`, the mean of index/n is that of the weights (5 σ)."""
    rng = np.random.default_rng(0)
    weights = rng.random(8_000_000, np.float32)
    weights *= np.linspace(0, 1, weights.size, dtype=np.float32)
    start = time.process_time()
    table = AliasTable(weights)
    assert time.process_time() - start < 10
    index, rest = table.sample(*rng.random((2, 200_000), np.float32))
    expected = (table.pmf.astype(np.float64) * np.arange(weights.size)).sum() / weights.size
    assert abs(index.mean() / weights.size - expected) < 5 * 0.25 / np.sqrt(index.size)
    assert abs(rest.mean() - 0.5) < 5 / np.sqrt(12 * rest.size)
    assert np.unique(rest).size > 190_000


def test_image_samples_follow_their_density():
    """χ² over texels and, within them, over quarters; a black row and a black column stay empty."""
    rng = np.random.default_rng(1)
    weights = rng.random((9, 16)) ** 6
    weights[4] = 0
    weights[:, 3] = 0
    d = Distribution2D(weights)
    x, y, density = d.sample(*rng.random((2, 400_000), np.float32))
    assert x.max() < 1
    assert y.max() < 1
    observed = np.histogram2d(y, x, bins=[18, 32], range=[[0, 1], [0, 1]])[0]
    expected = np.repeat(np.repeat(weights / weights.sum() / 4, 2, 0), 2, 1) * x.size
    assert not observed[expected == 0].any()
    assert chi2_counts(observed, expected) > 1e-5
    np.testing.assert_allclose(
        density, (weights / weights.mean())[(y * 9).astype(int), (x * 16).astype(int)], rtol=1e-5
    )
    np.testing.assert_allclose(d.pdf(x, y), density, rtol=1e-6)


def test_image_with_one_bright_texel():
    """A sun: 10⁶ against 10⁻⁶ elsewhere, in a large image."""
    weights = np.full((200, 400), 1e-6)
    weights[20, 300] = 1e6
    d = Distribution2D(weights)
    x, y, density = d.sample(*np.random.default_rng(0).random((2, 10_000), np.float32))
    assert ((x * 400).astype(int) == 300).all()
    assert ((y * 200).astype(int) == 20).all()
    np.testing.assert_allclose(density, 80_000, rtol=1e-5)


def test_every_row_of_a_large_image_holds_its_weights():
    """Rows with one bright texel, with few, with none, with equals: each row's table sums to its weights.

    All rows are filled by one search, so rounding in one must not leak into the next.
    """
    rng = np.random.default_rng(4)
    rows, columns = 3000, 700
    weights = rng.random((rows, columns)) ** rng.integers(0, 40, (rows, 1))
    weights[rng.random((rows, columns)) < 0.3] = 0
    weights[::7] = 0
    weights[::7, 5] = 1e-20
    weights[::11] = 1 / 3
    entry = Distribution2D(weights)._table.view(np.uint32).reshape(rows * columns, 2)
    keep = entry[:, 0].copy().view(np.float32).astype(np.float64)
    alias = entry[:, 1] + np.repeat(np.arange(rows), columns) * columns
    probability = (keep + np.bincount(alias, 1 - keep, minlength=keep.size)).reshape(rows, columns) / columns
    total = weights.sum(1, keepdims=True)
    np.testing.assert_allclose(probability, weights / total, atol=2e-6)
    assert not probability[weights == 0].any()
