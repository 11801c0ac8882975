"""Where the artists' and the Mitsuba scenes are: they are not part of the project.

`PT_SCENES` names the folder that holds `scenes/` and `mitsuba/`; without it `../shared` beside the
project is tried. Tests that need them are skipped where they are absent.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

PROJECT = Path(__file__).resolve().parents[2]


def shared_folder(kind: str) -> Path | None:
    """The folder `scenes` or `mitsuba`, or None."""
    root = Path(os.environ.get("PT_SCENES") or PROJECT.parent / "shared")
    candidates = (root / kind, root if root.name == kind else root / kind)
    return next((path for path in candidates if path.is_dir()), None)


def folder_or_skip(kind: str) -> Path:
    """The folder `scenes` or `mitsuba`; skips the test where there is none."""
    folder = shared_folder(kind)
    if folder is None:
        pytest.skip(f"no folder of {kind} references: set PT_SCENES to the folder that holds {kind}/")
    return folder


def read_exr(path: Path | str) -> np.ndarray:
    """(height, width, channels) float32, top row first."""
    import OpenImageIO as oiio

    image = oiio.ImageInput.open(str(path))
    if image is None:
        raise OSError(f"cannot read {path}: {oiio.geterror()}")
    try:
        return np.array(image.read_image("float"), np.float32)
    finally:
        image.close()
