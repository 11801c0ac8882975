"""The command line: `python -m pt_engine render FILE.blend -o OUT.exr`, and its like.

It drives Blender's own render operator with PT_ENGINE, so there is one path through the engine, not two.
Exit codes: 0 done, 1 failed with a clear line (or `coverage --strict` found something), 2 usage.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import suppress

from ..failure import Failure
from ..files import check_writable
from .arguments import parser
from .chatter import Chatter, silence_blender


def main(argv: Sequence[str] | None = None) -> int:
    """Carry out a command; the exit code."""
    arguments = parser().parse_args(argv)
    arguments.words = list(sys.argv[1:] if argv is None else argv)
    try:
        if arguments.command == "selftest":  # without Blender
            from ...selftest.command import selftest

            if arguments.markdown:
                check_writable(arguments.markdown)
            return 0 if selftest(arguments.all, arguments.markdown) else 1
        from .commands import COMMANDS

        Chatter.wanted = arguments.verbose
        code = COMMANDS[arguments.command](arguments)
    except Failure as failure:
        print(f"pt_engine: {failure}", file=sys.stderr)
        return failure.exit_code
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in REQUIRED:
            raise
        print(f"pt_engine: {error.name} is missing here: pip install {error.name}", file=sys.stderr)
        return Failure.exit_code
    return code or 0


REQUIRED = ("bpy", "embreex", "numpy", "OpenImageIO")


def run() -> None:
    """The process's own entry: Blender's chatter is kept off the terminal, and its shutdown is skipped.

    Leaving without Python's and Blender's clean-up is on purpose: nothing is left to save, and some
    versions of Blender hang there after a damaged file.
    """
    code: int | str | None = 1
    if "--verbose" not in sys.argv:
        silence_blender()
    try:
        code = main()
    except SystemExit as leaving:  # argparse
        code = leaving.code
    except KeyboardInterrupt:
        print("pt_engine: interrupted", file=sys.stderr)
    except BrokenPipeError:  # who reads the output has had enough
        code = 0
    except BaseException:
        sys.excepthook(*sys.exc_info())
    for stream in (sys.stdout, sys.stderr):
        with suppress(BrokenPipeError):
            stream.flush()
    os._exit(code if isinstance(code, int) else 0 if code is None else 1)
