"""The commands that say what accuracy costs: `compare` and `whatif`."""

from __future__ import annotations

import json
import shlex
import sys

from ...report.comparison import compare
from ...report.contenders import NO_ESTIMATOR, names
from ...report.optional import MissingPackage
from ...report.pictures import compare_files
from ...report.pictures import lines as picture_lines
from ...report.reference import cache_file, given, made
from ...report.runs import plain
from ...report.tables import comparison_lines, whatif_lines
from ...report.whatif import whatif
from .. import registration
from ..record import finite, write_json
from .blendfile import open_scene
from .drive import taken
from .failure import Failure, UsageError
from .places import check_writable


def compare_command(arguments) -> int:
    """Estimators side by side on a .blend, or two images."""
    check_json(arguments)
    if arguments.other is not None:
        return compare_images(arguments)
    if arguments.file.suffix.lower() == ".exr":
        raise UsageError("one image alone is nothing to compare: name two, or a .blend")
    page = page_for(arguments)
    found = scene_of(arguments)
    scene, settings = found.scene, found.settings
    check_sense(arguments, scene, settings)
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


def check_sense(arguments, scene, settings) -> None:
    """Refuse what would be measured in vain."""
    if settings.integrator in NO_ESTIMATOR:
        raise UsageError(
            f"the integrator {settings.integrator} estimates no light: there is nothing to compare"
        )
    every = names(scene, plain(settings))
    for word in arguments.only:
        if not any(word in name for name in every):
            raise UsageError(f"--only {word}: that is in none of the names: {', '.join(every)}")


def compare_images(arguments) -> int:
    """MSE, relMSE, FLIP and z-test of two files."""
    for path in (arguments.file, arguments.other):
        if not path.is_file():
            raise Failure(f"{path} is a directory" if path.is_dir() else f"no such file: {path}")
    if arguments.file.suffix.lower() == ".blend":
        raise UsageError(
            "a .blend and an image: --reference names the image that a .blend is measured against"
        )
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
    check_json(arguments)
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


def check_json(arguments) -> None:
    """Fail before the work where `--json` names no place to write to."""
    if arguments.json and not to_terminal(arguments):
        check_writable(arguments.json)


def to_terminal(arguments) -> bool:
    """Whether the results go to the terminal as JSON."""
    return str(arguments.json) == "-"


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
    if to_terminal(arguments):
        print(json.dumps(finite(result), indent=1, ensure_ascii=False, allow_nan=False))
        return
    if arguments.json:
        write_json(arguments.json, result)
    print("\n".join(lines))
