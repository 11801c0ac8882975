"""OpenImageIO, imported when the first image needs it."""

from __future__ import annotations

from typing import Any


def openimageio() -> Any:
    """The OpenImageIO module.

    Raises
    ------
    RuntimeError
        Where the package is missing; the message says how to get it.
    """
    try:
        import OpenImageIO
    except ImportError as problem:
        raise RuntimeError(
            "image textures need the package OpenImageIO, which is not installed (pip install OpenImageIO)"
        ) from problem
    return OpenImageIO
