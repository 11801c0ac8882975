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
from ...report.reference import Reference, cache_file, given, made
from ...report.runs import plain
from ...report.tables import comparison_lines, plural, whatif_lines
from ...report.whatif import whatif
from .. import registration
from ..failure import Failure, UsageError
from ..files import check_writable, write_all
from ..record import finite, write_json
from .blendfile import open_scene
from .drive import taken
from .terminal import Interruption


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
    with Interruption() as stop:
        reference = reference_of(arguments, found, (x1 - x0, y1 - y0), stop)
        errors: dict = {}
        result = compare(
            scene,
            settings,
            reference,
            settings.seconds or DEFAULT_SECONDS,
            arguments.seeds,
            tuple(arguments.only),
            lambda line: tell(arguments, line),
            stop.should_stop,
            errors.__setitem__,
        )
    if not result["rows"]:
        raise Failure("interrupted before the first run was complete; nothing was measured")
    result |= named(arguments)
    write = page and (lambda: page.comparison_page(arguments.report, result, reference.picture, errors))
    deliver(arguments, result, comparison_lines(result), write)
    if not result["complete"]:
        runs = sum(row["runs"] for row in result["rows"])
        raise Failure(f"interrupted after {plural(runs, 'run')}: there are no more in what is told")
    return 0


def reference_of(arguments, found, size: tuple[int, int], stop: Interruption) -> Reference:
    """A given picture, or one that is made."""
    if arguments.reference:
        if found.scene.has_catchers:
            raise UsageError(
                "--reference: with shadow catchers it is the light of the whole scene that is compared, "
                "which no picture shows: leave it out, and one is rendered"
            )
        try:
            return given(arguments.reference, *size)
        except ValueError as problem:
            raise Failure(str(problem)) from problem
    tell(arguments, "making the reference")
    cache = None if arguments.no_cache else cache_file(found.snapshot, found.settings)
    limits = arguments.reference_error, arguments.reference_seconds
    reference = made(found.scene, found.settings, *limits, cache, stop.should_stop)
    if stop.interrupted:
        kept = "" if cache is None else "; the next time goes on from there"
        raise Failure(f"interrupted while the reference was made, nothing was measured{kept}")
    return reference


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
    with Interruption() as stop:
        result = whatif(
            found.snapshot,
            found.settings,
            found.settings.seconds or DEFAULT_SECONDS,
            lambda line: tell(arguments, line),
            stop.should_stop,
        )
    if not result["effects"]:
        raise Failure("interrupted before the first effect was taken out; nothing was measured")
    result |= named(arguments)
    write = page and (lambda: page.whatif_page(arguments.report, result))
    deliver(arguments, result, whatif_lines(result), write)
    if not result["complete"]:
        raise Failure("interrupted: the effects that are not told have not been measured")
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


def deliver(arguments, result, lines, write_page=None) -> None:
    """A table on the terminal, or JSON there (`--json -`); and the files that are asked for."""
    if to_terminal(arguments):
        print(json.dumps(finite(result), indent=1, ensure_ascii=False, allow_nan=False), flush=True)
    else:
        print("\n".join(lines), flush=True)
    files: list = []
    if arguments.json and not to_terminal(arguments):
        files.append((arguments.json, lambda: write_json(arguments.json, result)))
    if write_page:
        files.append((arguments.report, write_page))
    write_all(files)
