"""The report page of a render, from what Blender and the record of the render have."""

from __future__ import annotations

import shlex
import tempfile
from contextlib import contextmanager
from pathlib import Path

import bpy

from ..render.settings import RenderSettings
from ..report.page import render_page
from .cli.failure import Failure
from .cli.output import save_png
from .nonfinite import settings_words

IMAGE_SETTINGS = ("media_type", "file_format", "color_mode", "color_depth", "compression", "color_management")


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
    render_page(path, statistics, shown(scene, record.has_holes), error, command_of(statistics))


def shown(scene, has_holes: bool) -> bytes | None:
    """The render result as Blender shows it, a PNG's bytes; None where there is none."""
    with tempfile.TemporaryDirectory(prefix="pt_engine") as folder, unchanged(scene.render.image_settings):
        file = Path(folder) / "picture.png"
        try:
            save_png(file, scene, has_holes)
        except Failure:
            return None
        return file.read_bytes()


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
    words += ["--samples", str(statistics["samples"])]
    return shlex.join([*words, *settings_words(settings, statistics["frame"], statistics["view_layer"])])
