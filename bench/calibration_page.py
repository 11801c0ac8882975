"""docs/calibration.md from what `bench.calibration` has measured."""

from __future__ import annotations

from typing import Any

Results = dict[str, dict[str, Any]]


def page(results: Results) -> str:
    """The whole page."""
    return "\n".join(["X"])
