"""Every failure becomes one clear message and a failed render; none reaches Blender as an exception.

Blender takes an exception in `render()` for a finished render, and one that has delivered no picture for
a crash when the picture is to be written. A reported error is a failed render in every mode.
"""

from __future__ import annotations

import sys
import traceback
from contextlib import contextmanager

from ..scene.memory import TooLarge
from ..textures.oiio import MissingOpenImageIO
from .export import ExportError


class Refusal(RuntimeError):
    """The engine won't render this, and why: a message for the user, not a defect of the engine."""


EXPECTED = Refusal, ExportError, TooLarge, MissingOpenImageIO  # their text says it all


@contextmanager
def reported_to(engine, on_failure=lambda message: None):
    """Turn whatever is raised inside into `engine.report({'ERROR'}, …)`.

    Parameters
    ----------
    engine : bpy.types.RenderEngine
    on_failure : callable
        Gets the message too.
    """
    try:
        yield
    except BaseException as error:
        message = message_of(error)
        if not isinstance(error, (*EXPECTED, KeyboardInterrupt)):
            traceback.print_exc(file=sys.stderr)
        on_failure(message)
        engine.error_set(message)
        engine.report({"ERROR"}, message)


def message_of(error: BaseException) -> str:
    """What a person is told: the refusal's own words, or the kind of error and its text."""
    if isinstance(error, EXPECTED):
        return str(error)
    kind = "interrupted" if isinstance(error, KeyboardInterrupt) else type(error).__name__
    return f"{kind}: {error}" if str(error) else kind
