"""What the command line understands."""

from __future__ import annotations

import argparse

from ... import __version__
from .converters import assignment, file, pair, path_ending, positive, whole

# Blender's own limits, pixels along a side; beyond them it takes the largest without a word
MOST_PIXELS, MOST_THREADS = 65536, 1024
MOST_SAMPLES = 2**32 - 1


def parser() -> argparse.ArgumentParser:
    """The parser of all commands; a wrong one ends with code 2."""
    top = argparse.ArgumentParser(
        prog="python -m pt_engine", description="A path tracer for Blender files.", allow_abbrev=False
    )
    top.add_argument("--version", action="version", version=f"pt_engine {__version__}")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")

    for add in (add_render, add_replay, add_inspections, add_compare, add_whatif, add_selftest):
        add(commands)
    return top


def add_render(commands) -> None:
    """The command that makes pictures."""
    render = commands.add_parser(
        "render",
        allow_abbrev=False,
        help="render a .blend into an EXR and a PNG",
        description="Render one frame of a .blend. Scripts in the file are not run; "
        "its compositing and sequencer are left out. Views become files of their own (OUT_L.exr, OUT_R.exr). "
        "Ctrl-C ends it and keeps what there is; a second one leaves at once.",
    )
    add_scene_options(render)
    output = render.add_argument_group("output")
    output.add_argument(
        "-o",
        "--output",
        type=path_ending("exr"),
        required=True,
        metavar="OUT.exr",
        help="32-bit float, linear",
    )
    output.add_argument(
        "--png", type=path_ending("png"), metavar="P.png", help="through the file's view transform"
    )
    output.add_argument(
        "--passes",
        action="store_true",
        help="with Standard Error, Sample Count, Half A and B as layers of the EXR",
    )
    output.add_argument(
        "--stats", type=path_ending("json"), metavar="S.json", help="statistics (docs/stats.md)"
    )
    output.add_argument("--report", type=path_ending("html"), metavar="P.html", help="a page to read")
    output.add_argument("--progress", action="store_true", help="a progress bar even without a terminal")
    output.add_argument("--quiet", action="store_true", help="only errors")


def add_replay(commands) -> None:
    """The command that walks one path again."""
    replay = commands.add_parser(
        "replay",
        allow_abbrev=False,
        help="print one path of a render, vertex by vertex",
        description="Walk one sample of one pixel again, exactly as `render` with the same options did.",
    )
    add_scene_options(replay)
    replay.add_argument(
        "--pixel",
        type=pair(",", least=0, most=MOST_PIXELS),
        required=True,
        metavar="X,Y",
        help="from the image's left and bottom, from 0",
    )
    replay.add_argument(
        "--sample",
        type=whole(0, MOST_SAMPLES),
        required=True,
        metavar="N",
        help="the sample's number, from 0",
    )
    replay.add_argument("--view", metavar="NAME", help="of a multi-view render (default: its first)")


def add_selftest(commands) -> None:
    """The command that needs no file."""
    selftest = commands.add_parser(
        "selftest",
        allow_abbrev=False,
        help="run the hard cases on this machine and print their table",
        description="What breaks renderers, what is expected there and what is measured here; "
        "needs no Blender. Ends with code 1 if a case fails.",
    )
    selftest.add_argument("--all", action="store_true", help="the slow cases too")
    selftest.add_argument(
        "--markdown", type=path_ending("md"), metavar="F.md", help="write the table as a page, too"
    )


def add_inspections(commands) -> None:
    """The commands that render nothing."""
    coverage = commands.add_parser(
        "coverage",
        allow_abbrev=False,
        help="list what of a .blend is rendered exactly, and what is not",
        description="Node by node, without rendering: exact, approximate and how, ignored and what that "
        "does to the image; and what else the file asks for.",
    )
    coverage.add_argument("--json", action="store_true", help="print it as JSON")
    explain = commands.add_parser(
        "explain",
        allow_abbrev=False,
        help="print the program that a material was compiled to",
        description="Its steps with what each costs, what was folded to constants, shared or dropped, "
        "its closures, and the materials that are shaded with it.",
    )
    for command in (coverage, explain):
        add_scene_options(command)
    explain.add_argument("material", metavar="MATERIAL")


def add_compare(commands) -> None:
    """The command that says which estimator is worth its time."""
    compare = commands.add_parser(
        "compare",
        allow_abbrev=False,
        help="estimators and settings side by side on a .blend; or two images",
        description="Integrators, samplers, roulette, depths and light selection at equal time and at equal "
        "samples: error, slope, efficiency, bias, and what each cannot see. --seconds are CPU core seconds "
        "of each run (default 4). With two images: MSE, relMSE, FLIP, and a z-test where they have a pass "
        "Standard Error; the second is the reference.",
    )
    compare.add_argument("--seeds", type=whole(1), default=4, metavar="N", help="runs of each (default 4)")
    compare.add_argument(
        "--only",
        action="append",
        default=[],
        metavar="WORD",
        help="leave out what has no such word in its name; may be repeated",
    )
    compare.add_argument("--reference", type=path_ending("exr"), metavar="R.exr", help="in place of our own")
    compare.add_argument(
        "--reference-error",
        type=positive,
        default=0.01,
        metavar="E",
        help="relative RMS error that our own reference is made to (default 0.01)",
    )
    compare.add_argument(
        "--reference-seconds",
        type=positive,
        default=60.0,
        metavar="S",
        help="but for no more core seconds than that (default 60)",
    )
    compare.add_argument("--no-cache", action="store_true", help="keep no reference for the next time")
    add_results(compare)
    compare.add_argument("other", type=file, nargs="?", metavar="B.exr", help="compares image FILE with it")


def add_whatif(commands) -> None:
    """The command that says what each effect costs."""
    whatif = commands.add_parser(
        "whatif",
        allow_abbrev=False,
        help="what each effect of a .blend costs, and what it does to the image",
        description="Renders with one effect at a time taken out: soft shadows, depth of field, glossy "
        "bounces, caustics, transparency ... --seconds are CPU core seconds of each render (default 4).",
    )
    add_results(whatif)


def add_results(command: argparse.ArgumentParser) -> None:
    """The file, and where the findings go."""
    add_scene_options(command)
    output = command.add_argument_group("output")
    output.add_argument(
        "--json",
        type=path_ending("json", or_dash=True),
        metavar="F.json",
        help="the results as JSON; - for here",
    )
    output.add_argument("--report", type=path_ending("html"), metavar="P.html", help="a page to read")
    output.add_argument("--quiet", action="store_true", help="no progress")


def add_scene_options(command: argparse.ArgumentParser) -> None:
    """The file, and what of it is changed for this render."""
    command.add_argument("file", type=file, metavar="FILE.blend")
    command.add_argument("--verbose", action="store_true", help="let Blender's own messages through")
    scene = command.add_argument_group("in place of what the file says")
    scene.add_argument("--frame", type=int, metavar="N")
    scene.add_argument(
        "--view-layer", metavar="NAME", help="the only one that is rendered (default: the active one)"
    )
    scene.add_argument("--size", type=pair("x", least=1, most=MOST_PIXELS), metavar="WxH", help="in pixels")
    scene.add_argument("--samples", type=whole(0), metavar="N", help="per pixel; 0 for no limit")
    scene.add_argument("--seconds", type=positive, metavar="S", help="time limit; 0 for none")
    scene.add_argument(
        "--target-error",
        type=positive,
        metavar="E",
        help="relative error at which the render ends, 0.01 for 1 %%; no limit of samples unless given",
    )
    scene.add_argument(
        "--target-percentile", type=positive, metavar="P", help="... of P %% of the pixels, not of the image"
    )
    scene.add_argument("--min-samples", type=whole(4), metavar="N", help="before the error decides anything")
    scene.add_argument(
        "--adaptive", action="store_true", help="pixels with little noise around them stop early"
    )
    scene.add_argument("--seed", type=whole(0), metavar="K")
    scene.add_argument("--threads", type=whole(0, MOST_THREADS), metavar="N", help="0 for one per core")
    scene.add_argument("--integrator", metavar="NAME")
    scene.add_argument("--max-depth", type=whole(1), metavar="N", help="longest path, in edges")
    scene.add_argument("--strict", action="store_true", help="refuse what can't be rendered exactly")
    scene.add_argument(
        "--set",
        dest="assignments",
        action="append",
        default=[],
        type=assignment,
        metavar="KEY=VALUE",
        help="any property of the engine; may be repeated",
    )
    scene.add_argument(
        "--plugin",
        dest="plugins",
        action="append",
        default=[],
        type=file,
        metavar="F.py",
        help="a Python file that registers an integrator of your own; may be repeated",
    )
