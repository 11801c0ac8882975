"""Image textures: encoded files as they are, painted and generated ones as pixels.

As in Cycles, files are read as they lie on disk, and what is packed or generated is what Blender has in
memory. A missing image says so in `problem`: the engine shows it magenta, (1, 0, 1), as Cycles does.
"""

from __future__ import annotations

import os
from pathlib import Path

import bpy
import numpy as np

from ...scene.snapshot import ImageData
from ...textures.colorspace import srgb_to_linear
from .image_files import file_path, tile_path
from .lost import NOT_THERE, in_place_of

BYTE_FILES = {".jpg", ".jpeg", ".jpe", ".webp", ".tga", ".bmp", ".png"}  # PNG may be 16-bit
LINEAR_FILES = {".exr", ".hdr"}


class ImageTable:
    """Collects `ImageData` in the order they are first asked for.

    Attributes
    ----------
    images : list of ImageData
    unsupported : list
        What could only be exported in part, as (where, what, effect).
    frame : int
        Of the scene: image sequences show their file of that frame.
    """

    def __init__(self, unsupported, frame: int = 1) -> None:
        self.images: list[ImageData] = []
        self.unsupported = unsupported
        self.frame = frame
        self._index: dict[tuple[int, str], int] = {}

    def index(self, image, user=None) -> int:
        """Number of the image, of the file that `user` (a node's image user) picks from a sequence."""
        path = file_path(image, user, self.frame)
        key = (image.original.as_pointer(), path)
        if key not in self._index:
            data = self._tiled(image) if image.source == "TILED" else self._single(image, path)
            self._index[key] = len(self.images)
            self.images.append(data)
        return self._index[key]

    def _single(self, image, path: str) -> ImageData:
        where = f"Image {image.name}"
        if image.source == "MOVIE":
            self.unsupported.append((where, "a movie", "one frame is used everywhere"))
        if getattr(image.original, "is_missing", False):
            effect = f"Blender's placeholder, a grid{in_place_of(image)}"
            self.unsupported.append((where, NOT_THERE, effect))
        return export_image(image, path)  # what is wrong with it the nodes that show it will say

    def _tiled(self, image) -> ImageData:
        """A UDIM; its tiles become images of their own, before it."""
        tiles = []
        for tile in image.original.tiles:
            where = f"Image {image.name}, tile {tile.number}"
            data = export_tile(image, tile)
            tiles.append((tile.number, len(self.images)))
            self.images.append(data)
            if data.problem:
                self.unsupported.append((where, data.problem, "rendered magenta"))
            if tile.is_generated_tile and tile.generated_type != "BLANK":
                self.unsupported.append((where, "a generated pattern", "one colour, the tile's own"))
            elif data.as_rgba and not stays_encoded(image, data.encoded, data.suffix):
                what = "a packed tile of more than 8 bits or with multiplied alpha"
                self.unsupported.append((where, what, "alpha and filter as if it were not packed"))
        return ImageData(tiles=tuple(tiles), **common(image))


def common(image) -> dict[str, str]:
    """What all kinds of images have."""
    space = image.colorspace_settings.name
    return {"name": image.name, "colorspace": space, "alpha_mode": image.alpha_mode}


def float_buffer(image) -> dict[str, str]:
    """The same for Blender's buffers of floats: they are scene-linear, whatever the file was."""
    settings = common(image)
    return settings if settings["colorspace"] == "Non-Color" else settings | {"colorspace": "scene_linear"}


def export_image(image, path: str) -> ImageData:
    """One image as bytes of its file, or as pixels, or with the reason why neither."""
    original = image.original
    if original.source == "VIEWER":
        return ImageData(problem="a viewer's image is in no file", **common(image))
    if original.source in ("GENERATED", "MOVIE") or original.is_dirty:
        return from_pixels(original)
    packed = original.packed_files
    if len(packed):
        data = np.frombuffer(packed[0].packed_file.data, np.uint8)
        suffix = Path(path).suffix.lower()
        if stays_encoded(original, data, suffix):
            return ImageData(encoded=data, suffix=suffix, as_rgba=True, **common(image))
        return from_pixels(original)
    return from_file(image, path)


def export_tile(image, tile) -> ImageData:
    """A tile of a UDIM as an image of its own."""
    if tile.is_generated_tile:
        return blank(image, tile)
    for packed in image.original.packed_files:
        if packed.tile_number == tile.number:
            data = np.frombuffer(packed.packed_file.data, np.uint8)
            suffix = Path(packed.filepath).suffix.lower()
            return ImageData(encoded=data, suffix=suffix, as_rgba=True, **common(image))
    return from_file(image, tile_path(image, tile.number))


def from_file(image, path: str) -> ImageData:
    """A file's bytes."""
    if not path:
        return ImageData(problem="no file is set", **common(image))
    try:
        data = np.fromfile(path, np.uint8)
    except OSError as error:
        return ImageData(problem=f"{path}: {error.strerror or error}", **common(image))
    if not data.size:
        return ImageData(problem=f"{path}: empty file", **common(image))
    return ImageData(encoded=data, suffix=Path(path).suffix.lower(), **common(image))


def stays_encoded(image, data, suffix: str) -> bool:
    """Whether a packed file's texels are those of the buffer that Blender, and so Cycles, makes of it.

    Bytes are, unless Blender has to divide them by their alpha. Floats, and integers of 16 bits, it converts
    to scene-linear floats when it reads them, which changes nothing where they are so already.
    """
    if suffix in BYTE_FILES:
        deep = data[:4].tobytes() == b"\x89PNG" and len(data) > 24 and data[24] == 16
        return not deep and image.alpha_mode != "PREMUL"
    if suffix in LINEAR_FILES:
        return (
            image.colorspace_settings.name in ("Linear Rec.709", "Non-Color") and image.alpha_mode == "PREMUL"
        )
    return False


def from_pixels(image) -> ImageData:
    """Blender's own buffer: RGBA, bottom row first."""
    loaded = image.has_data
    width, height = image.size
    channels = image.channels
    if not width or not height or len(image.pixels) != width * height * channels:
        return ImageData(problem="it has no pixels", **common(image))
    flat = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(flat)
    buffer = flat.reshape(height, width, channels)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = buffer[..., :3] if channels > 2 else buffer[..., :1]
    if channels == 4:
        pixels[..., 3] = buffer[..., 3]
    if image.is_float:
        return ImageData(pixels=pixels, **float_buffer(image))
    if not loaded:
        image.buffers_free()
    return ImageData(pixels=np.rint(pixels * 255).astype(np.uint8), **common(image))


def blank(image, tile) -> ImageData:
    """A generated tile of one colour."""
    shape = (tile.generated_height, tile.generated_width, 4)
    color = np.array(tile.generated_color, np.float32)
    if tile.use_generated_float:
        color[:3] = srgb_to_linear(color[:3])
        return ImageData(pixels=np.full(shape, color, np.float32), **float_buffer(image))
    return ImageData(pixels=np.full(shape, np.rint(color * 255), np.uint8), **common(image))


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
