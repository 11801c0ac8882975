"""Files that a render leaves: checked before it starts, written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import bpy

from .failure import Failure


def check_writable(path: Path) -> None:
    """Fail now rather than after an hour's render. Missing folders are made."""
    try:
        if path.is_dir():
            raise IsADirectoryError("it is a directory")
        path.absolute().parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path.absolute().parent):
            pass
        if path.exists() and not os.access(path, os.W_OK):
            raise PermissionError("it is write-protected")
    except FileExistsError as error:
        raise Failure(f"can't write {path}: {error.filename} is not a folder") from error
    except OSError as error:
        raise Failure(f"can't write {path}: {error.strerror or error}") from error


def save_exr(path: Path, scene) -> None:
    """The render result in linear 32-bit floats."""
    image = scene.render.image_settings
    if hasattr(image, "media_type"):  # Blender 5
        image.media_type = "IMAGE"
    image.file_format = "OPEN_EXR"
    image.color_mode, image.color_depth, image.exr_codec = "RGBA", "32", "ZIP"
    save(path, scene)


def save_png(path: Path, scene, has_holes: bool) -> None:
    """The render result as Blender shows it: through the file's view transform, exposure and look.

    With an alpha channel where the film is transparent or holdouts have cut holes into it.
    """
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format = "PNG"
    image.color_mode = "RGBA" if scene.render.film_transparent or has_holes else "RGB"
    image.color_depth, image.compression = "8", 15
    save(path, scene)


def save(path: Path, scene) -> None:
    """Save under another name first, so that a broken write leaves an earlier picture alone."""
    scene.render.image_settings.color_management = "FOLLOW_SCENE"
    part = path.with_name(f".{path.stem}.part{path.suffix}").absolute()
    try:
        bpy.data.images["Render Result"].save_render(str(part), scene=scene)
        part.replace(path)
    except (RuntimeError, OSError) as error:
        part.unlink(missing_ok=True)
        raise Failure(f"can't write {path}: {str(error).strip()}") from error
