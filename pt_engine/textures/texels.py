"""The texels of an image in memory: one array, one gather for all channels of a texel.

Grey images are arrays of one number a texel. The four bytes of a colour are packed in a uint32, four 16-bit
numbers in a uint64, four floats are a row. So 8-bit images take a quarter of what floats would, and a look-up
touches one cache line a texel.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Float32 = NDArray[np.float32]
Int = NDArray[np.signedinteger[Any]]

BYTE: Final = np.dtype(np.uint8)
SHORT: Final = np.dtype(np.uint16)
HALF: Final = np.dtype(np.float16)
FLOAT: Final = np.dtype(np.float32)
PACKED: Final[dict[int, np.dtype[Any]]] = {
    1: np.dtype(np.uint32),
    2: np.dtype(np.uint64),
}  # four numbers of that many bytes
OPAQUE: Final = {BYTE: 255, SHORT: 65535, HALF: 0x3C00}  # the bits of 1
SCALES: Final = {BYTE: np.float32(1 / 255), SHORT: np.float32(1 / 65535)}
LARGEST: Final = 2**31 - 1  # addresses are int32


class Texels:
    """Texels of one number format.

    Attributes
    ----------
    width, height : int
    dtype : np.dtype
        uint8, uint16, float16 or float32.
    channels : int
        1 is grey, 3 colour without alpha, 4 with it.
    """

    def __init__(self, width: int, height: int, dtype: np.dtype[Any], channels: int) -> None:
        self.width, self.height, self.dtype, self.channels = width, height, dtype, channels

    def row(self, j: Int) -> Int:
        """A row's part of an address; `row(j) + column(i)` is what `at` takes."""
        raise NotImplementedError

    def column(self, i: Int) -> Int:
        """A column's part of an address."""
        raise NotImplementedError

    def gather(self, address: Int) -> Array:
        """Texels as they are stored."""
        raise NotImplementedError

    def at(self, address: Int) -> Float32:
        """(channels, n) float32 texels; times `scale` they are in [0, 1] where they are integers."""
        return unpack(self.gather(address), self.dtype, self.channels)

    @property
    def scale(self) -> np.float32:
        """What a filter's result is still to be multiplied by."""
        return SCALES.get(self.dtype, np.float32(1))

    @property
    def stored(self) -> int:
        """Bytes of all texels."""
        return self.width * self.height * texel_bytes(self.dtype, self.channels)


class Whole(Texels):
    """All texels in memory, row by row, bottom row first.

    Parameters
    ----------
    channels : int
        1 or 4 of the bands; opaque colour then loses its alpha, and grey is kept as one channel.
    bands : iterable of (int, (h, width, channels) array)
        Rows from number `low` on, in any order; together all rows.
    """

    def __init__(
        self, width: int, height: int, dtype: np.dtype[Any], channels: int, bands: Iterable[tuple[int, Array]]
    ) -> None:
        shape = (width * height, 4) if dtype == FLOAT and channels == 4 else (width * height,)
        self.data = np.empty(shape, stored_type(dtype, channels))
        needed = 1
        for low, rows in bands:
            packed = pack(rows, channels)
            self.data[low * width : low * width + len(packed)] = packed
            if channels == 4 and needed < 4:
                needed = max(needed, needed_channels(packed, dtype))
        if channels == 4 and needed == 1:
            self.data = np.ascontiguousarray(self.data.view(dtype).reshape(-1, 4)[:, 0])
        super().__init__(width, height, dtype, needed if channels == 4 else 1)

    @classmethod
    def of(cls, texels: Array) -> Whole:
        """From (H, W, 1) or (H, W, 4) texels."""
        height, width, channels = texels.shape
        return cls(width, height, texels.dtype, channels, [(0, texels)])

    def row(self, j: Int) -> Int:
        return j * np.int32(self.width)

    def column(self, i: Int) -> Int:
        return i

    def gather(self, address: Int) -> Array:
        got: Array = self.data.take(address, axis=0, mode="clip")
        return got


def needed_channels(packed: Array, dtype: np.dtype[Any]) -> int:
    """1 where all texels are opaque greys, 3 where all are opaque, else 4."""
    if dtype == FLOAT:
        opaque = bool((packed[:, 3] == 1).all())
        grey = opaque and all(np.array_equal(packed[:, 0], packed[:, k]) for k in (1, 2))
    else:
        bits = 8 * dtype.itemsize
        one, color = packed.dtype.type(OPAQUE[dtype]), packed.dtype.type((1 << 3 * bits) - 1)
        opaque = bool((packed >> packed.dtype.type(3 * bits) == one).all())
        times = packed.dtype.type(1 + (1 << bits) + (1 << 2 * bits))  # copies the first channel to the others
        first = packed.dtype.type((1 << bits) - 1)
        grey = opaque and bool(((packed & first) * times == packed & color).all())
    return 1 if grey else 3 if opaque else 4


def texel_bytes(dtype: np.dtype[Any], channels: int) -> int:
    """Bytes of a texel in memory."""
    return dtype.itemsize * (1 if channels == 1 else 4)


def pack(texels: Array, channels: int) -> Array:
    """(H, W, C) texels as they are stored: (H·W,), or (H·W, 4) of floats."""
    if channels == 1:
        return np.ascontiguousarray(texels[..., 0]).reshape(-1)
    rows = np.ascontiguousarray(texels).reshape(-1, 4)
    return rows if texels.dtype == FLOAT else rows.view(PACKED[texels.dtype.itemsize])[:, 0]


def stored_type(dtype: np.dtype[Any], channels: int) -> np.dtype[Any]:
    """The number type that texels of a format are packed in."""
    packed: np.dtype[Any] = dtype if channels == 1 or dtype == FLOAT else PACKED[dtype.itemsize]
    return packed


def unpack(got: Array, dtype: np.dtype[Any], channels: int) -> Float32:
    """(channels, n) float32 of stored texels, integers as they are."""
    out = np.empty((channels, len(got)), np.float32)
    if dtype == HALF:
        bits = got.view(np.uint16).reshape(len(got), -1)
        for k, channel in enumerate(out):
            half_table().take(bits[:, k], out=channel, mode="clip")
    elif channels == 1:
        out[0] = got
    elif dtype == BYTE:
        _split_bytes(got, out)
    else:
        numbers = got.view(dtype).reshape(len(got), 4)
        for k, channel in enumerate(out):
            channel[:] = numbers[:, k]
    return out


def _split_bytes(got: Array, out: Float32) -> None:
    """The bytes of packed texels, the lowest first."""
    bits, part = got.view(np.int32), np.empty(len(got), np.int32)  # signed: converts faster
    for k, channel in enumerate(out):
        np.right_shift(bits, 8 * k, out=part)
        np.bitwise_and(part, 255, out=part)
        np.copyto(channel, part, casting="unsafe")


@functools.cache
def half_table() -> Float32:
    """All half floats: looking them up takes half the time of numpy's conversion."""
    return np.arange(1 << 16, dtype=np.uint16).view(np.float16).astype(np.float32)
