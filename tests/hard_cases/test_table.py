"""Every row of the hard cases holds, and every naive form misses; the table itself can be trusted to fail."""

from __future__ import annotations

import sys

import pytest

from pt_engine.blender.cli import main
from pt_engine.selftest.case import Group, run
from pt_engine.selftest.command import selftest
from pt_engine.selftest.table import GROUPS, cases, closing, line, markdown

pytestmark = pytest.mark.slow  # physics that no Python changes

ROWS = [pytest.param(case, id=case.name, marks=[] if case.quick else pytest.mark.slow) for case in cases()]


@pytest.mark.parametrize("case", ROWS)
def test_hard_case(case):
    """|measured − expected| ≤ tolerance, without a warning of numpy's; |naive − expected| > tolerance."""
    outcome = run(case)
    assert outcome.passed, line(outcome)


def test_every_subject_has_rows_with_words():
    assert {group.name for group in GROUPS} == {
        "Scale and place",
        "Geometry",
        "Hair and points",
        "Scattering",
        "Light",
        "Motion",
        "Statistics",
        "Robust forms",
    }
    names = [(case.group, case.name) for case in cases()]
    assert len(set(names)) == len(names)
    assert all(case.why and case.quantity and case.reason and case.tolerance >= 0 for case in cases())
    assert sum(case.naive is not None for case in cases()) >= 25


def rows(**measures):
    """Outcomes of made-up cases: measure → naive measure."""
    group = Group("made up")
    for name, (measure, naive) in measures.items():
        group.case(name, "why", "number", 1.0, 0.1, "because", naive)(measure)
    return [run(case) for case in group.cases]


def test_a_row_fails_where_it_should():
    """Out of bounds, NaN, an exception, a warning, or a naive form that does not miss."""

    def warns():
        import warnings

        warnings.warn("overflow", RuntimeWarning, stacklevel=1)
        return 1.0

    outcomes = rows(
        good=(lambda: 1.05, None),
        good_naive=(lambda: 1.0, lambda: float("nan")),
        off=(lambda: 1.2, None),
        nan=(lambda: float("nan"), None),
        raises=(lambda: 1 / 0, None),
        warns=(warns, None),
        naive_too_good=(lambda: 1.0, lambda: 1.0),
    )
    assert [outcome.passed for outcome in outcomes] == [True, True, False, False, False, False, False]
    assert "ZeroDivisionError" in line(outcomes[4])
    assert closing(outcomes).startswith("5 of 7 cases failed")
    assert "**1.2**" in "\n".join(markdown(outcomes))


def test_the_command_prints_a_table_and_tells_whether_all_hold(monkeypatch, capsys, tmp_path):
    group = Group("made up")
    group.case("easy", "why", "number", 1.0, 0.0, "because")(lambda: 1.0)
    group.case("slow", "why", "number", 1.0, 0.0, "because", quick=False)(lambda: 2.0)
    monkeypatch.setattr("pt_engine.selftest.table.GROUPS", (group,))
    assert selftest(page=tmp_path / "page.md")
    assert not selftest(everything=True)
    told = capsys.readouterr().out
    assert "ok   made up: easy" in told
    assert "FAIL made up: slow" in told
    assert (tmp_path / "page.md").read_text(encoding="utf-8").count("| easy |") == 1


def test_the_command_line_needs_no_blender(monkeypatch, capsys):
    """`python -m pt_engine selftest`: code 0 if all hold, 1 if not, and bpy is not imported for it."""
    monkeypatch.setitem(sys.modules, "bpy", None)  # importing it would raise
    for measured, code in ((1.0, 0), (2.0, 1)):
        group = Group("made up")
        group.case("row", "why", "number", 1.0, 0.0, "because")(lambda measured=measured: measured)
        monkeypatch.setattr("pt_engine.selftest.table.GROUPS", (group,))
        assert main(["selftest"]) == code
    assert "1 of 1 cases failed" in capsys.readouterr().out
