"""Looking up an image at uv coordinates: closest, linear and cubic, and what lies past its edges.

Texels are rows of RGBA, bottom row first, centre of texel (i, j) at ((i + ½)/width, (j + ½)/height). They
are float32, or bytes that stay bytes (packed as one uint32, a quarter of the memory, one gather for all
four channels). The filters are Cycles': linear between texel centres, and the cubic B-spline.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Texels = NDArray[np.float32] | NDArray[np.uint32]
Wrap = Callable[[Int32, int], Int32]

REPEAT: Final = "REPEAT"
EXTEND: Final = "EXTEND"
CLIP: Final = "CLIP"
MIRROR: Final = "MIRROR"


def wrap_repeat(i: Int32, size: int) -> Int32:
    """i mod size; by division, which numpy does in SIMD, and the remainder not."""
    wrapped: Int32 = i - i // np.int32(size) * np.int32(size)
    return wrapped


def wrap_extend(i: Int32, size: int) -> Int32:
    """The nearest valid index."""
    return np.minimum(np.maximum(i, 0), np.int32(size - 1))


def wrap_mirror(i: Int32, size: int) -> Int32:
    """Back and forth: ... 1 0 | 0 1 ... n−1 | n−1 n−2 ..."""
    m = i % np.int32(2 * size)
    out: Int32 = np.minimum(m, np.int32(2 * size - 1) - m)
    return out


WRAPS: Final[dict[str, Wrap]] = {
    REPEAT: wrap_repeat,
    EXTEND: wrap_extend,
    CLIP: wrap_extend,
    MIRROR: wrap_mirror,
}


def pack(rgba: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """(K, 4) bytes as (K,) uint32, red in the lowest byte."""
    wide = rgba.astype(np.uint32)
    packed: NDArray[Any] = wide[:, 0] | wide[:, 1] << 8 | wide[:, 2] << 16 | wide[:, 3] << 24
    return packed


def gather(texels: Texels, index: Int32) -> Float32:
    """(4, n) float32 of the texels at `index`; bytes come out in [0, 1]."""
    got: NDArray[Any] = texels.take(index, axis=0, mode="clip")
    if got.dtype == np.float32:
        return np.ascontiguousarray(got.T, np.float32)
    out = np.empty((4, len(got)), np.float32)
    for channel in range(4):
        out[channel] = (got >> (8 * channel)) & 255
    out *= np.float32(1 / 255)
    return out


class Grid:
    """An image as the filters see it.

    Parameters
    ----------
    texels : (height·width, 4) float32, or (height·width,) uint32 of packed bytes
    width, height : int
    extension : str
        REPEAT, EXTEND, CLIP (transparent black outside) or MIRROR.
    """

    def __init__(self, texels: Texels, width: int, height: int, extension: str) -> None:
        self.texels, self.width, self.height, self.extension = texels, width, height, extension
        self._wrap = WRAPS[extension]

    def texel(self, i: Int32, j: Int32) -> Float32:
        """(4, n) texels at column i, row j, whichever side of the edge they are on."""
        column, row = self._wrap(i, self.width), self._wrap(j, self.height) * np.int32(self.width)
        return self._seen(gather(self.texels, row + column), i, j)

    def _seen(self, got: Float32, i: Int32, j: Int32) -> Float32:
        """Nothing, outside of an image that is clipped."""
        if self.extension == CLIP:
            got *= (i >= 0) & (i < self.width) & (j >= 0) & (j < self.height)
        return got

    def split(self, u: Float32, size: int, offset: float) -> tuple[Int32, Float32]:
        """Texel number below coordinate `u`, and how far above it we are; NaN counts as 0."""
        if self.extension == REPEAT:
            u = u - np.floor(u)
        elif self.extension == MIRROR:
            u = u - 2 * np.floor(u * 0.5)
        x = u * np.float32(size) + np.float32(offset)
        x = np.fmin(np.fmax(x, np.float32(-4)), np.float32(2 * size + 4))
        low = np.floor(x)
        return low.astype(np.int32), x - low

    def closest(self, u: Float32, v: Float32) -> Float32:
        """(4, n) of the texel that contains the point."""
        i, _ = self.split(u, self.width, 0.0)
        j, _ = self.split(v, self.height, 0.0)
        return self.texel(i, j)

    def linear(self, u: Float32, v: Float32) -> Float32:
        """(4, n) bilinear between texel centres."""
        i, s = self.split(u, self.width, -0.5)
        j, t = self.split(v, self.height, -0.5)
        columns = [(k, self._wrap(k, self.width)) for k in (i, i + 1)]
        lines = []
        for k in (j, j + 1):
            row = self._wrap(k, self.height) * np.int32(self.width)
            left, right = (self._seen(gather(self.texels, row + c), x, k) for x, c in columns)
            right -= left
            right *= s
            left += right
            lines.append(left)
        low, high = lines
        high -= low
        high *= t
        low += high
        return low

    def cubic(self, u: Float32, v: Float32) -> Float32:
        """(4, n) bicubic B-spline."""
        i, s = self.split(u, self.width, -0.5)
        j, t = self.split(v, self.height, -0.5)
        out = np.zeros((4, u.shape[-1]), np.float32)
        columns, rows = bspline(s), bspline(t)
        for b, row in enumerate(rows):
            line = np.zeros_like(out)
            for a, column in enumerate(columns):
                line += column * self.texel(i + (a - 1), j + (b - 1))
            out += row * line
        return out


def bspline(t: Float32) -> tuple[Float32, Float32, Float32, Float32]:
    """Weights of the four texels around a point `t` past the second: the uniform cubic B-spline."""
    sixth, third = np.float32(1 / 6), np.float32(2 / 3)
    return (
        ((-sixth * t + 0.5) * t - 0.5) * t + sixth,
        (0.5 * t - 1) * t * t + third,
        ((-0.5 * t + 0.5) * t + 0.5) * t + sixth,
        sixth * t * t * t,
    )
