"""Progress, times and findings in words: for Blender's status bar, its reports and the terminal."""

from __future__ import annotations

import math
from collections import defaultdict

from ..render.film_error import WORTH_TELLING
from ..render.ledger import STAGES

LISTED = 5  # lines in a message
NAMED = 3  # materials in a line


def duration(seconds: float) -> str:
    """`3.2 s`, `4:07` or `1:02:33`."""
    if not math.isfinite(seconds):
        return "?"
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"


def count(number: float) -> str:
    """Three digits and a unit: `12.3 M`."""
    for limit, unit in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if number >= limit:
            return f"{number / limit:.3g}{unit}"
    return f"{number:.3g}"


def status(progress) -> str:
    """Samples, times and speed in one line."""
    total = f"/{progress.total_samples}" if progress.total_samples else ""
    parts = [f"Sample {progress.samples}{total}", duration(progress.elapsed)]
    if math.isfinite(progress.remaining):
        parts.append(f"remaining {duration(progress.remaining)}")
    parts.append(f"{progress.rays_per_second * 1e-6:.1f} Mrays/s")
    if progress.forecast.latest:
        parts.append(prediction(progress.forecast.latest))
    if progress.nonfinite_count:
        parts.append(f"{progress.nonfinite_count} non-finite samples dropped")
    return " | ".join(parts)


def prediction(found) -> str:
    """`reaches 1 % in 3:10 (2:50 to 3:40)`: from the render's start."""
    low, high = found.seconds_ci95
    when = f"{duration(found.seconds)} ({duration(low)} to {duration(high)})"
    return f"reaches {found.target * 100:.3g} % in {when}"


def estimated_error(error: dict) -> str:
    """The relative root-mean-square error with its interval, from stats' `error`; "" where there is none."""
    relative = (error or {}).get("relmse")
    if relative is None or not math.isfinite(relative):
        return ""
    low, high = (error.get("relmse_ci95") or (None, None))[:2]
    text = f"{math.sqrt(max(relative, 0.0)):.2%} relative RMS"
    if low is not None and high is not None and math.isfinite(high):
        text += f" (95%: {math.sqrt(max(low, 0.0)):.2%} to {math.sqrt(max(high, 0.0)):.2%})"
    return text


def ledger_lines(stats, most: int = 4) -> list[str]:
    """Where a render's time went, from stats' `ledger`: its largest stages, effects and materials."""
    books = (stats or {}).get("ledger")
    if not books:
        return []
    whole = sum(stage["seconds"] for stage in books["stages"].values())
    if whole <= 0:
        return []

    def share(rows) -> str:
        return ", ".join(f"{name} {seconds / whole:.0%}" for name, seconds in list(rows)[:most])

    lines = ["Time: " + share((STAGES[name], stage["seconds"]) for name, stage in books["stages"].items())]
    bounces = [f"{k}: {bounce['seconds'] / whole:.0%}" for k, bounce in enumerate(books["bounces"][:most])]
    lines.append("Bounces " + ", ".join(bounces))
    if books["effects"]:
        lines.append("Effects: " + share((name, row["seconds"]) for name, row in books["effects"].items()))
    if books["materials"]:
        rows = ((name, row["seconds"]) for name, row in books["materials"].items())
        lines.append("Materials: " + share(rows))
    if (lost := books["waiting"] / (books["threads"] * books["wall"] or 1)) > 0.1:
        lines.append(f"Threads have waited {lost:.0%} of the time")
    return lines


def inexact(coverage) -> list:
    """The entries that are not exact."""
    return [entry for entry in coverage if entry.state != "exact"]


def coverage_lines(coverage) -> list[str]:
    """One line for each kind of finding, with the materials that have it."""
    where = defaultdict(dict)
    for entry in inexact(coverage):
        kind = entry.node.rsplit("/", 1)[-1]
        where[kind, entry.state, entry.effect][entry.material] = None
    lines = []
    for (node, state, effect), materials in where.items():
        names = list(materials)
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
        place = ", ".join(names[:NAMED]) + more
        lines.append(": ".join(part for part in (place, f"{node} {state}", effect) if part))
    return lines


def shortened(lines: list[str], limit: int = LISTED) -> list[str]:
    """The first lines, and how many more there are."""
    return lines if len(lines) <= limit else [*lines[:limit], f"and {len(lines) - limit} more"]


STOPPED = {
    "samples": "all samples were taken",
    "time": "the time was up",
    "target": "the target error is reached",
    "noise": "no pixel needs more",
    "cancelled": "it was cancelled",
}


def error_lines(stats) -> list[str]:
    """What is known of a render's error, from its statistics."""
    error = estimated_error(stats["error"])
    return [
        "Error " + error if error else "Too few samples to know the error",
        *doubts(stats["error"]),
        f"{stats['samples']} samples: {STOPPED[stats['stopped_by']]}",
    ]


def doubts(error: dict) -> list[str]:
    """Why the error itself is uncertain, from stats' `error`."""
    factor = (error or {}).get("fireflies") or 1.0
    told = f"Fireflies: rare bright samples make it uncertain by {factor:.1f} ×"
    return [told] if factor > WORTH_TELLING else []
