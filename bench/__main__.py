"""`python -m bench stages|renders|memory|textures|all`: measure, write JSON, and with `all` docs/numbers.md.

`python -m bench materials` writes docs/materials-speed.md, `instances` docs/instances.md (with PT_SCENES set,
for an artist's file, too), `motion` docs/motion-blur.md.

`python -m bench gallery` writes docs/gallery.md and its pictures (beside --json FILE, if that is given).

`python -m bench page` writes docs/numbers.md from what the last separate measurements left.

Other pages are made by modules of their own (`python -m bench.NAME --help`): against Cycles by parity, items,
references and materials_library; about errors by calibration and error_growth; about speed by export and
many_lights.
"""

from __future__ import annotations

import argparse
import json
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

from . import machine
from .scenes import made
from .shapes import MODELS

MORE = ("demo", "room", "lamps")  # of `gallery`


def main() -> None:
    """Parse the command line and measure."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("what", choices=(*PAGES, *MEASUREMENTS, "all", "page"))
    parser.add_argument("--scene", action="append", choices=(*MODELS, *MORE), help="may be repeated")
    parser.add_argument("--sampler", default="independent", help="of `stages`")
    parser.add_argument("--passes", type=int, default=6, help="of `stages`: the best of so many")
    parser.add_argument("--seconds", type=float, default=2.0, help="of `gallery`: core seconds of each run")
    parser.add_argument("--no-peers", action="store_true", help="leave Mitsuba and Cycles out")
    parser.add_argument("--folder", type=Path, default=machine.ROOT / "out" / "bench", help="for the scenes")
    parser.add_argument("--json", type=Path, help="where to write the results (default: FOLDER/WHAT.json)")
    arguments = parser.parse_args()
    PAGES.get(arguments.what, numbers_page)(arguments)


def materials_page(arguments: argparse.Namespace) -> None:
    """Measure what materials cost, and write the page."""
    from .materials import materials
    from .materials_page import page

    text = page({"machine": machine.description(), "materials": materials()})
    sys.stdout.write(text)
    (machine.ROOT / "docs" / "materials-speed.md").write_text(text, encoding="utf-8")


def gallery_page(arguments: argparse.Namespace) -> None:
    """Render the gallery, and write the page."""
    from .gallery import written

    written(arguments)


def page_of_its_own(arguments: argparse.Namespace) -> None:
    """Let a module measure and write its page."""
    import_module(f".{arguments.what}", __package__).main()


def numbers_page(arguments: argparse.Namespace) -> None:
    """Measure one thing or all, or take what was left; print the page, and write it where it is whole."""
    from .report import page

    results = left_over(arguments.folder) if arguments.what == "page" else measured(arguments)
    path = arguments.json or arguments.folder / f"{arguments.what}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(results, indent=1), encoding="utf-8")
    text = page(results)
    sys.stdout.write(text)
    if arguments.what in ("all", "page"):
        (machine.ROOT / "docs" / "numbers.md").write_text(text, encoding="utf-8")


def left_over(folder: Path) -> dict[str, Any]:
    """What the last separate measurements have found."""
    parts = (folder / f"{what}.json" for what in ("stages", "renders", "memory", "textures"))
    found = [json.loads(part.read_text(encoding="utf-8")) for part in parts if part.exists()]
    return {key: value for part in found for key, value in part.items()}


def measured(arguments: argparse.Namespace) -> dict[str, Any]:
    """Everything that was asked for; renders first, for the others stay on one core."""
    results: dict[str, Any] = {"machine": machine.description()}
    for what, measure in MEASUREMENTS.items():
        if arguments.what in (what, "all"):
            results[what] = measure(arguments)
    return results


def blends(arguments: argparse.Namespace) -> dict[str, Path]:
    """The scenes that were asked for, made where they are missing."""
    return made(arguments.folder.resolve(), tuple(arguments.scene or MODELS))


def measured_renders(arguments: argparse.Namespace) -> Any:
    """Whole renders beside Embree alone and beside peers."""
    from .renders import renders

    return renders(blends(arguments), peers=not arguments.no_peers)


def measured_stages(arguments: argparse.Namespace) -> Any:
    """The stages of a pass, scene by scene."""
    from .stages import stages

    scenes = blends(arguments)
    machine.pin()
    return {n: stages(b, arguments.sampler, arguments.passes) for n, b in scenes.items()}


def measured_memory(arguments: argparse.Namespace) -> Any:
    """Bytes per triangle, pixel and thread."""
    from .memory import memory

    return memory()


def measured_textures(arguments: argparse.Namespace) -> Any:
    """Look-ups in images."""
    from .textures import textures

    machine.pin()
    return textures()


PAGES = {
    "materials": materials_page,
    "gallery": gallery_page,
    "instances": page_of_its_own,
    "motion": page_of_its_own,
}
MEASUREMENTS = {
    "renders": measured_renders,
    "stages": measured_stages,
    "memory": measured_memory,
    "textures": measured_textures,
}

if __name__ == "__main__":
    main()
