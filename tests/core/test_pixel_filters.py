"""Offsets follow the filter's closed form: Kolmogorov-Smirnov, moments, symmetry."""

import numpy as np
import pytest
from scipy import integrate
from scipy.stats import kstest

from pt_engine.core.pixel_filters import FILTERS, FilterTable

KINDS = [
    *(("BLACKMAN_HARRIS", width) for width in (0.01, 1.5, 4.0)),
    *(("GAUSSIAN", width) for width in (0.7, 1.5)),
    *(("BOX", width) for width in (1.0, 3.0)),
]


def density(kind, width):
    function, reach = FILTERS[kind]
    area = integrate.quad(lambda x: function(np.float64(x), width), -reach * width, reach * width)[0]
    return lambda x: function(x, width) / area


@pytest.mark.parametrize(("kind", "width"), KINDS)
def test_offsets_follow_the_filter(kind, width):
    """KS distance of exact quantiles below 0.002: the table has 511 entries a side and sums by rectangles."""
    table = FilterTable(kind, width)
    u = ((np.arange(200_000) + 0.5) / 200_000).astype(np.float32)
    x = table.sample(u).astype(np.float64)
    assert (np.diff(x) >= -1e-6 * width).all()
    grid = np.linspace(-table.reach, table.reach, 20_001)
    cdf = integrate.cumulative_simpson(density(kind, width)(grid), x=grid, initial=0)
    assert kstest(x, lambda q: np.interp(q, grid, cdf)).statistic < 0.002


@pytest.mark.parametrize(("kind", "width"), KINDS)
def test_moments(kind, width):
    """Mean 0 and E|x|, E x² of the closed form to 0.5 %; a box of width w has E x² = w²/12.

    A Gaussian's last table interval, 1.05 w to 1.5 w, is read linearly, in Cycles too: E x² + 2 %.
    """
    tolerance = 2.5e-2 if kind == "GAUSSIAN" else 5e-3
    table = FilterTable(kind, width)
    x = table.sample(((np.arange(200_000) + 0.5) / 200_000).astype(np.float32)).astype(np.float64)
    p = density(kind, width)
    assert abs(x.mean()) < 1e-5 * width
    assert np.abs(x).max() <= table.reach * (1 + 1e-6)
    for moment in (lambda q: abs(q), lambda q: q * q):
        expected = integrate.quad(lambda q, m=moment: m(q) * p(q), -table.reach, table.reach, points=[0])[0]
        assert abs(moment(x).mean() / expected - 1) < tolerance
    if kind == "BOX":
        assert abs((x * x).mean() / (width**2 / 12) - 1) < 5e-3


def test_one_call_serves_both_axes_within_reach():
    table = FilterTable("BLACKMAN_HARRIS", 1.5)
    u = np.array([[0, 0.5, 1 - 2.0**-24], [0.25, 0.5, 0.75]], np.float32)
    offset = table.sample(u)
    assert offset.shape == (2, 3)
    assert offset.dtype == np.float32
    np.testing.assert_allclose(offset[0], [-1.5, 0, 1.5], atol=2e-5)
    np.testing.assert_allclose(offset[1, 0], -offset[1, 2], atol=1e-6)


@pytest.mark.parametrize(("kind", "width"), [("LANCZOS", 1.0), ("BOX", 0.0), ("BOX", np.nan)])
def test_bad_filters_are_refused(kind, width):
    with pytest.raises(ValueError, match="filter"):
        FilterTable(kind, width)
