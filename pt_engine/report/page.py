"""One self-contained page: pictures, curves, where the time went, coverage, and how to make it again."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core.samplers import SAMPLERS
from ..core.whole_file import write_whole
from ..render.film_error import WORTH_TELLING
from ..render.forecast import exponent_of
from ..render.ledger import STAGES
from . import figures
from .errors import Picture
from .optional import optional
from .tables import COMPARED, EFFECTS, comparison_cells, legend, whatif_cells

Stats = Mapping[str, Any]
TEMPLATES = Path(__file__).with_name("templates")
BRIGHTEST = 99.0  # percentile of a picture's error that is shown brightest


def check_packages() -> None:
    """Fail before the work rather than after it.

    Raises
    ------
    MissingPackage
        Jinja2 or matplotlib is not installed.
    """
    optional("jinja2", "jinja2", figures.PURPOSE)
    optional("matplotlib", "matplotlib", figures.PURPOSE)


def filled(template: str, **values: Any) -> str:
    """A template's text; everything in it that is not marked as safe is escaped."""
    jinja2 = optional("jinja2", "jinja2", figures.PURPOSE)
    loader = jinja2.FileSystemLoader(TEMPLATES)
    environment = jinja2.Environment(loader=loader, autoescape=True, undefined=jinja2.StrictUndefined)
    text: str = environment.get_template(template).render(**values)
    return text


def render_page(
    path: Path,
    stats: Stats,
    png: bytes | None,
    error: NDArray[np.float32] | None,
    command: str = "",
    file: str = "",
) -> None:
    """The page of one render.

    Parameters
    ----------
    stats : mapping
        As in stats.json.
    png : bytes or None
        The picture as Blender shows it.
    error : (height, width) float32 or None
        As `error_picture.error_picture` makes it.
    command : str
        That renders it again.
    file : str
        What was rendered.
    """
    most = float(np.percentile(error, BRIGHTEST)) if error is not None and error.size else 0.0
    text = filled(
        "render.html",
        title=f"Render of {stats.get('scene', 'a scene')}",
        stats=stats,
        picture=figures.data_url(png) if png else None,
        error=figures.heat(error.astype(np.float64), most) if error is not None else None,
        most=most,
        accuracy=accuracy(stats),
        fireflies=fireflies(stats),
        curve=error_curve(stats),
        phases=phases(stats["seconds"]),
        ledger=ledger(stats.get("ledger")),
        left_out=[left_out(sample) for sample in stats["nonfinite"]["samples"]],
        command=command,
        file=file,
        others=list(stats.get("layers", {}))[1:],
        **coverage(stats["coverage"]),
    )
    write_whole(path, text)


PHASES = {
    "export": "reading the scene",
    "build": "preparing it",
    "render": "rendering",
    "write": "writing files",
    "other": "the rest",
}


def phases(seconds: Mapping[str, float]) -> list[tuple[str, float]]:
    """What a render's time is made of, without phases of less than a millisecond."""
    return [(told, seconds[name]) for name, told in PHASES.items() if seconds.get(name, 0.0) >= 1e-3]


def accuracy(stats: Stats) -> dict[str, float] | None:
    """Relative RMS error with its interval, and what halving it takes; None where unknown."""
    relative = stats["error"].get("relmse")
    if relative is None or not relative > 0:
        return None
    low, high = stats["error"].get("relmse_ci95") or (relative, relative)
    times = times_to_halve(stats)
    return {
        "error": math.sqrt(relative),
        "low": math.sqrt(max(low, 0.0)),
        "high": math.sqrt(high),
        "halving": (times - 1) * stats["seconds"]["render"],
        "times": times,
    }


def times_to_halve(stats: Stats) -> float:
    """How many times the samples half the error takes: 4, or fewer as far as Sobol points gain."""
    stratified = stats["error"].get("stratified")
    correlated = SAMPLERS[stats["settings"]["sampler"]].correlated
    gains = correlated and stratified is not None and stratified < 1
    return float(4.0 ** (1 / exponent_of(stratified if gains else 1.0)))


def fireflies(stats: Stats) -> float | None:
    """The factor that they make the error uncertain by, where that is worth telling."""
    factor: float = (stats["error"] or {}).get("fireflies") or 1.0
    return factor if factor > WORTH_TELLING else None


def error_curve(stats: Stats) -> str:
    """The figure of the error over time, "" where nothing is known."""
    known = accuracy(stats)
    seconds = stats["seconds"]["render"]
    if known is None or not (seconds > 0 and math.isfinite(known["high"])):
        return ""
    history = [(at, error) for _, at, error in stats.get("error_history", ())]
    now = seconds, known["error"], known["low"], known["high"]
    return figures.convergence(history, now, known["times"])


def coverage(entries: Sequence[Stats]) -> dict[str, Any]:
    """What of a scene is not rendered exactly, and how many nodes are."""
    inexact = [entry for entry in entries if entry["state"] != "exact"]
    keys = "material", "node", "state", "effect"
    return {
        "coverage": [[entry[key] for key in keys] for entry in inexact],
        "exact": len(entries) - len(inexact),
    }


def left_out(sample: Stats) -> list[str]:
    """A sample that was left out, and where that came from."""
    keys = "sample", "bounce", "material", "object", "what"
    return [f"{sample['x']}, {sample['y']}", *(str(sample[key]) for key in keys)]


def ledger(books: Stats | None) -> dict[str, Any] | None:
    """Figures and tables of where the time went; None where nobody kept the books."""
    if not books or not books["stages"]:
        return None
    stages = books["stages"].items()
    bounces = [(f"bounce {k}" if k else "camera rays", b["seconds"]) for k, b in enumerate(books["bounces"])]
    named = [(STAGES[name], row["seconds"]) for name, row in stages]
    effects = [(name, f"{row['seconds']:.3f}", row["rays"] or "") for name, row in books["effects"].items()]
    return {
        "books": books,
        "sum": sum(row["seconds"] for _, row in stages),
        "figure": figures.bars("core seconds by stage", named, "core seconds"),
        "bounces": figures.bars("core seconds by bounce", bounces[:16], "core seconds") if bounces else "",
        "stages": [(STAGES[name], f"{r['seconds']:.3f}", r["rays"] or "") for name, r in stages],
        "materials": [
            (name, f"{row['seconds']:.3f}", row["vertices"], row["rays"])
            for name, row in books["materials"].items()
        ],
        "effects": effects or [("none", "0", "")],
    }


def comparison_page(
    path: Path, result: Stats, reference: Picture, errors: Mapping[str, NDArray[np.float32]]
) -> None:
    """The page of a comparison.

    Parameters
    ----------
    errors : mapping
        Where each contender is wrong, as `error_picture.difference_picture` makes it.
    """
    least = result["reference"]["least_mse"]
    rows = [comparison_cells(row, least) for row in result["rows"]]
    every = np.concatenate([error.ravel() for error in errors.values()]) if errors else np.zeros(1)
    most = float(np.percentile(every, BRIGHTEST))
    efficiency = [(row["name"], row["relative_efficiency"]["value"]) for row in result["rows"]]
    text = filled(
        "comparison.html",
        title="What accuracy costs in time",
        result=result,
        reference=figures.picture(reference.mean[::-1]),
        header=COMPARED,
        rows=rows,
        legend=legend(result, " ".join(cell for row in rows for cell in row)),
        verdicts=[(row["name"], row["verdict"]) for row in result["rows"] if row["verdict"]],
        by_time=figures.curves("error over time", result["curves"], "seconds", least),
        by_samples=figures.curves("error over samples", result["curves"], "samples", least),
        efficiency=figures.bars(
            "efficiency",
            [(name, times) for name, times in efficiency if math.isfinite(times)],
            "times that of the settings as set",
        ),
        errors=[(name, figures.heat(error.astype(np.float64), most)) for name, error in errors.items()],
        most=most,
        noise=result["reference"]["error"],
        ledger=ledger(result["ledger"]),
        left_out=[(row["name"], row["nonfinite"]) for row in result["rows"] if row["nonfinite"]],
        **coverage(result["coverage"]),
    )
    write_whole(path, text)


def whatif_page(path: Path, result: Stats) -> None:
    """The page of effects taken out one at a time."""
    present = [row for row in result["effects"] if row["present"]]
    seen = [(row["name"], 100 * row["difference"]) for row in present if row["beyond_noise"]]
    text = filled(
        "whatif.html",
        title="What each effect costs",
        result=result,
        header=EFFECTS,
        rows=[whatif_cells(row, result["seconds"]) for row in present],
        missing=[row for row in result["effects"] if not row["present"]],
        seconds=figures.bars("core seconds", [(r["name"], r["seconds"]) for r in present], "core seconds"),
        difference=figures.bars("difference", seen, "RMS, % of the mean") if seen else "",
    )
    write_whole(path, text)
