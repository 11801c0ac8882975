"""docs/material-library.md: some hundred node materials of a public library, on a shader ball.

`python -m bench.materials_library [FILE ...]`; where the files are looked for: tests/support/materials.py.
Each file has a process of its own, which starts again after a material that ends it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from .machine import ROOT
from .report import table

sys.path.insert(0, str(ROOT / "tests"))

import bpy
from support import materials

PAGE = ROOT / "docs" / "material-library.md"
MARK = "outcome: "  # before the lines that are meant for us: Blender prints too
SECONDS = 300  # for one material
HEADER = """# A library of node materials

Made by `python -m bench.materials_library`; not edited by hand. The materials of
artistafrustrado/materials_library (GitHub, CC0), saved by Blender 2.76 and converted by Blender {version} as
it opens them, each on a ball over a plane under even light: exported, compiled, rendered ({size} × {size}
pixels, {samples} samples, two seeds); where all its nodes are exact, compared with Cycles. *Differs*: more
than {limit:.0%} of the mean beyond the noise, and significantly (p < 0.001).

"""


def main() -> None:
    """Parse the command line, run, write the page."""
    parser = argparse.ArgumentParser(prog="python -m bench.materials_library", description=__doc__)
    parser.add_argument("files", nargs="*", help="names without .blend (default: all)")
    parser.add_argument("--size", type=int, default=32)
    parser.add_argument("--samples", type=int, default=8)
    parser.add_argument("--json", type=Path, default=ROOT / "out" / "materials.json", help="all outcomes")
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    folder = materials.library()
    if folder is None:
        sys.exit("no material library: set PT_MATERIALS to the folder of its .blend files")
    files = [f for f in sorted(folder.glob("*.blend")) if not arguments.files or f.stem in arguments.files]
    if arguments.child is not None:
        for name in materials.names(files[0])[arguments.child :]:
            outcome = materials.tried(files[0], name, arguments.size, arguments.samples)
            print("\n" + MARK + json.dumps(outcome.plain()), flush=True)
        return
    outcomes = [
        o for f in files for o in outcomes_of(f, materials.names(f), arguments.size, arguments.samples)
    ]
    arguments.json.parent.mkdir(parents=True, exist_ok=True)
    arguments.json.write_text(json.dumps([o.plain() for o in outcomes], indent=1), encoding="utf-8")
    text = page(outcomes, arguments.size, arguments.samples)
    if arguments.files:
        print(text)
    else:
        PAGE.write_text(text, encoding="utf-8")


def outcomes_of(file: Path, names: Sequence[str], size: int, samples: int) -> Iterator[materials.Outcome]:
    """Outcomes of a file's materials, from processes of their own."""
    done = 0
    while done < len(names):
        command = [sys.executable, "-m", "bench.materials_library", file.stem, "--child", str(done)]
        command += ["--size", str(size), "--samples", str(samples)]
        end = ""
        try:
            limit = SECONDS + 20 * (len(names) - done)
            run = subprocess.run(
                command, cwd=ROOT, capture_output=True, text=True, timeout=limit, check=False
            )
            output, end = run.stdout, f"the process ended with code {run.returncode}"
        except subprocess.TimeoutExpired as late:
            output = (late.stdout or b"").decode() if isinstance(late.stdout, bytes) else late.stdout or ""
            end = f"no answer within {limit} s"
        for line in output.splitlines():
            if line.startswith(MARK):
                yield materials.Outcome(**json.loads(line.removeprefix(MARK)))
                done += 1
        if done < len(names):
            yield materials.Outcome(file.stem, names[done], failure=end)
            done += 1
        print(f"{file.stem}: {done} of {len(names)}", flush=True)


def page(outcomes: Sequence[materials.Outcome], size: int, samples: int) -> str:
    """The whole page."""
    header = ["file", "materials", "nodes", "exact", "approximate", "ignored", "wholly exact"]
    header += ["compared", "differ", "not finite", "failed"]
    files = {o.file: [x for x in outcomes if x.file == o.file] for o in outcomes}
    rows = [[name, *counts(part)] for name, part in files.items()] + [["**all**", *counts(outcomes)]]
    text = HEADER.format(version=bpy.app.version_string, size=size, samples=samples, limit=materials.LIMIT)
    text += table(header, rows) + "\n\n## What is not exact\n\nBy the number of materials it concerns.\n\n"
    text += table(["node", "state", "effect", "materials", "nodes"], causes(outcomes))
    text += "\n\n## What differs or fails\n\n" + table(["file", "material", "what"], failures(outcomes))
    return text + "\n"


def counts(part: Sequence[materials.Outcome]) -> list[str]:
    """The numbers of a line of the first table."""
    states: Counter[str] = Counter()
    for o in part:
        states.update(o.states)
    total = max(sum(states.values()), 1)
    shares = [f"{states[s] / total:.1%}" for s in ("exact", "approximate", "ignored")]
    compared = [o for o in part if o.error is not None]
    return [
        str(len(part)),
        str(sum(states.values())),
        *shares,
        str(sum(o.is_exact and not o.failure for o in part)),
        str(len(compared)),
        str(sum(o.differs for o in compared)),
        str(sum(not o.finite for o in part)),
        str(sum(bool(o.failure) for o in part)),
    ]


def causes(outcomes: Sequence[materials.Outcome]) -> list[list[str]]:
    """(kind, state, effect) by frequency."""
    nodes: Counter[tuple[str, str, str]] = Counter(tuple(c) for o in outcomes for c in o.causes)
    of = Counter(c for o in outcomes for c in {tuple(c) for c in o.causes})
    return [[*cause, str(number), str(nodes[cause])] for cause, number in of.most_common()]


def failures(outcomes: Sequence[materials.Outcome]) -> list[list[str]]:
    """Materials that failed, are not finite or differ from Cycles."""
    rows = []
    for o in outcomes:
        if o.failure:
            rows.append([o.file, o.name, o.failure.splitlines()[-1]])
        elif not o.finite:
            rows.append([o.file, o.name, "not finite"])
        elif o.differs and o.means is not None and o.error is not None and o.noise is not None:
            means = "mean {:.3f} instead of {:.3f}".format(*o.means)
            rows.append([o.file, o.name, f"{o.error:.1%} beyond noise ({o.noise:.1%}), {means}"])
    return rows


if __name__ == "__main__":
    main()
