"""The images of a snapshot: decoded once, kept in the file's number format, shared by all nodes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.snapshot import ImageData
from . import colorspace, lookup
from .conform import conform
from .memory import pools
from .reading import Header, ImageError, OpenFile, OpenPixels
from .texels import LARGEST, Texels, Whole, texel_bytes
from .texture import FIRST_TILE, Picture, Texture, Udim
from .tiles import BAND, Tiled

__all__ = ["ImageError", "Texture", "TextureStore"]

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Pixels:
    """A decoded image.

    Attributes
    ----------
    encoded : bool
        The texels are sRGB-encoded.
    without_alpha : bool
        The file has one channel.
    notes : tuple of str
        What could not be done as the file asks for.
    """

    texels: Texels
    encoded: bool
    without_alpha: bool
    notes: tuple[str, ...] = ()


class TextureStore:
    """The images of a snapshot, decoded when first asked for.

    Parameters
    ----------
    images : sequence of ImageData
    ocio_config : str
        Path of an OpenColorIO config; "" for OpenImageIO's own.
    limit : int
        Bytes that all texels together may take in memory; 0 for no limit.
    """

    def __init__(self, images: Sequence[ImageData], ocio_config: str = "", limit: int = 0) -> None:
        self.images, self.limit = images, limit
        self._converter = colorspace.Converter(ocio_config)
        self._pixels: dict[int, Pixels | ImageError] = {}
        self._textures: dict[tuple[int, str, str, bool], Texture] = {}
        self._pools: dict[int, int] | None = None

    def texture(
        self, index: int, interpolation: str, extension: str, alpha_used: bool, first_tile: bool = False
    ) -> Texture:
        """Image number `index` with a filter; of a UDIM all its tiles, or with `first_tile` only 1001.

        Raises
        ------
        ImageError
            Where there is no such image, or it cannot be decoded.
        """
        if not 0 <= index < len(self.images):
            raise ImageError("no image")
        image = self.images[index]
        if image.tiles:
            tiles = [(k, i) for k, i in image.tiles if k == FIRST_TILE or not first_tile]
            return self._udim(tiles, interpolation, extension, alpha_used)
        associated = not colorspace.is_data(image.colorspace)
        unassociate = alpha_used and associated and image.alpha_mode not in ("CHANNEL_PACKED", "NONE")
        extension = extension if extension in lookup.WRAPS else lookup.REPEAT
        key = (index, interpolation, extension, unassociate)
        if key not in self._textures:
            p = self._decoded(index)
            grid = lookup.Grid(p.texels, extension)
            picture = Picture(grid, interpolation, p.encoded, unassociate, p.without_alpha, p.notes)
            self._textures[key] = picture
        return self._textures[key]

    def _udim(self, numbered: Sequence[tuple[int, int]], *settings: Any) -> Udim:
        tiles: dict[int, Texture | None] = {}
        notes = []
        for number, index in numbered:
            try:
                tiles[number] = self.texture(index, *settings)
            except ImageError as problem:
                tiles[number] = None
                notes.append(f"{problem}: tile {number} is magenta")
        return Udim(tiles, tuple(notes))

    def tallest(self, indices: Iterable[object]) -> int:
        """Rows of the tallest of some images, as far as they were asked for; 0 for none."""
        known = (self._pixels.get(index) for index in indices if isinstance(index, int))
        return max((p.texels.height for p in known if isinstance(p, Pixels)), default=0)

    def _decoded(self, index: int) -> Pixels:
        if index not in self._pixels:
            try:
                self._pixels[index] = decode(self.images[index], self._converter, self._pool(index))
            except ImageError as problem:
                self._pixels[index] = problem
        known = self._pixels[index]
        if isinstance(known, ImageError):
            raise known
        return known

    def _pool(self, index: int) -> int | None:
        """Bytes of an image's pool of tiles; None where it is held whole."""
        if not self.limit:
            return None
        if self._pools is None:
            sizes = {k: size_of(image, self._converter) for k, image in enumerate(self.images)}
            self._pools = pools(sizes, self.limit)
        return self._pools.get(index)

    def release(self) -> None:
        """Let go of the encoded files: what is decoded is all that is needed now."""
        self.images = ()

    def statistics(self) -> dict[str, int]:
        """What the textures take, for stats.json."""
        texels = [p.texels for p in self._pixels.values() if isinstance(p, Pixels)]
        tiled = [t for t in texels if isinstance(t, Tiled)]
        whole = sum(t.stored for t in texels if not isinstance(t, Tiled))
        return {
            "count": len(texels),
            "missing": len(self._pixels) - len(texels),
            "bytes": whole + sum(t.resident for t in tiled),
            "limit_bytes": self.limit,
            "full_bytes": sum(t.stored for t in texels),
            "tiled": len(tiled),
            "tile_reads": sum(t.reads for t in tiled),
            "tile_evictions": sum(t.evictions for t in tiled),
        }


def size_of(image: ImageData, converter: colorspace.Converter) -> int:
    """Bytes of an image's texels, as far as its header tells; 0 where it cannot be read."""
    try:
        with closing(opened(image)) as file:
            head = file.header
    except ImageError:
        return 0
    form = kept_format(head, space(image, converter)[0])
    return head.width * head.height * texel_bytes(form, kept_channels(head, image))


def opened(image: ImageData) -> OpenFile | OpenPixels:
    """An image's header and rows.

    Raises
    ------
    ImageError
    """
    if image.pixels is not None:
        return OpenPixels(image.pixels, image.name)
    if image.encoded is None:
        raise ImageError(f"{image.name}: {image.problem or 'the file is missing'}")
    return OpenFile(image.encoded, image.suffix, image.name)


def kept_format(head: Header, kind: str) -> np.dtype[Any]:
    """The number format of the texels: integers of a converted space become half floats."""
    converted = kind == colorspace.NAMED and head.dtype.kind == "u"
    return np.dtype(np.float16) if converted else head.dtype


def kept_channels(head: Header, image: ImageData) -> int:
    """Channels of the texels: 1 or 4."""
    return 4 if image.as_rgba or head.channels > 1 else 1


def space(image: ImageData, converter: colorspace.Converter) -> tuple[str, tuple[str, ...]]:
    """Kind of an image's colour space, and a note where it is not known: Cycles takes it as linear."""
    try:
        return converter.kind(image.colorspace), ()
    except colorspace.UnknownSpace as problem:
        return colorspace.LINEAR, (f"{problem}: taken as scene-linear",)


def decode(image: ImageData, converter: colorspace.Converter, pool: int | None = None) -> Pixels:
    """Texels of an image, held whole or, with the bytes of a `pool`, as tiles.

    Raises
    ------
    ImageError
    """
    kind, notes = space(image, converter)

    def rows(file: OpenFile | OpenPixels, count: int) -> Iterator[tuple[int, Array]]:
        for low, raw in file.bands(count):
            yield low, conform(raw, image.alpha_mode, kind, image.colorspace, converter, image.as_rgba)

    with closing(opened(image)) as file:
        if file.has_mip_maps:
            notes += (f"{image.name}: looked up in full size, not in its mip maps",)
        head = file.header
        form = kept_format(head, kind)
        channels = kept_channels(head, image)
        bands = rows(file, BAND if kind != colorspace.NAMED else 8 * BAND)  # each may read the config anew
        texels: Texels
        if pool is None and head.width * head.height <= LARGEST:
            texels = Whole(head.width, head.height, form, channels, bands)
        else:
            room = head.width * head.height * texel_bytes(form, channels) if pool is None else pool
            texels = Tiled(head.width, head.height, form, channels, bands, room)
    return Pixels(texels, kind == colorspace.SRGB, head.channels == 1 and not image.as_rgba, notes)
