"""docs/items.md: what a .blend holds besides materials, beside Cycles: `python -m bench.items [GROUP ...]`.

Every item is a small scene of tests/support/items.py, rendered by Blender's own render operator with both
engines, twice each. Some minutes.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .machine import ROOT
from .report import table

sys.path.insert(0, str(ROOT / "tests"))

import bpy
from support.cycles import BOUNCES, choose_cycles, into_exr
from support.items import ITEMS
from support.shared_scenes import read_exr
from support.ztest import Agreement, compare

from pt_engine.blender import registration

SIZE, GRID = (36, 24), (6, 4)
OURS, THEIRS = 128, 256  # samples of each of two renders
CERTAIN, NEAR = 1e-4, 0.01
PAGE = ROOT / "docs" / "items.md"
HEADER = """# What a .blend holds besides materials, beside Cycles

Made by `python -m bench.items`; not edited by hand. Each item is a small scene made by a script
(tests/support/items.py), rendered twice by Blender {blender} with PT Engine and twice with Cycles.

*Difference* is that of the pictures' means, with its standard error, in per cent of Cycles' mean. *Beyond
noise* is the RMS difference of the means of 6 × 4 cells after the noise of both is taken off. *p* is the
smallest of all cells' and channels' z-tests, corrected for their number: of {number} items one or two lie
below 0.02 by chance. An item *agrees* where p > 0.0001; else it is *within 1 %* if no more is beyond the
noise.

All pixels of a picture with motion blur see the same moments, which the tests take for independent ones: its
error is larger than is said, and p smaller. Coarse smooth meshes and custom normals under a sky that varies:
directions between the horizons of the true and of the shading normal are lit by sampled lights alone, in
Cycles too, and what part of such a sky that is depends on each renderer's densities. Blender has
overscan for EEVEE alone.
"""
HEADINGS = ["item", "our samples", "Cycles' samples", "difference", "beyond noise", "p", "verdict"]


def main() -> None:
    """Render all groups or some, print the table, and write it if all were rendered."""
    parser = argparse.ArgumentParser(prog="python -m bench.items", description=__doc__)
    parser.add_argument("groups", nargs="*", metavar="GROUP", help=f"of {', '.join(ITEMS)} (default: all)")
    groups = parser.parse_args().groups or list(ITEMS)
    number = sum(len(items) for items in ITEMS.values())
    parts = [HEADER.format(blender=bpy.app.version_string, number=number)]
    for group in groups:
        rows = [row(name, make) for name, make in ITEMS[group].items()]
        parts.append(f"## {group}\n\n{table(HEADINGS, rows)}\n")
    text = "\n".join(parts)
    if len(groups) == len(ITEMS):
        PAGE.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)


def row(name: str, make: Callable[[], None]) -> list[str]:
    """One line of the table; it is told on the way too."""
    started = time.perf_counter()
    ours, theirs = pictures(make)
    found = compare(ours, theirs, GRID)
    difference, error = of_means(ours, theirs)
    print(f"{name}: {found} ({time.perf_counter() - started:.1f} s)", file=sys.stderr, flush=True)
    return [
        name,
        str(2 * OURS),
        str(2 * THEIRS),
        f"{100 * difference:+.2f} ± {100 * error:.2f} %",
        f"{100 * found.error:.2f} %",
        f"{found.p:.2g}",
        verdict(found),
    ]


def verdict(found: Agreement) -> str:
    """In a word."""
    if found.p > CERTAIN:
        return "agrees"
    return "within 1 %" if found.error < NEAR else "**differs**"


def pictures(make: Callable[[], None]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Two pictures by us and two by Cycles, of different seeds; views lie side by side."""
    registration.register()
    make()
    scene = bpy.context.scene
    own = scene.pt_engine
    choose_cycles(THEIRS, SIZE)
    into_exr()
    own.max_depth, own.transparent_depth = BOUNCES + 2, BOUNCES  # edges, and the bounces between the ends
    own.samples = OURS
    with tempfile.TemporaryDirectory() as folder:
        pairs = []
        for engine in ("PT_ENGINE", "CYCLES"):
            scene.render.engine = engine
            pairs.append([])
            for seed in (0, 1):
                scene.cycles.seed = own.seed = seed
                pairs[-1].append(rendered(Path(folder) / f"{engine}{seed}"))
    return pairs[0], pairs[1]


def rendered(path: Path) -> np.ndarray:
    """(height, width, 4) of the current file, its views side by side."""
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return np.hstack([read_exr(file) for file in sorted(path.parent.glob(f"{path.name}*.exr"))])


def of_means(ours: list[np.ndarray], theirs: list[np.ndarray]) -> tuple[float, float]:
    """Difference of the mean colours over Cycles' mean, and its standard error, pixels being independent."""
    a, b = np.float64(ours)[..., :3], np.float64(theirs)[..., :3]
    variance = ((a[0] - a[1]) ** 2 + (b[0] - b[1]) ** 2).sum() / 4
    scale = b.mean()
    return float((a.mean() - b.mean()) / scale), float(np.sqrt(variance) / a[0].size / scale)


if __name__ == "__main__":
    main()
