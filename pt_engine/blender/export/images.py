"""Image textures: encoded files as they are, painted and generated ones as pixels.

A missing image has neither, and says so in `problem`: the engine shows it pink, (1, 0, 1), as Cycles does.
"""

from __future__ import annotations

import os
from pathlib import Path

import bpy
import numpy as np

from ...scene.snapshot import ImageData

FLOAT_BUFFER = {"colorspace": "Linear Rec.709", "alpha_mode": "PREMUL"}  # Blender's float buffers


class ImageTable:
    """Collects `ImageData` in the order they are first asked for.

    Attributes
    ----------
    images : list of ImageData
    unsupported : list
        What could only be exported in part, as (where, what, effect).
    """

    def __init__(self, unsupported) -> None:
        self.images: list[ImageData] = []
        self.unsupported = unsupported
        self._index: dict[tuple[int, str], int] = {}

    def index(self, image, user=None) -> int:
        """Number of the image, of the file that `user` (a node's image user) picks from a sequence."""
        path = file_path(image, user)
        key = (image.original.as_pointer(), path)
        if key not in self._index:
            self._index[key] = len(self.images)
            self.images.append(self._export(image, path))
        return self._index[key]

    def _export(self, image, path: str) -> ImageData:
        reason = {"TILED": "UDIM tiles", "MOVIE": "a movie"}.get(image.source)
        if reason:
            self.unsupported.append((f"Image {image.name}", reason, "one tile or frame is used everywhere"))
        data = export_image(image, path)
        if data.problem:
            self.unsupported.append((f"Image {image.name}", data.problem, "rendered pink"))
        return data


def export_image(image, path: str) -> ImageData:
    """One image as bytes of its file, or as pixels, or with the reason why neither."""
    common = {
        "name": image.name,
        "colorspace": image.colorspace_settings.name,
        "alpha_mode": image.alpha_mode,
    }
    original = image.original
    if original.source in ("GENERATED", "VIEWER", "MOVIE") or original.is_dirty:
        return from_pixels(original, common)
    packed = original.packed_files
    if len(packed):
        data = np.frombuffer(packed[0].packed_file.data, np.uint8)
        return ImageData(encoded=data, suffix=Path(path).suffix.lower(), **common)
    if not path:
        return ImageData(problem="no file is set", **common)
    try:
        data = np.fromfile(path, np.uint8)
    except OSError as error:
        return ImageData(problem=f"{path}: {error.strerror or error}", **common)
    if not data.size:
        return ImageData(problem=f"{path}: empty file", **common)
    return ImageData(encoded=data, suffix=Path(path).suffix.lower(), **common)


def from_pixels(image, common) -> ImageData:
    """Blender's own buffer: RGBA, bottom row first."""
    width, height = image.size
    channels = image.channels
    if not width or not height or len(image.pixels) != width * height * channels:
        return ImageData(problem="it has no pixels", **common)
    flat = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(flat)
    buffer = flat.reshape(height, width, channels)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = buffer[..., :3] if channels > 2 else buffer[..., :1]
    if channels == 4:
        pixels[..., 3] = buffer[..., 3]
    if image.is_float:
        common = common | FLOAT_BUFFER
    return ImageData(pixels=pixels, **common)


def file_path(image, user=None) -> str:
    """Absolute path of the image's file; of a sequence the frame, of UDIM tiles the first."""
    if not image.filepath:
        return ""
    path = image.filepath
    if user is not None and image.source in ("SEQUENCE", "TILED"):
        path = image.filepath_from_user(image_user=user)
    if image.source == "TILED" and len(image.tiles):
        path = path.replace("<UDIM>", str(image.tiles[0].number))
    return bpy.path.abspath(path, library=image.library)


def ocio_config() -> str:
    """The OpenColorIO config that this Blender works with."""
    if os.environ.get("OCIO"):
        return os.environ["OCIO"]
    for kind in ("LOCAL", "SYSTEM"):
        path = Path(bpy.utils.resource_path(kind), "datafiles", "colormanagement", "config.ocio")
        if path.is_file():
            return str(path)
    folder = bpy.utils.system_resource("DATAFILES", path="colormanagement")
    path = Path(folder, "config.ocio")
    return str(path) if folder and path.is_file() else ""
