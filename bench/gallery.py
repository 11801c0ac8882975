"""docs/gallery.md: the lecture's ladder at equal time; accuracy against time beside the peers; one core."""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pt_engine.render.settings import RenderSettings
from pt_engine.report import figures
from pt_engine.report.comparison import curve
from pt_engine.report.contenders import Contender
from pt_engine.report.errors import Picture, bias, mse
from pt_engine.report.reference import Reference, made
from pt_engine.report.runs import measure
from pt_engine.report.verdict import verdict
from pt_engine.scene.prepare import prepare
from pt_engine.scene.scene import Scene
from pt_engine.scene.snapshot_io import load_snapshot

from . import machine
from .gallery_scenes import SHOWN, made_all
from .report import machine_text, table
from .shapes import MODELS, RR_DEPTH

LADDER = ("direct_bsdf", "direct_emitter", "direct_mis", "path_fixed", "path_active", "path")
LADDER_SCENES = ("S2", "room")
SEEDS = 3
LONGER = 20  # times as long as a run a reference takes
HEADER = """# Gallery

Made by `python -m bench gallery`; not edited by hand. One core. Seconds are of that core; peers' are of so
many samples, without loading and building. It goes on where it was stopped.
"""


def gallery(folder: Path, names: tuple[str, ...], seconds: float, peers: bool, target: Path) -> str:
    """Measure what is missing, draw into `target`/gallery/, and give the page's text.

    Parameters
    ----------
    folder : Path
        For the scenes and for what was measured, which is not measured again for the same `seconds`.
    seconds : float
        Of a core, for each run; the references take `LONGER` times as much.
    """
    pictures = target / "gallery"
    pictures.mkdir(parents=True, exist_ok=True)
    blends = made_all(folder, names)
    machine.pin()
    parts = [HEADER + "\n" + machine_text(machine.description())]
    ladders, curves = [], []
    for name, blend in blends.items():
        found = measured(name, blend, seconds, peers)
        svg = figures.curves(f"{name} over time", found["lines"], "seconds")
        (pictures / f"{name}.svg").write_text(svg, encoding="utf-8")
        curves.append(curve_text(name, found))
        if found["ladder"]:
            for file in picture_files(name):
                shutil.copy(folder / "gallery" / file, pictures / file)
            ladders.append(ladder_text(name, found))
    return "\n\n".join([*parts, *ladders, *curves]) + "\n"


def measured(name: str, blend: Path, seconds: float, peers: bool) -> dict[str, Any]:
    """A scene's curves and rungs: measured now, or as they were."""
    folder = blend.parent / "gallery"
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}, {seconds:g} s{'' if peers else ', alone'}.json"
    if path.exists():
        known: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return known
    print(name, file=sys.stderr, flush=True)
    scene, settings = prepare(load_snapshot(blend.with_suffix(".snapshot"))), settings_of(name)
    reference = made(scene, settings, 0.0, LONGER * seconds)
    lines = convergence(scene, settings, reference, seconds)
    if peers:
        lines |= of_peers(blend, reference.picture, folder, seconds)
    rungs = []
    if name in LADDER_SCENES:
        rungs = ladder(name, scene, settings, reference, seconds / 2, folder)
    found = {
        "seconds": seconds,
        "origin": reference.origin,
        "error": reference.error,
        "lines": lines,
        "ladder": rungs,
    }
    path.write_text(json.dumps(found, indent=1), encoding="utf-8")
    return found


def picture_files(name: str) -> list[str]:
    """Of a scene's ladder, the reference last."""
    return [f"{name}-{rung}.jpg" for rung in (*LADDER, "reference")]


def settings_of(name: str) -> RenderSettings:
    """One thread, box filter, as the peers are set."""
    shown = SHOWN[name]
    return RenderSettings(
        shown.width,
        shown.height,
        threads=1,
        max_depth=shown.max_depth,
        rr_depth=RR_DEPTH,
        pixel_filter="BOX",
        filter_width=1.0,
        samples=0,
    )


def convergence(
    scene: Scene, settings: RenderSettings, reference: Reference, seconds: float
) -> dict[str, list[dict[str, float]]]:
    """Our own curves, with both samplers."""
    lines = {}
    for label, sampler in (("PT Engine, Sobol", "sobol"), ("PT Engine, independent", "independent")):
        contender = Contender(label, replace(settings, sampler=sampler), scene)
        lines[label] = curve(measure(contender, reference.picture, seconds, SEEDS))
    return lines


def of_peers(
    blend: Path, reference: Picture, folder: Path, seconds: float
) -> dict[str, list[dict[str, float]]]:
    """The peers' curves, without bands: each point is a render of its own."""
    known = folder / f"{blend.stem}-reference.npz"
    variance = reference.variance if reference.variance is not None else np.zeros_like(reference.mean)
    np.savez(known, mean=reference.mean[::-1], variance=variance[::-1])
    lines = {}
    for label, peer in (("Cycles", "cycles"), ("Mitsuba", "mitsuba")):
        if peer == "cycles" or blend.stem in MODELS:
            output, _ = machine.run(["bench.gallery_peers", peer, str(blend), str(known), f"{seconds:g}"])
            points = json.loads(output.splitlines()[-1])
            lines[label] = [{**p, "low": float("nan"), "high": float("nan")} for p in points]
    return lines


def curve_text(name: str, found: dict[str, Any]) -> str:
    """A scene's figures, and what each needs for the same error."""
    shown, lines = SHOWN[name], found["lines"]
    common = max(points[-1]["mse"] for points in lines.values())
    rows = []
    for label, points in lines.items():
        seconds = time_to(common, points)
        last = points[-1]
        energy = f"{100 * last['energy']:+.1f} %" if "energy" in last else ""
        rows.append([label, f"{last['samples']:.0f}", f"{last['mse']:.2e}", f"{seconds:.2f}", energy])
    heads = ["renderer", "samples at most", "MSE then", f"seconds to MSE {common:.2e}", "energy against ours"]
    return (
        f"## {shown.title}\n\n{shown.width}×{shown.height}, {shown.max_depth} edges. "
        f"Reference: {found['origin']}, its own error {100 * (found['error'] or 0):.2f} % relative RMS.\n\n"
        f"![error over time](gallery/{name}.svg)\n\n" + table(heads, rows)
    )


def time_to(error: float, points: list[dict[str, float]]) -> float:
    """Core seconds after which a curve is at an error, on log axes; the last point's where it never is."""
    x = np.log([max(p["seconds"], 1e-9) for p in points])
    y = np.minimum.accumulate(np.log([max(p["mse"], 1e-300) for p in points]))
    return float(np.exp(np.interp(-np.log(error), -y, x)))


def ladder(
    name: str, scene: Scene, settings: RenderSettings, reference: Reference, seconds: float, folder: Path
) -> list[list[str]]:
    """The lecture's integrators on one scene, each for the same time: pictures, and a row of each."""
    rows = []
    *files, of_reference = picture_files(name)
    for rung, file in zip(LADDER, files, strict=True):
        contender = Contender(rung, replace(settings, integrator=rung), scene)
        runs = measure(contender, reference.picture, seconds, 1)
        (folder / file).write_bytes(figures.jpeg(runs.mean.mean[::-1]))
        found = bias(runs.mean, reference.picture)
        error = mse(runs.mean.mean, reference.picture) ** 0.5 / reference.picture.mean.mean()
        told = verdict(scene, contender.settings, settings.max_depth, found) or "no bias beyond noise"
        rows.append([f"`{rung}`", f"{runs.points[0][-1].samples:.0f}", f"{100 * error:.1f} %", told])
    (folder / of_reference).write_bytes(figures.jpeg(reference.picture.mean[::-1]))
    return rows


def ladder_text(name: str, found: dict[str, Any]) -> str:
    """The rungs side by side."""
    cells = [f"![{file}](gallery/{file})" for file in picture_files(name)]
    heads = [*(f"`{rung}`" for rung in LADDER), "reference"]
    return (
        f"## The ladder at equal time: {SHOWN[name].title}\n\n{found['seconds'] / 2:g} core seconds each.\n\n"
        + table(heads[:4], [cells[:4]])
        + "\n\n"
        + table(heads[4:], [cells[4:]])
        + "\n\n"
        + table(["integrator", "samples", "RMS error over the mean", "what it sees"], found["ladder"])
    )


def written(arguments: Any) -> None:
    """Carry out `python -m bench gallery`."""
    names = tuple(arguments.scene or SHOWN)
    target = arguments.json.parent if arguments.json else machine.ROOT / "docs"
    text = gallery(arguments.folder.resolve(), names, arguments.seconds, not arguments.no_peers, target)
    (target / "gallery.md").write_text(text, encoding="utf-8")
    sys.stdout.write(text)
