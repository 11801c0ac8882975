"""The page of nodes: every kind, setting and output of this Blender, ours beside Cycles'."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from support.parity import cases, measure
from support.parity.cases import Case, recipe
from support.parity.measure import EXTREME, HOSTILE, ORDINARY, TOLERANCE, Finding

from pt_engine.nodes import catalogue  # noqa: F401  (fills the registry)
from pt_engine.nodes.coverage import EXACT
from pt_engine.nodes.registry import NODES, SHADERS

from .report import table

HEADER = """# Shader nodes against Cycles

Made by `python -m bench.parity` with Blender {version}; not edited by hand. Every node of the shader editor
whose outputs are values, under every combination of its settings: the output as emission, one sample a
pixel, rendered by Cycles and evaluated by us. Each row is {ordinary} pixels of ordinary inputs, {hostile} of
hostile ones (zeros, negatives, integers and their neighbours, the tiny and the huge, so far as Cycles itself
neither divides by 0 nor overflows) and {extreme} of extreme ones (up to 1e20 in every input).

Differences are |ours − Cycles| / (|Cycles| + 0.01). **Exact**: at most {tolerance:g} at every ordinary pixel,
and at all hostile ones but {share:.0%}. *Torn*: share of pixels, ordinary / hostile, that differ more, but
whose Cycles value lies among ours of inputs four units in the last place away: jumps, borders of cells,
cancellation. *Extreme*: share of pixels that are equal or torn. Maximum and mean are those of the
ordinary pixels that are not torn.

"""


def page(kinds: Sequence[str]) -> str:
    """The whole page, or a part for some kinds."""
    asked = list(kinds) or cases.kinds()
    known = [kind for kind in asked if kind in NODES]
    every = [case for kind in known for case in cases.cases(kind)]
    findings = measure.measured(every)
    header = HEADER.format(
        version=bpy.app.version_string,
        ordinary=size(ORDINARY),
        hostile=size(HOSTILE),
        extreme=size(EXTREME),
        tolerance=TOLERANCE,
        share=measure.HOSTILE_SHARE,
    )
    sheets = [f for f in findings if f.state == EXACT and not f.reads]
    return (
        "\n\n".join(
            [
                header + summary(sheets),
                "## On sheets\n\n" + table(COLUMNS, [row(f) for f in sheets]),
                "## Not exact, and said so\n\n"
                + table(
                    ["node", "settings", "output", "state", "effect"],
                    [said(f) for f in findings if f.state != EXACT],
                ),
                "## They look at the scene\n\nNo sheet can tell whether these are right; other tests do.\n\n"
                + table(
                    ["node", "settings", "outputs"],
                    looking([f for f in findings if f.state == EXACT and f.reads]),
                ),
                "## Not registered\n\n" + table(["node", "what becomes of it"], absent(asked)),
            ]
        )
        + "\n"
    )


COLUMNS = ["node", "settings", "output", "max", "mean", "torn", "extreme", "state"]


def size(part: slice) -> int:
    """Number of faces."""
    return int(part.stop - part.start)


def summary(sheets: Sequence[Finding]) -> str:
    """How many are exact, in a sentence."""
    exact = sum(f.is_exact for f in sheets)
    kinds = {f.case.kind for f in sheets}
    whole = sum(all(f.is_exact for f in sheets if f.case.kind == kind) for kind in kinds)
    return (
        f"{exact} of {len(sheets)} rows are exact, {whole} of {len(kinds)} kinds of nodes in all their rows."
    )


def row(f: Finding) -> list[str]:
    """One line of the table."""
    smooth = f.error[ORDINARY][~f.torn[ORDINARY]]
    torn = " / ".join(f"{f.torn[part].mean():.0%}" for part in (ORDINARY, HOSTILE))
    return [
        f.case.kind,
        f.case.words,
        f.case.output,
        f"{smooth.max(initial=0):.1e}",
        f"{smooth.mean() if smooth.size else 0:.1e}",
        "" if torn == "0% / 0%" else torn,
        f"{1 - np.mean(f.wrong[EXTREME]):.0%}",
        state(f),
    ]


# Where what is left is Cycles' own rounding, found by moving our numbers by units in the last place
FLOAT_SKY = (
    "half a metre at Earth's radius moves a twelfth of Cycles' float32 table by more than 1e-4, up to 5e-4"
)
ROUNDED = {("TexSky", "MULTIPLE_SCATTERING"): FLOAT_SKY}


def state(f: Finding) -> str:
    """Exact, or where it differs and why."""
    if f.is_exact:
        return "exact"
    where = "**differs**" if f.wrong[ORDINARY].any() else "**differs** at hostile faces alone"
    why = ROUNDED.get((f.case.kind, f.case.words))
    return f"{where}: {why}" if why else where


def said(f: Finding) -> list[str]:
    """A node that is not exact, in its own words."""
    return [f.case.kind, f.case.words, f.case.output, f.state, f.effect]


def looking(findings: Sequence[Finding]) -> list[list[str]]:
    """Kinds that read the scene, with their outputs, one line a setting."""
    lines: dict[tuple[str, str], list[str]] = {}
    for f in findings:
        lines.setdefault((f.case.kind, f.case.words), []).append(f.case.output)
    return [[kind, words, ", ".join(outputs)] for (kind, words), outputs in lines.items()]


def absent(kinds: Sequence[str]) -> list[list[str]]:
    """Kinds of this Blender that no table of ours has, or that a sheet cannot ask about."""
    rows = []
    for kind in kinds:
        if kind in NODES and recipe(kind).elsewhere:
            rows.append([kind, f"asked about in {recipe(kind).elsewhere}"])
        elif kind not in NODES and kind not in SHADERS:
            rows.append([kind, fate(kind)])
    return rows


def fate(kind: str) -> str:
    """What we do with a kind that is not registered."""
    if kind.startswith("Output"):
        return "an output: read by the export"
    if kind.startswith("Volume"):
        return "volumes are left out"
    example: tuple[Case, ...] = cases.cases(kind)
    return "its links carry their sockets' defaults" if example else "black where it is a shader"
