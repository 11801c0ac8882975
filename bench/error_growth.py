"""How far float32 leads from float64: the same scenes with the same random numbers, sample by sample.

`python -m bench.error_growth` writes docs/error-growth.md. Each precision is a process of its own
(`python -m bench.error_growth single|double FOLDER`; see `double`).
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from . import machine
from .error_scenes import scenes

SIZE, SAMPLES = (72, 48), 16
ANOTHER_WAY = (
    1e-3  # relative change of a sample beyond which some decision must have fallen otherwise, or nearly
)
ASKED = 60  # of these samples, of each scene, that are walked again to see where they part
TEXT = """# Error growth: float32 against float64

`python -m bench.error_growth` writes this page. The whole pipeline runs twice with the same random
numbers, as it is and with every float32 a float64 (`bench/double.py`), from the same snapshot files, whose
colours float32 holds exactly. The tables of the choice among lights are the same. Embree knows float32
only: it finds the triangle in both, and distance and place on it are computed anew in float64; whether a
shadow ray is blocked is its word alone.

{size[0]} × {size[1]} pixels, {samples} samples each, paths of up to 9 edges. Of the samples that differ at
all (the sky does not): the relative differences' median, 99th percentile and maximum. "image": root mean
square difference of the images over their mean. Bias: difference of the means, and in standard errors of
the differences. "Another way" counts samples that differ by more than {another_way:g} of themselves, and
pixels that have one.

{table}

Most samples are right to the last place of float32, whatever the path's length, since every hit point is
put back on its plane and every frame is made anew; one in a hundred loses a digit or two, at grazing
angles and near lamps. A constant that is rounded once, such as a sun's radiance, shows as a bias of up to
6·10⁻⁸. Three things make errors grow. At 10⁴ of its size from the zero, a scene's hit points are quantised
to 10⁻³ of that size. A strand of hair is a hundredth as wide as the scene and turns its normal as much
faster. Between mirror balls each reflection multiplies the error by the distance over half the radius. What
then meets an edge of a decision may fall to the other side; the sample is another one, just as probable,
so images differ by noise and not by bias (its σ is below 2 wherever samples went another way). Of up to
{asked} such samples of each scene, walked again vertex by vertex in both precisions, this is the first thing
that differs:

{reasons}

*Another facet*: the neighbouring triangle of the same object, of which the ray meets the common edge; or a
place on the same strand whose normal differs by more than 0.001. *An outline*: the ray passes an object's
edge on the other side. *A shadow's edge*: that of a shadow ray. *Another lobe*, *where the path ends*: a
uniform number between the two chances of a lobe, or of survival. *Amplified*: every decision fell alike,
and rounding grew past {another_way:g} on the way: at grazing angles, at nearly ideal reflections of a
lamp, in densities of small light, and at bumps, whose slopes are differences of nearly equal heights.
"""


def settings(**more: Any) -> Any:
    from pt_engine.render.settings import RenderSettings

    return RenderSettings(*SIZE, threads=1, max_depth=9, **more)


def measure(precision: str, folder: Path) -> None:
    """Every sample of every scene into FOLDER/PRECISION.npz; or the stories of those in FOLDER/asked.json."""
    if precision == "double":
        from .double import enter

        enter()
    from pt_engine.render import integrators  # noqa: F401  fills the registry
    from pt_engine.render.progressive import render
    from pt_engine.render.replay import replay
    from pt_engine.scene.prepare import prepare
    from pt_engine.scene.snapshot_io import load_snapshot

    wanted = folder / "asked.json"
    asked = json.loads(wanted.read_text(encoding="utf-8")) if wanted.exists() else None
    pictures: dict[str, Any] = {}
    stories: dict[str, Any] = {}
    for number, name in enumerate(scenes()):
        scene = prepare(load_snapshot(folder / f"{number}.snapshot"))
        if asked is None:
            parts = (render(scene, settings(samples=1, first_sample=k)).image() for k in range(SAMPLES))
            pictures[name] = np.array([part[..., :3] for part in parts], np.float64)
            continue
        paths = (replay(scene, settings(samples=SAMPLES), x, y, k) for k, y, x in asked[name])
        stories[name] = [[told(event) for event in path.events] for path in paths]
    if asked is None:
        np.savez(folder / f"{precision}.npz", **pictures)
    else:
        (folder / f"{precision}.json").write_text(json.dumps(stories), encoding="utf-8")


def told(event: Any) -> dict[str, Any]:
    """What of an event is a decision, and the normal, which tells the facet."""
    words = {name: value for name, value in event.numbers.items() if isinstance(value, str)}
    normal = event.numbers.get("normal")
    return {"what": event.what, **words, "normal": None if normal is None else [float(x) for x in normal]}


def parting(one: list[dict[str, Any]], other: list[dict[str, Any]]) -> str:
    """The first decision that fell otherwise."""
    for a, b in zip(one, other, strict=False):
        if a["what"] != b["what"]:
            leaves = "the ray leaves the scene" in (a["what"], b["what"])
            return "an outline: hit or missed" if leaves else "where the path ends"
        if a.get("object") != b.get("object"):
            return "an outline: another object"
        if a.get("shadow_ray") != b.get("shadow_ray"):
            return "a shadow's edge, or the horizon"
        if a.get("lobe") != b.get("lobe"):
            return "another lobe"
        if a["normal"] and np.abs(np.subtract(a["normal"], b["normal"])).max() > 1e-3:
            return "another facet"
    return "amplified" if len(one) == len(other) else "where the path ends"


def main() -> None:
    """Both precisions, then both again for the samples that differ; the page."""
    from pt_engine.scene.snapshot_io import save_snapshot

    folder = machine.ROOT / "out" / "error-growth"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "asked.json").unlink(missing_ok=True)
    for number, snapshot in enumerate(scenes().values()):
        save_snapshot(snapshot, folder / f"{number}.snapshot")
    both = [pictures(precision, folder) for precision in ("single", "double")]
    rows, asked = [], {}
    for name in both[0]:
        row, differing = compared(both[0][name], both[1][name])
        rows.append(f"| {name} | {row} |")
        asked[name] = differing[:ASKED].tolist()
    (folder / "asked.json").write_text(json.dumps(asked), encoding="utf-8")
    stories = [story(precision, folder) for precision in ("single", "double")]
    reasons = {
        name: [parting(*pair) for pair in zip(*(s[name] for s in stories), strict=True)] for name in asked
    }
    head = "| scene | median | 99 % | largest | image | bias | another way: samples | pixels |\n"
    head += "| --- " * 8 + "|\n"
    text = TEXT.format(
        size=SIZE,
        samples=SAMPLES,
        another_way=ANOTHER_WAY,
        asked=ASKED,
        table=head + "\n".join(rows),
        reasons=reason_table(reasons),
    )
    (machine.ROOT / "docs" / "error-growth.md").write_text(text, encoding="utf-8")


def pictures(precision: str, folder: Path) -> dict[str, Any]:
    """(samples, rows, columns, 3) of each scene."""
    machine.run(["bench.error_growth", precision, str(folder)])
    with np.load(folder / f"{precision}.npz") as file:
        return dict(file)


def story(precision: str, folder: Path) -> dict[str, Any]:
    """Events of the samples that were asked for, by scene."""
    machine.run(["bench.error_growth", precision, str(folder)])
    found: dict[str, Any] = json.loads((folder / f"{precision}.json").read_text(encoding="utf-8"))
    return found


def compared(single: Any, double: Any) -> tuple[str, Any]:
    """A row of the table, and (sample, y, x) of the samples that went another way."""
    size = double.sum(axis=3)
    change = np.abs(single - double).sum(axis=3)
    relative = change / np.maximum(np.maximum(size, single.sum(axis=3)), 1e-12)
    typical = " | ".join(f"{x:.1e}" for x in np.percentile(relative[change > 0], (50, 99, 100)))
    image = np.sqrt(((single - double).mean(axis=0) ** 2).mean()) / double.mean()
    means = (single - double).sum(axis=3).mean(axis=0)
    bias = means.mean() / size.mean()
    sigma = means.mean() / max(means.std() / np.sqrt(means.size), 1e-30)
    differing = np.argwhere(change > ANOTHER_WAY * np.maximum(size, 1e-3 * size.mean()))
    pixels = len(np.unique(differing[:, 1:], axis=0))
    share = f"{len(differing)} of {size.size:,} | {pixels} of {means.size:,}"
    return f"{typical} | {image:.1e} | {bias:+.1e} ({sigma:+.1f} σ) | {share}", differing


def reason_table(reasons: dict[str, list[str]]) -> str:
    """How often each, by scene."""
    kinds = sorted({kind for found in reasons.values() for kind in found})
    rows = [f"| scene | {' | '.join(kinds)} |", "| --- |" + " --- |" * len(kinds)]
    for name, found in reasons.items():
        rows.append(f"| {name} | " + " | ".join(str(found.count(kind)) for kind in kinds) + " |")
    return "\n".join(rows)


if __name__ == "__main__":
    if len(sys.argv) == 3:
        measure(sys.argv[1], Path(sys.argv[2]))
    else:
        main()
