"""Image files through OpenImageIO, in bands of rows, so that a large image never has to be held whole."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .oiio import openimageio

Array = NDArray[Any]


class ImageError(Exception):
    """An image that cannot be used; the message says why."""


@dataclass(frozen=True)
class Header:
    """Size and number format of an image: uint8, uint16, float16 or float32."""

    width: int
    height: int
    channels: int
    dtype: np.dtype[Any]


class OpenFile:
    """An image file, open for one pass from its top row to its bottom row.

    Raises
    ------
    ImageError
        Where it cannot be read; the message begins with the image's `name`.
    """

    def __init__(self, encoded: NDArray[np.uint8], suffix: str, name: str) -> None:
        self.name = name
        try:
            self._oiio = openimageio()
        except RuntimeError as problem:
            raise ImageError(f"{name}: {problem}") from problem
        self._path = _temporary_file(encoded, suffix)
        try:
            self._file = self._open()
            self._spec = self._file.spec()
            self.header = self._header()
        except ImageError:
            os.unlink(self._path)
            raise

    def close(self) -> None:
        """Give the file back."""
        self._file.close()
        os.unlink(self._path)

    def _open(self) -> Any:
        config = self._oiio.ImageSpec()
        config.attribute("oiio:UnassociatedAlpha", 1)  # alpha as it is in the file
        file = self._oiio.ImageInput.open(self._path, config)
        if file is None:
            raise self._error(self._oiio.geterror())
        return file

    def _error(self, reason: str) -> ImageError:
        told = next(iter(reason.strip().splitlines()), "cannot be read")  # the rest says it again
        return ImageError(f"{self.name}: {told}".replace(self._path, self.name))

    def _header(self) -> Header:
        spec = self._spec
        if spec.width <= 0 or spec.height <= 0 or spec.nchannels <= 0:
            raise self._error("it has no pixels")
        if spec.depth > 1:
            raise self._error("it is a volume, not an image")
        return Header(spec.width, spec.height, spec.nchannels, number_format(spec))

    @property
    def has_mip_maps(self) -> bool:
        """Whether the file holds smaller versions of the image as well."""
        if not self._spec.tile_width or not self._file.seek_subimage(0, 1):
            return False
        self._file.seek_subimage(0, 0)
        return True

    def bands(self, rows: int) -> Iterator[tuple[int, Array]]:
        """(first row counted from the bottom, (h, width, channels) bottom row first), the top band first.

        Every band but the first (the image's top) has `rows` rows.

        Raises
        ------
        ImageError
            Where the file is damaged.
        """
        head = self.header
        if self._spec.tile_width and rows < head.height:
            yield from self._of_tiles(rows)
            return
        for low in range((head.height - 1) // rows * rows, -1, -rows):
            top, bottom = head.height - min(low + rows, head.height), head.height - low
            yield low, self._scanlines(top, bottom)

    def _scanlines(self, top: int, bottom: int) -> Array:
        head, spec = self.header, self._spec
        kind = self._kind()
        if top == 0 and bottom == head.height:
            data = self._file.read_image(0, 0, 0, head.channels, kind)
        else:
            data = self._file.read_scanlines(0, 0, spec.y + top, spec.y + bottom, 0, 0, head.channels, kind)
        return self._flipped(data, bottom - top)

    def _of_tiles(self, rows: int) -> Iterator[tuple[int, Array]]:
        """Bands of a tiled file: rows of tiles are read as they are, and cut anew."""
        head, spec = self.header, self._spec
        kept = np.empty((0, head.width, head.channels), head.dtype)
        low = (head.height - 1) // rows * rows
        for top in range(0, head.height, spec.tile_height):
            bottom = min(top + spec.tile_height, head.height)
            edges = (spec.x, spec.x + head.width, spec.y + top, spec.y + bottom)
            data = self._file.read_tiles(0, 0, *edges, 0, 1, 0, head.channels, self._kind())
            kept = np.concatenate([kept, self._flipped(data, bottom - top)[::-1]])
            while low >= 0 and len(kept) >= (want := min(rows, head.height - low)):
                yield low, kept[:want][::-1]
                kept, low = kept[want:], low - rows

    def _kind(self) -> Any:
        oiio = self._oiio
        kinds = {"uint8": oiio.UINT8, "uint16": oiio.UINT16, "float16": oiio.HALF, "float32": oiio.FLOAT}
        return kinds[self.header.dtype.name]

    def _flipped(self, data: Any, height: int) -> Array:
        if data is None:
            raise self._error(self._file.geterror())
        head = self.header
        return np.asarray(data, head.dtype).reshape(height, head.width, head.channels)[::-1]


class OpenPixels:
    """Decoded pixels, bottom row first, given as `OpenFile` gives a file's."""

    def __init__(self, pixels: Array, name: str) -> None:
        height, width, channels = pixels.shape
        if not width or not height:
            raise ImageError(f"{name}: it has no pixels")
        self._pixels = pixels
        self.header = Header(width, height, channels, pixels.dtype)

    has_mip_maps = False

    def close(self) -> None:
        """Nothing is open."""

    def bands(self, rows: int) -> Iterator[tuple[int, Array]]:
        """See `OpenFile.bands`."""
        for low in range((self.header.height - 1) // rows * rows, -1, -rows):
            yield low, self._pixels[low : low + rows]


def number_format(spec: Any) -> np.dtype[Any]:
    """The format Cycles reads a file in."""
    name = str(spec.format)
    if name == "half":
        return np.dtype(np.float16)
    formats = {name, *(str(f) for f in spec.channelformats)}
    if formats & {"half", "float", "double"}:
        return np.dtype(np.float32)
    return np.dtype(np.uint16) if name == "uint16" else np.dtype(np.uint8)


def _temporary_file(data: NDArray[np.uint8], suffix: str) -> str:
    suffix = "".join(c for c in suffix if c.isalnum())
    handle, path = tempfile.mkstemp(suffix=f".{suffix}" if suffix else "")
    with os.fdopen(handle, "wb") as file:
        file.write(data.tobytes())
    return path
