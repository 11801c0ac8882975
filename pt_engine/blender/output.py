"""Pictures that a render leaves: written whole or not at all."""

from __future__ import annotations

import tempfile
from pathlib import Path

import bpy

from .failure import Failure
from .passes import enabled


def save_exr(path: Path, scene) -> list[Path]:
    """The render result in linear 32-bit floats; the files written, one for each view.

    The engine's own passes, where they are switched on, make layers of it.
    """
    image = scene.render.image_settings
    layers = any(enabled(layer) for layer in scene.view_layers if layer.use)
    if hasattr(image, "media_type"):  # Blender 5
        image.media_type = "MULTI_LAYER_IMAGE" if layers else "IMAGE"
    image.file_format = "OPEN_EXR_MULTILAYER" if layers else "OPEN_EXR"
    image.color_mode, image.color_depth, image.exr_codec = "RGBA", "32", "ZIP"
    return save(path, scene)


def save_png(path: Path, scene, has_holes: bool) -> list[Path]:
    """The render result as Blender shows it: through the file's view transform, exposure and look.

    With an alpha channel where the film is transparent or holdouts have cut holes into it.
    """
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "IMAGE"
    image.file_format = "PNG"
    image.color_mode = "RGBA" if scene.render.film_transparent or has_holes else "RGB"
    image.color_depth, image.compression = "8", 15
    return save(path, scene)


def save(path: Path, scene) -> list[Path]:
    """Save in a folder of its own first, so that a broken write leaves an earlier picture alone.

    Views become files of their own, with Blender's suffixes: `OUT_L.exr`, `OUT_R.exr`.
    """
    image = scene.render.image_settings
    image.color_management, image.views_format = "FOLLOW_SCENE", "INDIVIDUAL"
    views = sum(view.use for view in scene.render.views) if scene.render.use_multiview else 1
    folder = path.absolute().parent
    try:
        with tempfile.TemporaryDirectory(dir=folder, prefix=f".{path.stem}.") as place:
            try:
                bpy.data.images["Render Result"].save_render(str(Path(place) / path.name), scene=scene)
            except RuntimeError:
                if views == 1 or len(list(Path(place).iterdir())) < views:  # of several it always complains
                    raise
            return [part.replace(path.with_name(part.name)) for part in sorted(Path(place).iterdir())]
    except (RuntimeError, OSError) as error:
        raise Failure(f"can't write {path}: {str(error).strip()}") from error
