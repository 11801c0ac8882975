"""Estimators and settings side by side, against one reference: at equal time and at equal samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from ..render.settings import RenderSettings
from ..render.stats import versions
from ..scene.scene import Scene
from .contenders import ADAPTIVE, BASE, Contender, adaptive, contenders
from .errors import bias, relative_mse
from .fits import Estimate, at, geometric_mean_of, mean_of, slope
from .reference import Reference
from .runs import Point, Runs, measure, plain
from .verdict import verdict

SCHEMA = "pt_engine.comparison/1"
Told = Callable[[str], None]


def compare(
    scene: Scene,
    settings: RenderSettings,
    reference: Reference,
    seconds: float = 4.0,
    seeds: int = 4,
    only: tuple[str, ...] = (),
    tell: Told = lambda line: None,
) -> dict[str, Any]:
    """Measure every contender; what `--json` writes.

    Parameters
    ----------
    seconds : float
        Core seconds of each run.
    seeds : int
        Runs of each contender, at least 2 for intervals.
    only : tuple of str
        Words; contenders whose name contains none are left out.
    tell : callable
        Gets a line before each contender.
    """
    settings = plain(settings)
    everyone = contenders(scene, settings, only)
    measured: list[Runs] = []
    for number, contender in enumerate(everyone):
        tell(f"{number + 1}/{len(everyone)} {contender.name}")
        measured.append(measure(contender, reference.picture, seconds, seeds))
    if not only or any(word in ADAPTIVE for word in only):
        tell(ADAPTIVE)
        most = max(points[-1].samples for points in measured[0].points)
        measured.append(measure(adaptive(everyone[0], most), reference.picture, seconds, seeds))
    samples = min(points[-1].samples for runs in measured for points in runs.points)
    base = next(runs for runs in measured if runs.contender.name == BASE)
    return {
        "schema": SCHEMA,
        "settings": asdict(settings),
        "versions": versions(),
        "seconds": seconds,
        "seeds": seeds,
        "samples": samples,
        "reference": {"origin": reference.origin, "error": reference.error},
        "rows": [row(runs, base, reference, settings, seconds, samples) for runs in measured],
        "curves": {runs.contender.name: curve(runs) for runs in measured},
    }


def row(
    runs: Runs, base: Runs, reference: Reference, settings: RenderSettings, seconds: float, samples: float
) -> dict[str, Any]:
    """What is told of one contender."""
    contender = runs.contender
    found = bias(runs.mean, reference.picture)
    ours, theirs = (geometric_mean_of([efficiency(points) for points in r.points]) for r in (runs, base))
    return {
        "name": contender.name,
        "changes": changes(contender, settings),
        "samples": mean_of([points[-1].samples for points in runs.points]).value,
        "mse_at_equal_time": _told(error_at(runs, seconds, "seconds")),
        "mse_at_equal_samples": _told(error_at(runs, samples, "samples")),
        "relmse_of_all_runs": relative_mse(runs.mean.mean, reference.picture),
        "efficiency": _told(ours),
        "relative_efficiency": ours.value / theirs.value if theirs.value > 0 else math.nan,
        "slope": _told(mean_of([slope_of(points) for points in runs.points])),
        "bias": found._asdict(),
        "verdict": verdict(contender.scene, contender.settings, settings.max_depth, found),
    }


def efficiency(points: Sequence[Point]) -> float:
    """1 / (MSE × time) at the end of a run."""
    last = points[-1]
    return 1 / max(last.mse * last.seconds, 1e-300)


def error_at(runs: Runs, place: float, axis: str) -> Estimate:
    """MSE at so many `seconds` or `samples`."""
    values = [
        at(place, [getattr(p, axis) for p in points], [p.mse for p in points]) for points in runs.points
    ]
    return geometric_mean_of(values)


def slope_of(points: Sequence[Point]) -> float:
    """d log MSE / d log samples: −1 for independent samples."""
    return slope([p.samples for p in points], [p.mse for p in points])


def curve(runs: Runs) -> list[dict[str, float]]:
    """Mean error of the runs where all of them have a point, with its interval."""
    number = min(len(points) for points in runs.points)
    rows = []
    for k in range(number):
        here = [points[k] for points in runs.points]
        error = geometric_mean_of([p.mse for p in here])
        means = (mean_of([getattr(p, name) for p in here]).value for name in ("samples", "seconds"))
        rows.append(dict(zip(("samples", "seconds", "mse", "low", "high"), (*means, *error), strict=True)))
    return rows


def changes(contender: Contender, settings: RenderSettings) -> dict[str, Any]:
    """Settings that are not as the file's."""
    theirs, ours = asdict(contender.settings), asdict(settings)
    return {name: value for name, value in theirs.items() if value != ours[name]}


def _told(estimate: Estimate) -> dict[str, float]:
    return estimate._asdict()
