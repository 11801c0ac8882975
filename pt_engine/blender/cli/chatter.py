"""What Blender itself prints: kept off the terminal. Imports nothing that may be missing."""

from __future__ import annotations

import faulthandler
import io
import os
import sys
from contextlib import nullcontext, redirect_stdout


def silence_blender() -> None:
    """Keep what Blender itself prints off the terminal, from here to the end of the process.

    Python's own streams go on: they get copies of the file descriptors.
    """
    streams = []
    for stream, number in ((sys.stdout, 1), (sys.stderr, 2)):
        stream.flush()
        raw = os.fdopen(os.dup(number), "wb")
        streams.append(Own(raw, encoding=stream.encoding, errors="backslashreplace", line_buffering=True))
    sys.stdout, sys.stderr = streams
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for number in (1, 2):
        os.dup2(nowhere, number)
    os.close(nowhere)
    faulthandler.enable(file=sys.stderr)


def unechoed():
    """A context for Blender's operators: they print what they report, though they raise it too."""
    return nullcontext() if Chatter.wanted else redirect_stdout(io.StringIO())


class Chatter:
    """Whether Blender's own messages go to the terminal (--verbose)."""

    wanted = False


class Own(io.TextIOWrapper):
    """One of Python's streams, apart from Blender's."""
