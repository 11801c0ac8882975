"""`python -m bench stages|renders|memory|textures|all`: measure, write JSON, and with `all` docs/numbers.md.

`python -m bench materials` writes docs/materials-speed.md.

`python -m bench gallery` writes docs/gallery.md and its pictures (beside --json FILE, if that is given).

`python -m bench page` writes docs/numbers.md from what the last separate measurements left.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from . import machine
from .scenes import made
from .shapes import MODELS

MORE = ("demo", "room", "lamps")  # of `gallery`


def main() -> None:
    """Parse the command line and measure."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    kinds = ("stages", "renders", "memory", "textures", "all", "page", "materials", "gallery")
    parser.add_argument("what", choices=kinds)
    parser.add_argument("--scene", action="append", choices=(*MODELS, *MORE), help="may be repeated")
    parser.add_argument("--sampler", default="independent", help="of `stages`")
    parser.add_argument("--passes", type=int, default=6, help="of `stages`: the best of so many")
    parser.add_argument("--seconds", type=float, default=2.0, help="of `gallery`: core seconds of each run")
    parser.add_argument("--no-peers", action="store_true", help="leave Mitsuba and Cycles out")
    parser.add_argument("--folder", type=Path, default=machine.ROOT / "out" / "bench", help="for the scenes")
    parser.add_argument("--json", type=Path, help="where to write the results (default: FOLDER/WHAT.json)")
    arguments = parser.parse_args()
    if arguments.what == "materials":
        materials_page()
        return
    if arguments.what == "gallery":
        from .gallery import written

        written(arguments)
        return
    results = measured(arguments)
    path = arguments.json or arguments.folder / f"{arguments.what}.json"
    path.write_text(json.dumps(results, indent=1), encoding="utf-8")
    from .report import page

    text = page(results)
    sys.stdout.write(text)
    if arguments.what in ("all", "page"):
        (machine.ROOT / "docs" / "numbers.md").write_text(text, encoding="utf-8")


def materials_page() -> None:
    """Measure what materials cost, and write the page."""
    from .materials import materials
    from .materials_page import page

    text = page({"machine": machine.description(), "materials": materials()})
    sys.stdout.write(text)
    (machine.ROOT / "docs" / "materials-speed.md").write_text(text, encoding="utf-8")


def measured(arguments: argparse.Namespace) -> dict[str, Any]:
    """Everything that was asked for."""
    if arguments.what == "page":
        parts = (arguments.folder / f"{what}.json" for what in ("stages", "renders", "memory", "textures"))
        found = [json.loads(part.read_text(encoding="utf-8")) for part in parts if part.exists()]
        return {key: value for part in found for key, value in part.items()}
    every = arguments.what == "all"
    needs_scenes = every or arguments.what in ("stages", "renders")
    blends = made(arguments.folder.resolve(), tuple(arguments.scene or MODELS)) if needs_scenes else {}
    results: dict[str, Any] = {"machine": machine.description()}
    if every or arguments.what == "renders":
        from .renders import renders

        results["renders"] = renders(blends, peers=not arguments.no_peers)
    if every or arguments.what == "stages":
        from .stages import stages

        machine.pin()
        results["stages"] = {n: stages(b, arguments.sampler, arguments.passes) for n, b in blends.items()}
    if every or arguments.what == "memory":
        from .memory import memory

        results["memory"] = memory()
    if every or arguments.what == "textures":
        from .textures import textures

        machine.pin()
        results["textures"] = textures()
    return results


if __name__ == "__main__":
    main()
