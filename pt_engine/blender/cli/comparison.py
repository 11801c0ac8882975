"""The commands that say what accuracy costs: `compare` and `whatif`."""

from __future__ import annotations

import json
import shlex
import sys

from ...report.comparison import compare
from ...report.optional import MissingPackage
from ...report.pictures import compare_files
from ...report.pictures import lines as picture_lines
from ...report.reference import cache_file, given, made
from ...report.tables import comparison_lines, whatif_lines
from ...report.whatif import whatif
from .. import registration
from ..record import finite
from .blendfile import open_scene
from .drive import taken
from .failure import Failure, UsageError
from .output import check_writable


def compare_command(arguments) -> int:
    """Estimators side by side on a .blend, or two images."""
    if arguments.other is not None:
        return compare_images(arguments)
    if arguments.file.suffix.lower() == ".exr":
        raise UsageError("one image alone is nothing to compare: name two, or a .blend")
    page = page_for(arguments)
    found = scene_of(arguments)
    scene, settings = found.scene, found.settings
    x0, y0, x1, y1 = settings.window
    if arguments.reference:
        try:
            reference = given(arguments.reference, x1 - x0, y1 - y0)
        except ValueError as problem:
            raise Failure(str(problem)) from problem
    else:
        tell(arguments, "making the reference")
        cache = None if arguments.no_cache else cache_file(found.snapshot, settings)
        reference = made(scene, settings, arguments.reference_error, arguments.reference_seconds, cache)
    seconds = settings.seconds or DEFAULT_SECONDS
    result = compare(
        scene,
        settings,
        reference,
        seconds,
        arguments.seeds,
        tuple(arguments.only),
        lambda line: tell(arguments, line),
    )
    result |= named(arguments)
    deliver(arguments, result, comparison_lines(result))
    if page:
        page.comparison_page(arguments.report, result, reference.picture)
    return 0


def compare_images(arguments) -> int:
    """MSE, relMSE, FLIP and z-test of two files."""
    for path in (arguments.file, arguments.other):
        if not path.is_file():
            raise Failure(f"no such file: {path}")
    if arguments.report:
        raise UsageError("--report is for a .blend; two images have a table only")
    try:
        found = compare_files(arguments.file, arguments.other)
    except ValueError as problem:
        raise Failure(str(problem)) from problem
    deliver(arguments, found, picture_lines(found))
    return 0


def whatif_command(arguments) -> int:
    """What each effect costs and what it does to the image."""
    page = page_for(arguments)
    found = scene_of(arguments)
    result = whatif(
        found.snapshot,
        found.settings,
        found.settings.seconds or DEFAULT_SECONDS,
        lambda line: tell(arguments, line),
    )
    result |= named(arguments)
    deliver(arguments, result, whatif_lines(result))
    if page:
        page.whatif_page(arguments.report, result)
    return 0


DEFAULT_SECONDS = 4.0  # of CPU cores, for each run


def named(arguments) -> dict[str, str]:
    """The file, and the command that measures it again."""
    return {
        "file": str(arguments.file),
        "command": shlex.join(["python", "-m", "pt_engine", *arguments.words]),
    }


def scene_of(arguments):
    """The prepared scene, its settings and its snapshot."""
    registration.register()
    return taken(open_scene(arguments), arguments.view_layer)


def page_for(arguments):
    """The module that writes pages, where one is wanted; a missing package is told before the work."""
    if not arguments.report:
        return None
    check_writable(arguments.report)
    from ...report import page

    try:
        page.check_packages()
    except MissingPackage as problem:
        raise Failure(str(problem)) from problem
    return page


def tell(arguments, line: str) -> None:
    """Progress, on stderr."""
    if not arguments.quiet:
        print(line, file=sys.stderr, flush=True)


def deliver(arguments, result, lines) -> None:
    """A table on the terminal, or JSON there (`--json -`) or in a file."""
    text = json.dumps(finite(result), indent=1, ensure_ascii=False, allow_nan=False)
    if arguments.json and str(arguments.json) == "-":
        print(text)
        return
    if arguments.json:
        check_writable(arguments.json)
        arguments.json.write_text(text + "\n", encoding="utf-8")
    print("\n".join(lines))
