"""The table of the hard cases as text for a terminal, and as Markdown for the documentation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .case import Case, Group, Outcome
from .forms import FORMS
from .geometry import GEOMETRY
from .light import LIGHT
from .motion import MOTION
from .scale import SCALE
from .scattering import SCATTERING
from .statistics import STATISTICS
from .strands import STRANDS

GROUPS: tuple[Group, ...] = (SCALE, GEOMETRY, STRANDS, SCATTERING, LIGHT, MOTION, STATISTICS, FORMS)


def cases(quick: bool = False) -> list[Case]:
    """All rows, or the quick half."""
    return [case for group in GROUPS for case in group.cases if case.quick or not quick]


def line(outcome: Outcome) -> str:
    """One row for a terminal."""
    case = outcome.case
    verdict = "ok  " if outcome.passed else "FAIL"
    numbers = f"{number(outcome.measured)} (expected {bounds(case)})"
    naive = "" if outcome.naive is None else f", naive form {number(outcome.naive)}"
    text = f"{verdict} {case.group}: {case.name}: {case.quantity} {numbers}{naive}"
    return f"{text}\n     {outcome.failure}" if outcome.failure else text


def closing(outcomes: Sequence[Outcome]) -> str:
    """How it went in all."""
    failed = sum(not outcome.passed for outcome in outcomes)
    seconds = sum(outcome.seconds for outcome in outcomes)
    verdict = f"{failed} of {len(outcomes)} cases failed" if failed else f"all {len(outcomes)} cases hold"
    return f"{verdict}, {seconds:.1f} s"


def markdown(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """The page of the documentation, line by line."""
    yield from HEADING.splitlines()
    group = ""
    for outcome in outcomes:
        case = outcome.case
        if case.group != group:
            group = case.group
            yield from ("", f"## {group}", "", COLUMNS, "|---|---|---|---|---|---|---|")
        measured = number(outcome.measured) if outcome.passed else f"**{number(outcome.measured)}**"
        naive = "" if outcome.naive is None else number(outcome.naive)
        cells = (case.name, case.why, case.quantity, bounds(case), case.reason, measured, naive)
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def bounds(case: Case) -> str:
    """`0 ± 1e-5`."""
    return f"{number(case.expected)} ± {number(case.tolerance)}" if case.tolerance else number(case.expected)


def number(value: float) -> str:
    """Six digits where they say something, three of the very small and the very large."""
    return f"{value:.6g}" if 1e-3 <= abs(value) < 1e5 or value == 0 else f"{value:.3g}"


COLUMNS = "| case | why it is hard | measured is | expected | why this tolerance | measured | naive form |"
HEADING = """# Hard cases

What breaks renderers, what is expected there, and what this engine gives: `python -m pt_engine selftest
--all --markdown docs/hard-cases.md` writes this page, without options the command runs the quick rows. Where
there is a naive form, the one that textbooks give, its number stands beside: it has to miss.

Damaged files, thousands of view layers, renders and stops are on docs/limits.md, float32 against float64 on
docs/error-growth.md; `scripts/mutate` breaks formulas on purpose and shows that the tests notice each."""
