"""A row of the table: one hard case, its expected number, and how far from it the measured one may be.

Where the engine uses a robust form, the row also measures the naive one, which must miss: so the row is
known to be able to fail.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field

Measure = Callable[[], float]


@dataclass(frozen=True)
class Case:
    """One row.

    Attributes
    ----------
    group, name : str
        Subject, and what the case is.
    why : str
        What makes it hard.
    quantity : str
        What is measured.
    expected, tolerance : float
        The case passes where |measured − expected| ≤ tolerance.
    reason : str
        Why the tolerance is what it is.
    measure : callable
        Gives the measured number.
    naive : callable or None
        The same of the form that textbooks give; it has to miss.
    quick : bool
        Whether it belongs to the quick half.
    """

    group: str
    name: str
    why: str
    quantity: str
    expected: float
    tolerance: float
    reason: str
    measure: Measure
    naive: Measure | None = None
    quick: bool = True

    def holds(self, number: float) -> bool:
        """Whether a number is near enough; NaN never is."""
        return abs(number - self.expected) <= self.tolerance


@dataclass(frozen=True)
class Outcome:
    """A case and what it gave: numbers (NaN where it raised), seconds, and the words of an exception."""

    case: Case
    measured: float
    naive: float | None
    seconds: float
    failure: str = ""

    @property
    def passed(self) -> bool:
        """The engine is within the tolerance, and the naive form, if there is one, is not."""
        caught = self.naive is None or not self.case.holds(self.naive)
        return not self.failure and self.case.holds(self.measured) and caught


@dataclass
class Group:
    """The cases of one subject, in the order of their definition."""

    name: str
    cases: list[Case] = field(default_factory=list)

    def case(
        self,
        name: str,
        why: str,
        quantity: str,
        expected: float,
        tolerance: float,
        reason: str,
        naive: Measure | None = None,
        quick: bool = True,
    ) -> Callable[[Measure], Measure]:
        """A decorator: the function measures."""

        def keep(measure: Measure) -> Measure:
            row = Case(self.name, name, why, quantity, expected, tolerance, reason, measure, naive, quick)
            self.cases.append(row)
            return measure

        return keep


def run(case: Case) -> Outcome:
    """Measure a case. A warning of numpy's counts as a failure: nothing here may overflow by accident."""
    started = time.perf_counter()
    measured, naive, failure = float("nan"), None, ""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            measured = float(case.measure())
            if case.naive is not None:
                warnings.simplefilter("ignore")
                naive = float(case.naive())
    except Exception as error:
        failure = f"{type(error).__name__}: {error}"
    return Outcome(case, measured, naive, time.perf_counter() - started, failure)
