"""docs/gallery.md: the lecture's ladder at equal time; accuracy against time beside the peers; one core."""

from __future__ import annotations

import base64
import json
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
HEADER = """# Gallery

Made by `python -m bench gallery`; not edited by hand. One core. Seconds are of that core; peers' are of so
many samples, without loading and building.
"""


def gallery(folder: Path, names: tuple[str, ...], seconds: float, peers: bool, target: Path) -> str:
    """Measure, draw into `target`/gallery/, and give the page's text.

    Parameters
    ----------
    seconds : float
        Of a core, for each run; the references take six times as much.
    """
    pictures = target / "gallery"
    pictures.mkdir(parents=True, exist_ok=True)
    blends = made_all(folder, names)
    machine.pin()
    parts = [HEADER + "\n" + machine_text(machine.description())]
    ladders, curves = [], []
    for name, blend in blends.items():
        print(name, file=sys.stderr, flush=True)
        scene = prepare(load_snapshot(blend.with_suffix(".snapshot")))
        settings = settings_of(name)
        reference = made(scene, settings, 0.0, 6 * seconds)
        lines = convergence(scene, settings, reference, seconds)
        if peers:
            lines |= of_peers(blend, reference.picture, folder)
        save(pictures / f"{name}-time.svg", figures.curves(f"{name} over time", lines, "seconds"))
        save(pictures / f"{name}-samples.svg", figures.curves(f"{name} over samples", lines, "samples"))
        curves.append(curve_text(name, reference, lines))
        if name in LADDER_SCENES:
            ladders.append(ladder_text(name, scene, settings, reference, seconds / 2, pictures))
    return "\n\n".join([*parts, *ladders, *curves]) + "\n"


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


def of_peers(blend: Path, reference: Picture, folder: Path) -> dict[str, list[dict[str, float]]]:
    """The peers' curves, without bands: each point is a render of its own."""
    known = folder / f"{blend.stem}-reference.npz"
    variance = reference.variance if reference.variance is not None else np.zeros_like(reference.mean)
    np.savez(known, mean=reference.mean[::-1], variance=variance[::-1])
    lines = {}
    for label, peer in (("Cycles", "cycles"), ("Mitsuba", "mitsuba")):
        if peer == "cycles" or blend.stem in MODELS:
            output, _ = machine.run(["bench.gallery_peers", peer, str(blend), str(known)])
            points = json.loads(output.splitlines()[-1])
            lines[label] = [{**p, "low": float("nan"), "high": float("nan")} for p in points]
    return lines


def curve_text(name: str, reference: Reference, lines: dict[str, list[dict[str, float]]]) -> str:
    """A scene's figures, and what each needs for the same error."""
    shown = SHOWN[name]
    common = max(points[-1]["mse"] for points in lines.values())
    rows = []
    for label, points in lines.items():
        seconds = time_to(common, points)
        last = points[-1]
        energy = f"{100 * last['energy']:+.1f} %" if "energy" in last else ""
        rows.append([label, f"{last['samples']:.0f}", f"{last['mse']:.2e}", f"{seconds:.2f}", energy])
    return (
        f"## {shown.title}\n\n{shown.width}×{shown.height}, {shown.max_depth} edges. "
        f"Reference: {reference.origin}, its own error {100 * (reference.error or 0):.2f} % relative RMS.\n\n"
        f"![error over time](gallery/{name}-time.svg) ![error over samples](gallery/{name}-samples.svg)\n\n"
        + table(
            [
                "renderer",
                "samples at most",
                "MSE then",
                f"seconds to MSE {common:.2e}",
                "energy against ours",
            ],
            rows,
        )
    )


def time_to(error: float, points: list[dict[str, float]]) -> float:
    """Core seconds after which a curve is at an error, on log axes; the last point's where it never is."""
    x = np.log([max(p["seconds"], 1e-9) for p in points])
    y = np.minimum.accumulate(np.log([max(p["mse"], 1e-300) for p in points]))
    return float(np.exp(np.interp(-np.log(error), -y, x)))


def ladder_text(
    name: str,
    scene: Scene,
    settings: RenderSettings,
    reference: Reference,
    seconds: float,
    pictures: Path,
) -> str:
    """The lecture's integrators on one scene, each for the same time."""
    shown = SHOWN[name]
    cells, rows = [], []
    for rung in LADDER:
        contender = Contender(rung, replace(settings, integrator=rung), scene)
        runs = measure(contender, reference.picture, seconds, 1)
        path = pictures / f"{name}-{rung}.png"
        save(path, figures.picture(runs.mean.mean[::-1]))
        cells.append(f"![{rung}](gallery/{path.name})")
        found = bias(runs.mean, reference.picture)
        error = mse(runs.mean.mean, reference.picture) ** 0.5 / reference.picture.mean.mean()
        told = verdict(scene, contender.settings, settings.max_depth, found) or "no bias beyond noise"
        rows.append([f"`{rung}`", f"{runs.points[0][-1].samples:.0f}", f"{100 * error:.1f} %", told])
    save(pictures / f"{name}-reference.png", figures.picture(reference.picture.mean[::-1]))
    heads = [f"`{rung}`" for rung in LADDER[:3]], [f"`{rung}`" for rung in LADDER[3:]]
    return (
        f"## The ladder at equal time: {shown.title}\n\n{seconds:g} core seconds each.\n\n"
        + table(heads[0], [cells[:3]])
        + "\n\n"
        + table(heads[1], [cells[3:]])
        + "\n\n"
        + table(["integrator", "samples", "RMS error over the mean", "what it sees"], rows)
    )


def save(path: Path, content: str) -> None:
    """An SVG's text, or the PNG in a data URL."""
    if content.startswith("data:"):
        path.write_bytes(base64.b64decode(content.partition(",")[2]))
    else:
        path.write_text(content, encoding="utf-8")


def written(arguments: Any) -> None:
    """Carry out `python -m bench gallery`."""
    names = tuple(arguments.scene or SHOWN)
    target = arguments.json.parent if arguments.json else machine.ROOT / "docs"
    text = gallery(arguments.folder.resolve(), names, arguments.seconds, not arguments.no_peers, target)
    (target / "gallery.md").write_text(text, encoding="utf-8")
    sys.stdout.write(text)
