"""What an image node samples: one image with its filter, or the numbered tiles of a UDIM.

Both give scene-linear colour and alpha at uv. As in Cycles, texels are alpha-associated, and sRGB ones
still encoded, while they are filtered; both are undone after.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from . import colorspace
from .lookup import Grid

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]

MISSING: Final = (1.0, 0.0, 1.0)  # Blender's magenta; its alpha is 1
FIRST_TILE: Final = 1001
TILES_ACROSS: Final = 10


class Texture:
    """An image, ready to be looked up.

    Attributes
    ----------
    notes : tuple of str
        What of it is not as the file asks for.
    """

    notes: tuple[str, ...] = ()

    def sample(self, u: Float32, v: Float32) -> tuple[Float32, Float32]:
        """Scene-linear colour (3, n) and alpha (n,) at uv."""
        raise NotImplementedError


class Picture(Texture):
    """One image with its filter.

    Parameters
    ----------
    grid : Grid
    interpolation : str
        Linear, Closest, Cubic or Smart (which is cubic here, as in Cycles).
    encoded : bool
        The texels are sRGB-encoded.
    unassociate : bool
        Divide colour by alpha after filtering (a node does so where its alpha is used too).
    without_alpha : bool
        The file has one channel: its alpha is 1 even outside of a clipped image, as in Cycles.
    """

    def __init__(
        self,
        grid: Grid,
        interpolation: str,
        encoded: bool,
        unassociate: bool,
        without_alpha: bool,
        notes: tuple[str, ...] = (),
    ) -> None:
        filters = {"Closest": grid.closest, "Cubic": grid.cubic, "Smart": grid.cubic}
        self._look_up = filters.get(interpolation, grid.linear)
        self.grid, self.encoded, self.unassociate = grid, encoded, unassociate
        self.without_alpha, self.notes = without_alpha, notes

    @stage("", "image textures")
    def sample(self, u: Float32, v: Float32) -> tuple[Float32, Float32]:
        values, inside = self._look_up(u, v)
        color, alpha = values[:3], None
        if len(values) == 4:
            alpha = values[3]
        elif inside is not None and not self.without_alpha:
            alpha = inside
        if self.unassociate and alpha is not None:
            color = color / (alpha + (alpha == 0))
        if self.encoded:
            color = colorspace.srgb_to_linear(color)
        if len(color) == 1:
            color = np.concatenate([color, color, color])
        return color, np.ones(len(u), np.float32) if alpha is None else alpha


class Udim(Texture):
    """Tiles of an image: the one of number 1001 + 10·row + column covers the unit square at (column, row).

    Parameters
    ----------
    tiles : mapping of int to Texture or None
        By tile number; None for one that is missing or cannot be read. Those, and places without a tile, are
        magenta.
    """

    def __init__(self, tiles: Mapping[int, Texture | None], notes: tuple[str, ...] = ()) -> None:
        self.tiles = [texture for texture in tiles.values() if texture is not None]
        self.notes = notes + tuple(dict.fromkeys(note for tile in self.tiles for note in tile.notes))
        rows = 1 + max((number - FIRST_TILE) // TILES_ACROSS for number in (FIRST_TILE, *tiles))
        self._of_place = np.full(TILES_ACROSS * rows + 1, len(self.tiles), np.uint16)  # the last: no place
        known = (number for number, texture in tiles.items() if texture is not None)
        for k, number in enumerate(known):
            self._of_place[number - FIRST_TILE] = k

    def sample(self, u: Float32, v: Float32) -> tuple[Float32, Float32]:
        x, y = toward_zero(u), toward_zero(v)
        place = x + TILES_ACROSS * y
        nowhere = len(self._of_place) - 1
        outside = (x < 0) | (y < 0) | (x >= TILES_ACROSS) | (place > nowhere)
        place += outside * (nowhere - place)
        tile = self._of_place.take(place, mode="clip")
        u, v = u - x.astype(np.float32), v - y.astype(np.float32)
        if len(tile) and (tile == tile[0]).all():
            return self._one(int(tile[0]), u, v)
        order = np.argsort(tile, kind="stable")
        counts = np.bincount(tile, minlength=len(self.tiles) + 1)
        color, alpha = np.empty((3, len(u)), np.float32), np.empty(len(u), np.float32)
        low = 0
        for k in np.flatnonzero(counts):
            lanes = order[low : low + counts[k]]
            low += counts[k]
            color[:, lanes], alpha[lanes] = self._one(int(k), u.take(lanes), v.take(lanes))
        return color, alpha

    def _one(self, tile: int, u: Float32, v: Float32) -> tuple[Float32, Float32]:
        if tile < len(self.tiles):
            return self.tiles[tile].sample(u, v)
        color = np.empty((3, len(u)), np.float32)
        color[:] = np.array(MISSING, np.float32)[:, None]
        return color, np.ones(len(u), np.float32)


def toward_zero(x: Float32) -> Int32:
    """Whole part of a coordinate; those far away, and NaN, are in no tile."""
    return np.fmin(np.fmax(x, np.float32(-2)), np.float32(1e6)).astype(np.int32)
