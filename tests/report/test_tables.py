"""What tables tell of intervals: a band that spans decades is no band."""

from __future__ import annotations

import math

import pytest

from pt_engine.report.figures import curves
from pt_engine.report.fits import geometric_mean_of, mean_of, tells
from pt_engine.report.tables import comparison_lines


def row(errors, slopes, efficiencies):
    """A contender with these errors, slopes and relative efficiencies, a number a seed."""
    error = geometric_mean_of(errors)._asdict()
    return {
        "name": "as set",
        "samples": 16,
        "mse_at_equal_time": error,
        "mse_at_equal_samples": error,
        "relative_efficiency": geometric_mean_of(efficiencies)._asdict(),
        "slope": mean_of(slopes)._asdict(),
        "bias": {"relative": 0.0, "z": 0.0},
        "verdict": "",
    }


def lines(errors, slopes, efficiencies=(1.0, 1.0, 1.0), least=0.0):
    result = {
        "reference": {"origin": "made", "error": 0.01, "least_mse": least},
        "seeds": len(errors),
        "seconds": 1,
        "samples": 16,
    }
    return comparison_lines({**result, "rows": [row(errors, slopes, efficiencies)]})


@pytest.mark.parametrize(
    ("errors", "slopes"), [((1e-3, 2e-3), (-0.5, -1.5)), ((1e-3,), (-1.0,)), ((1e-3, 1e-6, 1.0), (0, -1, -2))]
)
def test_what_few_seeds_do_not_tell_is_said_in_words(errors, slopes):
    told = lines(errors, slopes)
    assert told[-1].startswith(f"±?: not known from {len(errors)} seed")
    assert told[-2].count("±?") == 3
    assert "%" not in told[-2].split("x")[0]


def test_what_seeds_tell_is_a_number():
    """Student's t of three numbers: x̄ ± 4.303 s/√3."""
    told = lines((1.0e-3, 1.1e-3, 1.2e-3), (-1.0, -0.9, -1.1))
    half = 4.303 / math.sqrt(3)
    spread = math.exp(half * 0.0914)  # s of the logarithms
    assert f"±{spread - 1:.0%}" in told[-1]
    assert f"±{half * 0.1:.2f}" in told[-1]
    assert not any("±?" in line for line in told)


def test_efficiency_has_the_interval_of_its_rounds():
    told = lines((1.0e-3, 1.1e-3, 1.2e-3), (-1.0, -0.9, -1.1), (1.5, 1.5, 1.6))
    spread = math.exp(4.303 / math.sqrt(3) * math.log(1.6 / 1.5) / math.sqrt(3))
    assert f"1.53 x ±{spread - 1:.0%}" in told[-1]


def test_what_the_reference_hides_is_no_number():
    """Nearer to the truth than its reference is, an estimate has an MSE of anything, and no efficiency."""
    told = lines((1.0e-6, 0.0, 2e-6), (math.nan,) * 3, (math.nan,) * 3, least=1e-5)
    assert told[-2].count("< 1.0e-05") == 2
    assert "?" in told[-2]
    assert "reference's own noise" in told[-1]


def test_nothing_is_drawn_of_errors_of_zero():
    """A curve without a point leaves a figure without a legend, and no warning."""
    point = {"samples": 1.0, "seconds": 1.0, "mse": 0.0, "low": 0.0, "high": 0.0}
    assert "<svg" in curves("error over time", {"as set": [point]})


def test_an_interval_of_a_factor_of_two_is_the_widest_that_tells():
    assert tells(0.5, 2.0)
    assert not tells(0.49, 2.0)
    assert not tells(0.0, 1.0)
    assert not tells(math.nan, math.nan)
