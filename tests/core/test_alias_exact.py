"""The probabilities that an alias table implies are the weights', entry by entry, ties and zeros included."""

import numpy as np
import pytest

from pt_engine.core.distributions import AliasTable, Distribution2D


def implied(table, n):
    """Probabilities (rows, n): what each bucket keeps, and what it gives to its alias."""
    entries = table.view(np.uint32).reshape(-1, n, 2)
    keep = entries[..., 0].copy().view(np.float32).astype(np.float64)
    p = keep / n
    for row, (kept, alias) in enumerate(zip(keep, entries[..., 1], strict=True)):
        np.add.at(p[row], alias, (1.0 - kept) / n)
    return p


WEIGHTS = {
    "small integers": lambda rng, shape: rng.integers(0, 4, shape).astype(float),
    "few values": lambda rng, shape: rng.choice([0.1, 0.3, 3.3, 7.7], shape),
    "sixteen orders of magnitude": lambda rng, shape: 10 ** rng.uniform(-8, 8, shape),
    "zeros and ones": lambda rng, shape: rng.integers(0, 2, shape).astype(float),
    "equal": lambda rng, shape: np.full(shape, rng.uniform(0.1, 10.0)),
}


@pytest.mark.parametrize("kind", WEIGHTS)
def test_alias_tables_are_exact(kind):
    """float32 `keep` leaves 2⁻²⁴."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        shape = rng.integers(1, 6), rng.integers(1, 40)
        weights = WEIGHTS[kind](rng, shape)
        some = weights.sum(axis=1) > 0.0
        if not some.any():
            continue
        rows = implied(Distribution2D(weights)._table, shape[1])[some]
        np.testing.assert_allclose(rows, weights[some] / weights[some].sum(axis=1, keepdims=True), atol=1e-7)
        flat = implied(AliasTable(weights.ravel())._table, weights.size)[0]
        np.testing.assert_allclose(flat, weights.ravel() / weights.sum(), atol=1e-7)
