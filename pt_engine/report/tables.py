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
        *table(COMPARED, (comparison_cells(row, reference["least_mse"]) for row in result["rows"])),
    ]
    told = [f"{row['name']}: {row['verdict']}" for row in result["rows"] if row["verdict"]]
    return [*lines, *legend(result, "\n".join(lines[4:])), *(["", *told] if told else [])]


def legend(result: Mapping[str, Any], cells: str) -> list[str]:
    """What signs among the cells mean."""
    found = [unknown_from(result["seeds"])] if UNKNOWN in cells else []
    if "< " in cells:
        found.append("<: less than the reference's own noise; a better one (--reference-error) would tell")
    return found


def unknown_from(seeds: int) -> str:
    """What `±?` means."""
    return f"{UNKNOWN}: not known from {plural(seeds, 'seed')}; more of them (--seeds) would tell"


def plural(number: int, what: str) -> str:
    """`1 seed`, `2 seeds`."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def comparison_cells(row: Mapping[str, Any], least: float) -> list[str]:
    """One estimator's line; `least` is the MSE that the reference's noise hides."""
    return [
        row["name"],
        f"{row['samples']:.3g}",
        error_cell(row["mse_at_equal_time"], least),
        error_cell(row["mse_at_equal_samples"], least),
        efficiency_cell(row["relative_efficiency"]),
        with_difference(row["slope"]),
        f"{row['bias']['relative']:+.1%}",
        f"{row['bias']['z']:.1f}",
    ]


def error_cell(estimate: Mapping[str, float], least: float) -> str:
    """`1.20e-03 ±8%`, `< 1.0e-05` where the reference hides it, `0` where nothing is wrong."""
    value = estimate["value"]
    if value <= least:
        return f"< {least:.1e}" if least > 0 else "0"
    return f"{value:.2e} " + with_factor(estimate)


def efficiency_cell(estimate: Mapping[str, float]) -> str:
    """`1.35 x ±12%`, without an interval where it is 1 by definition; `?` where nothing is known."""
    value, low, high = (estimate[key] for key in ("value", "low", "high"))
    if not math.isfinite(value):
        return "?"
    return f"{value:.2f} x" + ("" if low == high else f" {with_factor(estimate)}")


def with_factor(estimate: Mapping[str, float]) -> str:
    """`±8%`, of the wider side; `±?` where the interval tells nothing."""
    value, high = estimate["value"], estimate["high"]
    return f"±{high / value - 1:.0%}" if tells(estimate["low"], high) else UNKNOWN


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
        "takes: core seconds, ± 95 %; difference: RMS over the image's mean; noise: its MSE against without",
        *(["", *table(EFFECTS, rows)] if rows else []),
        *(["", *missing] if missing else []),
    ]


def whatif_cells(row: Mapping[str, Any], whole: float) -> list[str]:
    """One effect's line."""
    half, per_second = row["seconds_ci95"][1] - row["seconds"], row["difference_per_second"]
    least = "" if row["seconds_known"] else "> "
    return [
        row["name"],
        f"{row['seconds']:+.2f} ±{half:.2f} s",
        f"{row['seconds'] / whole:+.0%}" if whole > 0 else "?",
        f"{row['difference']:.2%}" if row["beyond_noise"] else hidden(row["difference_high"]),
        f"{row['energy']:+.1%}",
        f"{row['noise']:.2f} x" if math.isfinite(row["noise"]) else "all",
        price(per_second, least) if row["beyond_noise"] else "?",
    ]


def hidden(high: float) -> str:
    """The most that a difference may be which noise hides, in figures that are not all 0."""
    return f"< {max(high, 1e-4):.2%}"


def price(per_second: float, least: str) -> str:
    """The difference that a second makes."""
    return f"{least}{per_second:.1%}" if math.isfinite(per_second) else "costs nothing"
