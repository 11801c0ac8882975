"""Results as plain text for a terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from .fits import tells


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Columns side by side; the first to the left, the others to the right."""
    lines = [list(header), *(list(row) for row in rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(header))]

    def text(line: Sequence[str]) -> str:
        first, *rest = (
            cell.ljust(width) if k == 0 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        )
        return "  ".join([first, *rest]).rstrip()

    return [text(lines[0]), "  ".join("-" * width for width in widths), *map(text, lines[1:])]


UNKNOWN = "±?"
WIDEST_SLOPE = 1.0  # no more than that is told: from −2 to 0 a slope may be anything
COMPARED = ("estimator", "spp", "MSE, equal time", "equal samples", "efficiency", "slope", "bias", "z")


def comparison_lines(result: Mapping[str, Any]) -> list[str]:
    """A comparison: what was measured, a table, and a sentence for each estimator that is blind."""
    reference = result["reference"]
    known = reference["error"]
    noise = f", its own error {known:.2%} relative RMS" if known is not None and math.isfinite(known) else ""
    lines = [
        f"Reference: {reference['origin']}{noise}",
        f"Each: {plural(result['seeds'], 'run')} of {result['seconds']:g} core seconds; "
        f"equal samples: {result['samples']:.3g} per pixel; ± is a 95 % interval",
        "",
        *table(COMPARED, (comparison_cells(row) for row in result["rows"])),
    ]
    unknown = [unknown_from(result["seeds"])] if any(UNKNOWN in line for line in lines) else []
    told = [f"{row['name']}: {row['verdict']}" for row in result["rows"] if row["verdict"]]
    return [*lines, *unknown, *(["", *told] if told else [])]


def unknown_from(seeds: int) -> str:
    """What `±?` means."""
    return f"{UNKNOWN}: not known from {plural(seeds, 'seed')}; more of them (--seeds) would tell"


def plural(number: int, what: str) -> str:
    """`1 seed`, `2 seeds`."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def comparison_cells(row: Mapping[str, Any]) -> list[str]:
    """One estimator's line."""
    return [
        row["name"],
        f"{row['samples']:.3g}",
        with_factor(row["mse_at_equal_time"]),
        with_factor(row["mse_at_equal_samples"]),
        f"{row['relative_efficiency']:.2f} x" if math.isfinite(row["relative_efficiency"]) else "?",
        with_difference(row["slope"]),
        f"{row['bias']['relative']:+.1%}",
        f"{row['bias']['z']:.1f}",
    ]


def with_factor(estimate: Mapping[str, float]) -> str:
    """`1.2e-3 ±8%`, of the wider side; `±?` where the interval tells nothing; `0` where nothing is wrong."""
    value, high = estimate["value"], estimate["high"]
    if value == 0:
        return "0"
    return f"{value:.2e} " + (f"±{high / value - 1:.0%}" if tells(estimate["low"], high) else UNKNOWN)


def with_difference(estimate: Mapping[str, float]) -> str:
    """`-0.98 ±0.05`."""
    value, high = estimate["value"], estimate["high"]
    if not math.isfinite(value):
        return "?"
    return f"{value:.2f} " + (f"±{high - value:.2f}" if high - value <= WIDEST_SLOPE else UNKNOWN)


EFFECTS = ("effect", "takes", "of the time", "difference", "energy", "noise", "difference / s")


def whatif_lines(result: Mapping[str, Any]) -> list[str]:
    """What each effect costs and does."""
    whole = result["seconds"]
    rows = [whatif_cells(row, whole) for row in result["effects"] if row["present"]]
    missing = [f"{row['name']}: 0 s, 0 difference ({row['why']})" for row in result["effects"] if row["why"]]
    return [
        f"Whole scene: {result['samples']} samples in {whole:.2f} core seconds. Each effect taken out alone:",
        "takes: core seconds; difference: RMS over the image's mean; noise: its MSE against without",
        *(["", *table(EFFECTS, rows)] if rows else []),
        *(["", *missing] if missing else []),
    ]


def whatif_cells(row: Mapping[str, Any], whole: float) -> list[str]:
    """One effect's line."""
    per_second = row["difference_per_second"]
    return [
        row["name"],
        f"{row['seconds']:+.2f} s",
        f"{row['seconds'] / whole:+.0%}" if whole > 0 else "?",
        f"{row['difference']:.2%}" if row["beyond_noise"] else f"< {row['difference_high']:.2%}",
        f"{row['energy']:+.1%}",
        f"{row['noise']:.2f} x",
        f"{per_second:.1%}" if math.isfinite(per_second) else "costs nothing",
    ]
