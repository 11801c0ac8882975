"""Packages that only the report needs; where one is missing, a message says how to get it."""

from __future__ import annotations

import importlib
from typing import Any


class MissingPackage(RuntimeError):
    """An optional package is not installed; the message says what for and how to get it."""


def optional(module: str, package: str, purpose: str) -> Any:
    """The module, imported; `purpose` is what cannot be done without it."""
    try:
        return importlib.import_module(module)
    except ImportError as problem:
        raise MissingPackage(
            f"{purpose} needs the package {package}, which is not installed: "
            f'pip install "pt_engine[report]", or pip install {package}'
        ) from problem
