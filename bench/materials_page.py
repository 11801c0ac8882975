"""docs/materials-speed.md from the results of `bench.materials`."""

from __future__ import annotations

from typing import Any

from .report import machine_text, table

Results = dict[str, Any]

HEADER = """# What materials cost

Made by `python -m bench materials`; not edited by hand. All figures are CPU time of one thread on one core.
"""

SHADING = """## Shading alone

65,536 lanes; *programs* is what the shader graphs compute, *with BSDFs* adds one evaluation and one sample of
the closures. Graphs are chains of a noise of two octaves, a ramp, a mix and a multiplication in turn.
*Plain* Principled differ in colour and roughness, *mixed* also in what is 0 or 1: metal, smooth, black."""

FILES = """## Whole files against Cycles

Equal samples, 14 edges, no clamping, no adaptive sampling, one process and one thread per file. The two take
turns, so that the spread shows how much the machine wavers. A figure is the difference of a long and a short
render; the last, in bold, and the ratio are those of the shortest renders of all rounds. Both dice what the
file asks to be subdivided adaptively (snow, flower). Most of planet, snow and flower is noise of 16 octaves,
three times over for bumps. A third to a half of that is hashing the lattice's corners: Cycles keeps all
eight in registers; numpy takes them through the second-level cache once for each operation."""


def page(results: Results) -> str:
    """The whole page."""
    parts = [HEADER.rstrip(), machine_text(results["machine"])]
    found = results["materials"]
    rows = [(f"{n} nodes", found["nodes"][n]) for n in found["nodes"]]
    rows += [(f"{n} plain Principled", found["plain"][n]) for n in found["plain"]]
    rows += [(f"{n} mixed Principled", found["mixed"][n]) for n in found["mixed"]]
    lines = [[name, str(f["batches"]), f"{f['program']:.1f}", f"{f['all']:.1f}"] for name, f in rows]
    header = ["materials", "batches", "programs, ns per lane", "with BSDFs, ns per lane"]
    parts += [SHADING, table(header, lines)]
    if found["files"]:
        parts += [FILES, table(["file", "ours, µs per sample", "Cycles", "ours / Cycles"], file_rows(found))]
    return "\n\n".join(parts) + "\n"


def file_rows(found: Results) -> list[list[str]]:
    """One line for each file."""
    rows = []
    for name, f in found["files"].items():
        paces = [", ".join(f"{pace:.2f}" for pace in f[who][:-1]) for who in ("ours", "cycles")]
        best = [
            f"{rounds}, **{f[who][-1]:.2f}**" for rounds, who in zip(paces, ("ours", "cycles"), strict=True)
        ]
        rows.append([name, *best, f"{f['ours'][-1] / f['cycles'][-1]:.2f}"])
    return rows
