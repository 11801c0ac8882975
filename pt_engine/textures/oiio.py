"""OpenImageIO, imported when the first image needs it."""

from __future__ import annotations

import os
import threading
from typing import Any

_config_lock = threading.Lock()


class MissingOpenImageIO(ImportError):
    """The package is not installed; the message says how to get it."""


def openimageio() -> Any:
    """The OpenImageIO module.

    Raises
    ------
    MissingOpenImageIO
        Where the package is missing; the message says how to get it.
    """
    try:
        import OpenImageIO
    except ImportError as problem:
        raise MissingOpenImageIO(
            "images need the package OpenImageIO, which is not installed (pip install OpenImageIO)",
            name="OpenImageIO",
        ) from problem
    return OpenImageIO


def keeps(config: str) -> bool:
    """Whether OpenImageIO keeps an OpenColorIO config (a path) in memory, as it does with one per process.

    Conversions name their config by its path, and it reads that anew each time (0.1 s for Blender's); all but
    the one that $OCIO names when it is first asked. So the first path that comes here becomes that one.
    """
    default = getattr(openimageio().ColorConfig, "default_colorconfig", None)  # not in all 3.0
    if default is None:
        return False
    with _config_lock:
        before = os.environ.get("OCIO")
        os.environ["OCIO"] = config
        try:
            kept = str(default().configname())  # asking for its name reads it
        except RuntimeError:  # early versions can't hand it over
            return False
        finally:
            if before is None:
                del os.environ["OCIO"]
            else:
                os.environ["OCIO"] = before
    return kept == config
