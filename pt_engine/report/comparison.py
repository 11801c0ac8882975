"""Estimators and settings side by side, against one reference: at equal time and at equal samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..render.ledger import Ledger
from ..render.progressive import render
from ..render.settings import RenderSettings
from ..render.stats import versions
from ..scene.scene import Scene
from .contenders import ADAPTIVE, BASE, Contender, adaptive, contenders
from .error_picture import difference_picture
from .errors import bias, least_known, relative_mse
from .fits import Estimate, at, geometric_mean_of, mean_of, slope, widened
from .reference import Reference
from .runs import Asked, Point, Runs, never, plain
from .verdict import blind_spots, verdict

SCHEMA = "pt_engine.comparison/2"
Told = Callable[[str], None]
Shown = Callable[[str, NDArray[np.float32]], None]


def compare(
    scene: Scene,
    settings: RenderSettings,
    reference: Reference,
    seconds: float = 4.0,
    seeds: int = 4,
    only: tuple[str, ...] = (),
    tell: Told = lambda line: None,
    should_stop: Asked = never,
    show: Shown = lambda name, error: None,
) -> dict[str, Any]:
    """Measure every contender; what `--json` writes. Runs that are complete count, whoever stops the rest.

    Parameters
    ----------
    seconds : float
        Core seconds of each run.
    seeds : int
        Runs of each contender, at least 2 for intervals.
    only : tuple of str
        Words; contenders whose name contains none are left out.
    tell : callable
        Gets a line before each run.
    show : callable
        Gets each contender's name and where it is wrong, as `error_picture.difference_picture` makes it.
    """
    settings, ledger = plain(settings), Ledger()
    everyone = measured_in_rounds(scene, settings, reference, seconds, seeds, only, tell, should_stop, ledger)
    measured = [runs for runs in everyone if runs.points]
    result = {
        "schema": SCHEMA,
        "settings": asdict(settings),
        "versions": versions(),
        "seconds": seconds,
        "seeds": seeds,
        "complete": sum(len(runs.points) for runs in measured) == seeds * len(everyone),
        "samples": 0.0,
        "reference": {
            "origin": reference.origin,
            "error": reference.error,
            "least_mse": least_known(reference.picture),
        },
        "rows": [],
        "curves": {runs.contender.name: curve(runs) for runs in measured},
        "coverage": [entry._asdict() for entry in scene.coverage],
        "ledger": ledger.books(scene),
    }
    for runs in measured:
        show(runs.contender.name, difference_picture(runs.mean.mean, reference.picture.mean))
    if measured:
        samples = min(points[-1].samples for runs in measured for points in runs.points)
        doubt = in_doubt(measured[0], reference, settings)
        rows = [row(runs, measured[0], reference, settings, seconds, samples, doubt) for runs in measured]
        result |= {"samples": samples, "rows": rows}
    return result


def measured_in_rounds(
    scene: Scene,
    settings: RenderSettings,
    reference: Reference,
    seconds: float,
    seeds: int,
    only: tuple[str, ...],
    tell: Told,
    should_stop: Asked,
    ledger: Ledger,
) -> list[Runs]:
    """Everyone's runs, the settings as they are first; there and back, since a machine's pace drifts."""
    everyone = [Runs(contender) for contender in contenders(scene, settings, only)]
    render(scene, replace(settings, samples=1))  # what only the first render makes
    for number in range(seeds):
        there = everyone if number % 2 == 0 else everyone[::-1]
        for runs in there:
            tell(f"{number + 1}/{seeds} {runs.contender.name}")
            books = ledger if runs.contender.name == BASE else None
            if not runs.run(reference.picture, seconds, should_stop, books):
                return everyone
            if number == 0 and runs is there[0] and (not only or any(word in ADAPTIVE for word in only)):
                everyone.append(Runs(adaptive(runs.contender, runs.points[0][-1].samples)))
    return everyone


def in_doubt(base: Runs, reference: Reference, settings: RenderSettings) -> bool:
    """Whether the settings as set differ from the reference though they can see all that it shows."""
    blind = any(blind_spots(base.contender.scene, settings, settings.max_depth))
    return not blind and bias(base.mean, reference.picture).significant


def row(
    runs: Runs,
    base: Runs,
    reference: Reference,
    settings: RenderSettings,
    seconds: float,
    samples: float,
    doubt: bool,
) -> dict[str, Any]:
    """What is told of one contender; in `doubt` what the base shows as well has no cause of its own."""
    contender, least = runs.contender, least_known(reference.picture)
    found = bias(runs.mean, reference.picture)
    as_base = doubt and runs is not base and not bias(runs.mean, base.mean).significant
    return {
        "name": contender.name,
        "changes": changes(contender, settings),
        "runs": len(runs.points),
        "samples": mean_of([points[-1].samples for points in runs.points]).value,
        "mse_at_equal_time": _told(error_at(runs, seconds, "seconds", least)),
        "mse_at_equal_samples": _told(error_at(runs, samples, "samples", least)),
        "relmse_of_all_runs": relative_mse(runs.mean.mean, reference.picture),
        "efficiency": _told(geometric_mean_of([efficiency(points, least) for points in runs.points])),
        "relative_efficiency": _told(relative_efficiency(runs, base, least)),
        "slope": _told(mean_of([slope_of(points, least) for points in runs.points])),
        "bias": found._asdict(),
        "nonfinite": runs.nonfinite,
        "verdict": verdict(contender.scene, contender.settings, settings.max_depth, found, as_base),
    }


def efficiency(points: Sequence[Point], least: float) -> float:
    """1 / (MSE × time) at the end of a run; NaN where the MSE is none or the reference does not know it."""
    last = points[-1]
    return 1 / (last.mse * last.seconds) if last.mse > least and last.seconds > 0 else math.nan


def relative_efficiency(runs: Runs, base: Runs, least: float) -> Estimate:
    """Round by round over the base's, so that a machine's pace does not count."""
    if runs is base:
        return Estimate(1.0, 1.0, 1.0)
    pairs = zip(runs.points, base.points, strict=False)
    return geometric_mean_of([efficiency(ours, least) / efficiency(theirs, least) for ours, theirs in pairs])


def error_at(runs: Runs, place: float, axis: str, least: float) -> Estimate:
    """MSE at so many `seconds` or `samples`."""
    values = [
        at(place, [getattr(p, axis) for p in points], [p.mse for p in points]) for points in runs.points
    ]
    return widened(geometric_mean_of(values), least)


def slope_of(points: Sequence[Point], least: float) -> float:
    """d log MSE / d log samples, of what the reference knows: −1 for independent samples."""
    there = [p for p in points if p.mse > least]
    return slope([p.samples for p in there], [p.mse for p in there])


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
