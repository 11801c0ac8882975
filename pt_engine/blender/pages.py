"""The report page of a render, from what Blender and the record of the render have."""

from __future__ import annotations

import shlex
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy

from ..render.settings import RenderSettings
from ..report.page import render_page
from .failure import Failure
from .nonfinite import settings_words
from .output import save_png

BY_THE_CLOCK = "time", "cancelled"
IMAGE_SETTINGS = (
    "media_type",
    "file_format",
    "color_mode",
    "color_depth",
    "compression",
    "color_management",
    "views_format",
)


def write_page(path: Path, scene, record, statistics, error) -> None:
    """Write the page of the last render.

    Parameters
    ----------
    record : RenderRecord
    statistics : dict
        Its statistics, with the time of writing where that is known.
    error : (height, width) float32 or None
        As `report.error_picture.error_picture` makes it.
    """
    render_page(
        path, statistics, shown(scene, record.has_holes), error, command_of(statistics), bpy.data.filepath
    )


def shown(scene, has_holes: bool) -> bytes | None:
    """The render result as Blender shows it (its first view), a PNG's bytes; None where there is none."""
    with tempfile.TemporaryDirectory(prefix="pt_engine") as folder, unchanged(scene.render.image_settings):
        try:
            return save_png(Path(folder) / "picture.png", scene, has_holes)[0].read_bytes()
        except Failure:
            return None


@contextmanager
def unchanged(image):
    """The file's own output settings are afterwards as before; the first decide what the others may be."""
    before = [(name, getattr(image, name)) for name in IMAGE_SETTINGS if hasattr(image, name)]
    try:
        yield
    finally:
        for name, value in before:
            setattr(image, name, value)


def command_of(statistics) -> str:
    """The command line that renders it again; the view layer is the first that was rendered."""
    settings = RenderSettings(**statistics["settings"])
    words = ["python", "-m", "pt_engine", "render", bpy.data.filepath or "FILE.blend", "-o", "OUT.exr"]
    words += settings_words(settings, statistics["frame"], statistics["view_layer"])
    for name, value in limits(settings, statistics).items():
        words += ["--set", f"{name}={value}"]
    return shlex.join(words)


def limits(settings: RenderSettings, statistics) -> dict[str, Any]:
    """What makes it end at the same samples again: what ended it, or their number if that was the clock."""
    if statistics["stopped_by"] in BY_THE_CLOCK:
        return {"samples": statistics["samples"], "seconds": 0, "target_error": 0, "adaptive": False}
    found = {name: getattr(settings, name) for name in ("samples", "target_error", "min_samples", "adaptive")}
    found |= {"seconds": 0, "target_of": "PIXELS" if settings.target_percentile else "IMAGE"}
    return found | ({"target_percentile": settings.target_percentile} if settings.target_percentile else {})
