"""docs/references.md: how far each artists' file is from Cycles: `python -m bench.references`.

The files are looked for as the tests do (see tests/support/shared_scenes.py).
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from .machine import ROOT
from .report import table

sys.path.insert(0, str(ROOT / "tests"))

from support.artists import CASES
from support.references import Case, Outcome, outcome
from support.shared_scenes import shared_folder

HEADER = """# Artists' files against Cycles

Made by `python -m bench.references`; not edited by hand. Twenty files from public repositories, rendered
through the command line with two seeds, against two renders by Cycles 5.2 (14 edges, no clamping).

*Beyond noise* is the RMS difference of the means of 12 × 8 cells after the noise of both is taken off,
over the image's mean, and the upper end of its interval; *noise* is that of a cell; *p* is the smallest
of all cells', corrected for their number: differences show as tiny p.
"""


def row(case: Case, found: Outcome) -> list[str]:
    """One line of the table."""
    a = found.agreement
    if a.error < 0.03:
        cause = "agrees" if a.p > 1e-3 else "below 3 %"
    else:
        cause = case.cause or "**not explained yet**"
    gaps = "; ".join(found.gaps[:4]) + (f"; {len(found.gaps) - 4} more" if len(found.gaps) > 4 else "")
    return [
        case.name,
        str(case.samples * 2),
        f"{100 * a.error:.2f} % (≤ {100 * a.error_high:.2f} %)",
        f"{100 * a.noise:.2f} %",
        f"{a.p:.2g}",
        f"{found.statistics['seconds']['total']:.1f}",
        cause,
        gaps or "none",
    ]


def main() -> None:
    """Render all or some, print the table, and write it if all were rendered."""
    parser = argparse.ArgumentParser(prog="python -m bench.references", description=__doc__)
    parser.add_argument("names", nargs="*", help="default: all")
    parser.add_argument("--samples", type=int, help="per pixel and seed (default: as in the tests)")
    parser.add_argument("--output", type=Path, default=ROOT / "docs" / "references.md")
    arguments = parser.parse_args()
    scenes = shared_folder("scenes")
    if scenes is None:
        sys.exit("no artists' files: set PT_SCENES to the folder that holds scenes/")
    rows = []
    for case in CASES:
        if arguments.names and case.name not in arguments.names:
            continue
        try:
            found = outcome(case, scenes, arguments.samples)
        except RuntimeError as error:
            print(f"{case.name}: {error}", flush=True)
            rows.append([case.name, "", "", "", "", "", f"failed: {str(error).splitlines()[-1]}", ""])
            continue
        print(f"{case.name}: {found.agreement}; {len(found.gaps)} gaps", flush=True)
        rows.append(row(case, found))
    header = ["file", "samples", "beyond noise", "noise", "p", "seconds", "cause", "not exact or ignored"]
    text = f"{HEADER}\n{table(header, rows)}\n"
    if arguments.names:
        print(text)
    else:
        arguments.output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
