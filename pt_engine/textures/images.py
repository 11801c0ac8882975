"""Image textures: decoded once, kept as bytes where that is all the file holds.

As in Cycles, colour is multiplied by alpha before it is filtered, and 8-bit sRGB stays encoded until
after filtering. `Texture.sample` undoes both.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.snapshot import ImageData
from . import colorspace, lookup
from .oiio import openimageio

Float32 = NDArray[np.float32]
UInt8 = NDArray[np.uint8]


class ImageError(Exception):
    """An image that cannot be used; the message says why."""


@dataclass(frozen=True, eq=False)
class Pixels:
    """A decoded image: texels for `lookup.Grid`, and whether they are still sRGB-encoded."""

    texels: lookup.Texels
    width: int
    height: int
    encoded: bool


@dataclass(frozen=True, eq=False)
class Texture:
    """An image with its filter.

    Attributes
    ----------
    unassociate : bool
        Divide colour by alpha after filtering (a node does so where its alpha is used too).
    """

    grid: lookup.Grid
    interpolation: str
    encoded: bool
    unassociate: bool

    def sample(self, u: Float32, v: Float32) -> tuple[Float32, Float32]:
        """Scene-linear colour (3, n) and alpha (n,) at uv."""
        if self.interpolation == "Closest":
            rgba = self.grid.closest(u, v)
        elif self.interpolation in ("Cubic", "Smart"):
            rgba = self.grid.cubic(u, v)
        else:
            rgba = self.grid.linear(u, v)
        color, alpha = rgba[:3], rgba[3]
        if self.unassociate:
            divisible = alpha != 0
            color = color / (alpha + ~divisible)
        if self.encoded:
            color = colorspace.srgb_to_linear(color)
        return color, alpha


class TextureStore:
    """The images of a snapshot, decoded when first asked for."""

    def __init__(self, images: Sequence[ImageData], ocio_config: str = "") -> None:
        self.images = images
        self._converter = colorspace.Converter(ocio_config)
        self._pixels: dict[int, Pixels | ImageError] = {}
        self._textures: dict[tuple[int, str, str, bool], Texture] = {}

    def texture(self, index: int, interpolation: str, extension: str, alpha_used: bool) -> Texture:
        """Image number `index` with a filter.

        Raises
        ------
        ImageError
            Where there is no such image, or it cannot be decoded.
        """
        if not 0 <= index < len(self.images):
            raise ImageError("no image")
        image = self.images[index]
        associated = not colorspace.is_data(image.colorspace)
        unassociate = alpha_used and associated and image.alpha_mode not in ("CHANNEL_PACKED", "NONE")
        extension = extension if extension in lookup.WRAPS else lookup.REPEAT
        key = (index, interpolation, extension, unassociate)
        if key not in self._textures:
            pixels = self._decoded(index)
            grid = lookup.Grid(pixels.texels, pixels.width, pixels.height, extension)
            self._textures[key] = Texture(grid, interpolation, pixels.encoded, unassociate)
        return self._textures[key]

    @property
    def tallest(self) -> int:
        """Height of the tallest image that was asked for, 0 if none was."""
        return max((p.height for p in self._pixels.values() if isinstance(p, Pixels)), default=0)

    def _decoded(self, index: int) -> Pixels:
        if index not in self._pixels:
            try:
                self._pixels[index] = decode(self.images[index], self._converter)
            except ImageError as problem:
                self._pixels[index] = problem
        known = self._pixels[index]
        if isinstance(known, ImageError):
            raise known
        return known


def decode(image: ImageData, converter: colorspace.Converter) -> Pixels:
    """Texels of an image, alpha-associated and, unless 8-bit sRGB, scene-linear."""
    raw = read(image)
    height, width = raw.shape[:2]
    if width == 0 or height == 0:
        raise ImageError(f"{image.name}: empty")
    raw = associate(raw, image)
    if raw.dtype == np.uint8 and (image.colorspace in colorspace.SRGB or _same_numbers(image.colorspace)):
        packed = lookup.pack(raw.reshape(-1, 4))
        return Pixels(packed, width, height, image.colorspace in colorspace.SRGB)
    rgba = raw.astype(np.float32) / np.float32(255) if raw.dtype == np.uint8 else raw
    try:
        rgba = converter.to_linear(rgba, image.colorspace)
    except ValueError as problem:
        raise ImageError(f"{image.name}: {problem}") from problem
    bad = ~np.isfinite(rgba).all(axis=-1)
    if bad.any():
        rgba = rgba.copy()
        rgba[bad] = 0
    return Pixels(np.ascontiguousarray(rgba.reshape(-1, 4), np.float32), width, height, False)


def _same_numbers(name: str) -> bool:
    return not name or colorspace.is_data(name) or name in colorspace.LINEAR


def associate(rgba: NDArray[Any], image: ImageData) -> NDArray[Any]:
    """Multiply colour by alpha where the image's alpha mode says that it is not yet."""
    if image.alpha_mode == "NONE":
        out = rgba.copy()
        out[..., 3] = 255 if rgba.dtype == np.uint8 else 1
        return out
    if image.alpha_mode != "STRAIGHT" or colorspace.is_data(image.colorspace):
        return rgba
    alpha = rgba[..., 3:]
    if (alpha == (255 if rgba.dtype == np.uint8 else 1)).all():
        return rgba
    out = rgba.copy()
    if rgba.dtype == np.uint8:
        out[..., :3] = (rgba[..., :3].astype(np.uint16) * alpha) // 255
    else:
        out[..., :3] = rgba[..., :3] * alpha
    return out


def read(image: ImageData) -> NDArray[Any]:
    """(H, W, 4) uint8 or float32, bottom row first, as the file has it."""
    if image.pixels is not None:
        return _as_bytes(image.pixels) if image.colorspace in colorspace.SRGB else image.pixels
    if image.encoded is None:
        raise ImageError(f"{image.name}: {image.problem or 'the file is missing'}")
    path = _temporary_file(image.encoded, image.suffix)
    try:
        return _read_file(path, image.name)
    finally:
        os.unlink(path)


def _as_bytes(pixels: Float32) -> NDArray[Any]:
    """Pixels back as the bytes they were made of, where they were (painted and generated images)."""
    scaled = np.nan_to_num(pixels) * np.float32(255)
    rounded = np.round(scaled)
    whole = (np.abs(scaled - rounded) < 0.01).all() and rounded.min() >= 0 and rounded.max() <= 255
    return rounded.astype(np.uint8) if whole else pixels


def _temporary_file(data: UInt8, suffix: str) -> str:
    suffix = "".join(c for c in suffix if c.isalnum())
    handle, path = tempfile.mkstemp(suffix=f".{suffix}" if suffix else "")
    with os.fdopen(handle, "wb") as file:
        file.write(data.tobytes())
    return path


def _read_file(path: str, name: str) -> NDArray[Any]:
    try:
        oiio = openimageio()
    except RuntimeError as problem:
        raise ImageError(f"{name}: {problem}") from problem
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    file = oiio.ImageInput.open(path, config)
    if file is None:
        raise ImageError(f"{name}: {oiio.geterror().strip() or 'cannot be read'}".replace(path, name))
    try:
        spec = file.spec()
        kind = oiio.UINT8 if str(spec.format) == "uint8" else oiio.FLOAT
        channels = min(spec.nchannels, 4)
        data = file.read_image(0, 0, 0, channels, kind)
        reason = file.geterror().strip()
    finally:
        file.close()
    if data is None:
        raise ImageError(f"{name}: {reason or 'cannot be read'}".replace(path, name))
    dtype = np.uint8 if kind == oiio.UINT8 else np.float32
    return to_rgba(np.asarray(data, dtype).reshape(spec.height, spec.width, channels)[::-1])


def to_rgba(data: NDArray[Any]) -> NDArray[Any]:
    """(H, W, C) with 1 (grey), 2 (grey, alpha), 3 or 4 channels as RGBA."""
    height, width, channels = data.shape
    if channels == 4:
        return np.ascontiguousarray(data)
    out = np.empty((height, width, 4), data.dtype)
    out[..., :3] = data[..., :1] if channels < 3 else data
    opaque = 255 if data.dtype == np.uint8 else 1
    out[..., 3] = data[..., 1] if channels == 2 else opaque
    return out
