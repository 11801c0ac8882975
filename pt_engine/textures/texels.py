"""The texels of an image in memory: one array, one gather for all channels of a texel.

Grey images are arrays of one number a texel. The four bytes of a colour are packed in a uint32, four 16-bit
numbers in a uint64, four floats are a row. So 8-bit images take a quarter of what floats would, and a look-up
touches one cache line a texel.
"""

from __future__ import annotations

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
PACKED: Final = {1: np.dtype(np.uint32), 2: np.dtype(np.uint64)}  # four numbers of that many bytes
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
        """(channels, n) float32 texels; integers come out in [0, 1]."""
        return unpack(self.gather(address), self.dtype, self.channels)

    @property
    def stored(self) -> int:
        """Bytes of all texels."""
        return self.width * self.height * texel_bytes(self.dtype, self.channels)


class Whole(Texels):
    """All texels in memory, row by row, bottom row first."""

    def __init__(self, data: Array, width: int, height: int, dtype: np.dtype[Any], channels: int) -> None:
        super().__init__(width, height, dtype, channels)
        self.data = data

    @classmethod
    def of(cls, texels: Array) -> Whole:
        """From (H, W, 1) or (H, W, 4) texels; opaque colour loses its alpha, and equal channels two."""
        height, width, channels = texels.shape
        if channels == 4:
            channels = needed_channels(texels)
        return cls(pack(texels, channels), width, height, texels.dtype, channels)

    def row(self, j: Int) -> Int:
        return j * np.int32(self.width)

    def column(self, i: Int) -> Int:
        return i

    def gather(self, address: Int) -> Array:
        got: Array = self.data.take(address, axis=0, mode="clip")
        return got


def needed_channels(rgba: Array) -> int:
    """1 where all texels are opaque greys, 3 where all are opaque, else 4."""
    opaque = {BYTE: 255, SHORT: 65535}.get(rgba.dtype, 1)
    if not (rgba[..., 3] == opaque).all():
        return 4
    red = rgba[..., 0]
    return 1 if all(np.array_equal(red, rgba[..., k]) for k in (1, 2)) else 3


def texel_bytes(dtype: np.dtype[Any], channels: int) -> int:
    """Bytes of a texel in memory."""
    return dtype.itemsize * (1 if channels == 1 else 4)


def pack(texels: Array, channels: int) -> Array:
    """(H, W, C) texels as they are stored: (H·W,), or (H·W, 4) of floats."""
    if channels == 1:
        return np.ascontiguousarray(texels[..., 0]).reshape(-1)
    rows = np.ascontiguousarray(texels).reshape(-1, 4)
    return rows if texels.dtype == FLOAT else rows.view(PACKED[texels.dtype.itemsize])[:, 0]


def unpack(got: Array, dtype: np.dtype[Any], channels: int) -> Float32:
    """(channels, n) float32 of stored texels."""
    out = np.empty((channels, len(got)), np.float32)
    if channels == 1:
        out[0] = got
    elif dtype == FLOAT:
        for k in range(channels):
            out[k] = got[:, k]
    else:
        _split(got, dtype, out)
    if dtype == BYTE:
        out *= np.float32(1 / 255)
    elif dtype == SHORT:
        out *= np.float32(1 / 65535)
    return out


def _split(got: Array, dtype: np.dtype[Any], out: Float32) -> None:
    """The channels of packed texels, lowest bits first (on all machines numpy is built for)."""
    if dtype == BYTE:
        bits, part = got.view(np.int32), np.empty(len(got), np.int32)  # signed: converts faster
        for k, channel in enumerate(out):
            np.right_shift(bits, 8 * k, out=part)
            np.bitwise_and(part, 255, out=part)
            np.copyto(channel, part, casting="unsafe")
        return
    for k, channel in enumerate(out):
        channel[:] = (got >> np.uint64(16 * k)).astype(np.uint16).view(dtype)
