"""`python -m pt_engine selftest`: run the hard cases and print their table."""

from __future__ import annotations

from pathlib import Path

from .case import run
from .table import cases, closing, line, markdown


def selftest(everything: bool = False, page: Path | None = None) -> bool:
    """Run the quick cases, or all; write the page of the documentation, if asked. Whether all hold."""
    outcomes = []
    for case in cases(quick=not everything):
        outcomes.append(run(case))
        print(line(outcomes[-1]), flush=True)
    print(closing(outcomes))
    if page is not None:
        page.write_text("\n".join(markdown(outcomes)) + "\n", encoding="utf-8")
    return all(outcome.passed for outcome in outcomes)
