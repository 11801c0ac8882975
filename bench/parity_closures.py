"""The page of closures: what each scatters in all, over angle and inputs; and spheres in a studio."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import bpy
from support.parity import closures, spheres
from support.parity.closures import ELSEWHERE, Patch, Reflected

from pt_engine.nodes.coverage import EXACT

from .report import table

COSINES = (1.0, 0.8, 0.5, 0.25, 0.1)
SAMPLES = 256  # per pixel, seed and picture; a patch has 16 pixels
SPHERE_SAMPLES = 64
TOLERANCE = 4e-3
HEADER = """# Closures against Cycles

Made by `python -m bench.parity` with Blender {version}; not edited by hand.

## Albedo

Patches of a plane under a white sky: what a closure of colour (0.8, 0.4, 0.1) scatters toward the camera in
all, at five cosines of the angle to the normal. Cells are max |ours − Cycles| / max(Cycles, 0.05) over the
channels, in per cent, and Cycles' own noise. Ours is a quadrature over the compiled closures. *Exact*: below
{tolerance:.1%} and four standard errors of the noise at all angles; both engines' tables for light that
bounces between facets are good to about that.

"""
SPHERES = """## Spheres

Every exact closure on a sphere under a graded sky and two softboxes, {samples} samples and two seeds by each
engine. *Beyond noise*: RMS difference of 3 × 3 cells after the noise of both is taken off, over the mean;
*p*: of the most different cell by Welch's test with both variances, corrected for their number.

"""


def page() -> str:
    """The whole page."""
    every = closures.patches()
    with tempfile.TemporaryDirectory() as folder:
        found = closures.reflected(every, COSINES, SAMPLES, Path(folder))
        balls = spheres.compared(SPHERE_SAMPLES, Path(folder))
    of: dict[Patch, list[Reflected]] = {}
    for one in found:
        of.setdefault(one.patch, []).append(one)
    header = ["closure", "settings", "input", *(f"cos {c:g}" for c in COSINES), "state"]
    parts = [
        HEADER.format(version=bpy.app.version_string, tolerance=TOLERANCE),
        table(header, [row(ones) for ones in of.values()]),
        "\n\nNot asked: " + "; ".join(f"{kind} ({why})" for kind, why in ELSEWHERE.items()) + ".\n\n",
        SPHERES.format(samples=SPHERE_SAMPLES),
        table(["closure", "beyond noise", "noise", "p", "state"], [ball(*b) for b in balls]),
    ]
    return "".join(parts) + "\n"


def row(ones: Sequence[Reflected]) -> list[str]:
    """One line: a patch at all angles."""
    patch, first = ones[0].patch, ones[0]
    cells = [f"{100 * one.error:.2f} ± {100 * one.sigma:.2f}" for one in ones]
    exact = all(one.error < TOLERANCE + 4 * one.sigma for one in ones)
    state = (
        ("exact" if exact else "**differs**") if first.state == EXACT else f"{first.state}: {first.effect}"
    )
    words = " ".join(str(value) for _, value in patch.settings)
    inputs = ", ".join(f"{name} {value:g}" for name, value in patch.inputs)
    return [patch.kind, words, inputs, *cells, state]


def ball(name: str, agreement: spheres.Agreement) -> list[str]:
    """One line: a sphere."""
    return [
        name,
        f"{100 * agreement.error:.2f} % (≤ {100 * agreement.error_high:.2f} %)",
        f"{100 * agreement.noise:.2f} %",
        f"{agreement.p:.2g}",
        "agrees" if agreement.agrees(tolerance=0.01) else "**differs**",
    ]
