"""Texels that do not fit in memory: square tiles in a scratch file, the recently used ones in a pool.

A texel's address is made of its tile and its place in the tile, so a batch of look-ups needs a table of
where each tile lies in the pool and one gather. Tiles that are missing are read first; if the pool is full,
those that were looked at longest ago make room. Where a batch touches more tiles than the pool holds, its
lanes are grouped by tile and looked up in parts. The texels are the same as in memory, bit for bit.
"""

from __future__ import annotations

import itertools
import tempfile
import threading
import weakref
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .texels import FLOAT, Array, Int, Texels, needed_channels, pack, stored_type, texel_bytes

BITS: Final = 6
SIDE: Final = 1 << BITS  # texels along a tile
AREA: Final = SIDE * SIDE
BAND: Final = 8 * SIDE  # rows that are decoded at a time
LEAST: Final = 16  # tiles that a pool holds at least


class Tiled(Texels):
    """Texels behind a pool of tiles.

    Parameters
    ----------
    bands : iterable of (int, (h, width, C) array)
        The image's rows from the top down, `BAND` at a time (see `reading.OpenFile.bands`); consumed at once.
    capacity : int
        Bytes that the pool may take.

    Attributes
    ----------
    reads, evictions : int
        Tiles read from the scratch file, and thrown out of the pool, so far.
    """

    def __init__(
        self,
        width: int,
        height: int,
        dtype: np.dtype[Any],
        channels: int,
        bands: Iterable[tuple[int, Array]],
        capacity: int,
    ) -> None:
        super().__init__(width, height, dtype, channels)
        self.across, self.down = -(-width // SIDE), -(-height // SIDE)
        self.tile_bytes = AREA * texel_bytes(dtype, channels)
        pages = self.across * self.down
        self.slots = min(pages, max(LEAST, capacity // self.tile_bytes))
        self.reads = self.evictions = 0
        self._file = tempfile.TemporaryFile()  # noqa: SIM115  lives as long as the texels
        weakref.finalize(self, self._file.close)
        if channels == 4:
            self.channels = 3  # until a texel is not opaque
        for low, rows in bands:
            for k in range(0, len(rows), SIDE):
                self._write(low + k, rows[k : k + SIDE], channels)
        self._slot = np.full(pages, -1, np.int32)  # of each tile; −1 is not in the pool
        self._page = np.full(self.slots, -1, np.int32)  # of each slot
        self._used = np.zeros(pages, np.int64)  # when a tile was looked at last
        self._clock = 0
        shape = (self.slots * AREA, 4) if dtype == FLOAT and channels > 1 else (self.slots * AREA,)
        self._pool = np.empty(shape, stored_type(dtype, channels))
        self._lock = threading.Lock()

    def row(self, j: Int) -> Int:
        wide: Int = j.astype(np.int64)
        return (wide >> BITS) * (self.across * AREA) + ((wide & (SIDE - 1)) << BITS)

    def column(self, i: Int) -> Int:
        return ((i >> BITS) << (2 * BITS)) + (i & (SIDE - 1))

    def gather(self, address: Int) -> Array:
        pages = address >> (2 * BITS)
        with self._lock:
            if self.slots == len(self._slot) or self._wanted(pages) <= self.slots:
                return self._from_pool(address, pages)
            return self._in_parts(address, pages)

    @property
    def resident(self) -> int:
        """Bytes of the pool."""
        return int(self._pool.nbytes)

    def _wanted(self, pages: Int) -> int:
        """How many different tiles a batch touches."""
        seen = np.zeros(len(self._slot), bool)
        seen[pages] = True
        return int(np.count_nonzero(seen))

    def _in_parts(self, address: Int, pages: Int) -> Array:
        order = np.argsort(pages, kind="stable")
        ranked = pages.take(order)
        rank = np.cumsum(np.diff(ranked, prepend=ranked[:1]) != 0)  # of each lane's tile in the batch
        edges = np.searchsorted(rank, np.arange(0, rank[-1] + self.slots + 1, self.slots))
        out = np.empty((len(address), *self._pool.shape[1:]), self._pool.dtype)
        for low, high in itertools.pairwise(edges):
            lanes = order[low:high]
            out[lanes] = self._from_pool(address.take(lanes), pages.take(lanes))
        return out

    def _from_pool(self, address: Int, pages: Int) -> Array:
        """Texels of lanes whose tiles fit in the pool together."""
        self._clock += 1
        self._used[pages] = self._clock
        slots = self._slot.take(pages)
        if (slots < 0).any():
            self._load(np.flatnonzero((self._used == self._clock) & (self._slot < 0)))
            slots = self._slot.take(pages)
        place = (slots.astype(np.int64) << (2 * BITS)) + (address & (AREA - 1))
        got: Array = self._pool.take(place, axis=0, mode="clip")
        return got

    def _load(self, pages: Int) -> None:
        for page, slot in zip(pages, self._free(len(pages)), strict=True):
            self._file.seek(int(page) * self.tile_bytes)
            tile = self._pool[slot * AREA : (slot + 1) * AREA]
            self._file.readinto(memoryview(tile).cast("B"))
            self._slot[page], self._page[slot] = slot, page
        self.reads += len(pages)

    def _free(self, count: int) -> NDArray[np.intp]:
        """Slots to fill: empty ones, then those of the tiles that were looked at longest ago."""
        used = np.where(self._page < 0, -1, self._used.take(self._page, mode="clip"))
        slots = np.argsort(used, kind="stable")[:count]
        old = self._page[slots]
        old = old[old >= 0]
        self._slot[old] = -1
        self.evictions += len(old)
        return slots

    def _write(self, low: int, rows: Array, channels: int) -> None:
        """Write rows `low`, `low` + 1 ... to the file, tile by tile."""
        height, width = rows.shape[:2]
        if self.channels == 3 and needed_channels(pack(rows, 4), rows.dtype) == 4:
            self.channels = 4
        padded = np.zeros((SIDE, self.across * SIDE, channels), rows.dtype)
        padded[:height, :width] = rows
        tiles = padded.reshape(SIDE, self.across, SIDE, channels).swapaxes(0, 1)
        self._file.seek(low // SIDE * self.across * self.tile_bytes)
        self._file.write(pack(tiles.reshape(-1, SIDE, channels), channels).tobytes())
