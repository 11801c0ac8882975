"""Looking up an image at uv coordinates: closest, linear and cubic, and what lies past its edges.

The centre of texel (i, j) is at ((i + ½)/width, (j + ½)/height), bottom row first. The filters are Cycles':
linear between texel centres, and the cubic B-spline. Both are products of a filter of columns and one of
rows: each is a list of (index, weight), and a weight is 0 outside of an image that is clipped.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from .texels import Texels

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Wrap = Callable[[Int32, int], Int32]
Taps = list[tuple[NDArray[Any], Float32]]

REPEAT: Final = "REPEAT"
EXTEND: Final = "EXTEND"
CLIP: Final = "CLIP"
MIRROR: Final = "MIRROR"
FARTHEST: Final = np.float32(2**30)  # texels; past it there is nothing to see but the rounding of uv


def wrap_repeat(i: Int32, size: int) -> Int32:
    """i mod size, by bits or by division: numpy does both in SIMD, and the remainder not."""
    power_of_two = size & (size - 1) == 0
    wrapped: Int32 = i & np.int32(size - 1) if power_of_two else i - i // np.int32(size) * np.int32(size)
    return wrapped


def wrap_extend(i: Int32, size: int) -> Int32:
    """The nearest valid index."""
    return np.minimum(np.maximum(i, 0), np.int32(size - 1))


def wrap_mirror(i: Int32, size: int) -> Int32:
    """Back and forth: ... 1 0 | 0 1 ... n−1 | n−1 n−2 ..."""
    m = wrap_repeat(i, 2 * size)
    mirrored: Int32 = np.minimum(m, np.int32(2 * size - 1) - m)
    return mirrored


WRAPS: Final[dict[str, Wrap]] = {
    REPEAT: wrap_repeat,
    EXTEND: wrap_extend,
    CLIP: wrap_extend,
    MIRROR: wrap_mirror,
}


def near(x: Float32) -> Float32:
    """Coordinates in texels that int32 can hold; NaN counts as the farthest."""
    if np.min(x, initial=0) >= -FARTHEST and np.max(x, initial=0) <= FARTHEST:  # false with NaN
        return x
    return np.fmin(np.fmax(x, -FARTHEST), FARTHEST)


def containing(x: Float32) -> Int32:
    """Number of the texel that holds a point; the left end of a negative one belongs to its neighbour."""
    x = near(x)
    number = x.astype(np.int32)
    number -= x < 0
    return number


def split(x: Float32) -> tuple[Int32, Float32]:
    """Number of the last texel whose centre is not past `x`, and how far past it we are."""
    x = near(x - np.float32(0.5))
    low = np.floor(x)
    x -= low
    return low.astype(np.int32), x


class Grid:
    """An image as the filters see it.

    Parameters
    ----------
    texels : Texels
    extension : str
        REPEAT, EXTEND, CLIP (transparent black outside) or MIRROR.
    """

    def __init__(self, texels: Texels, extension: str) -> None:
        self.texels, self.extension = texels, extension
        self._wrap = WRAPS[extension]

    def closest(self, u: Float32, v: Float32) -> tuple[Float32, Float32 | None]:
        """(channels, n) of the texel that contains the point, and how much of it is inside of the image.

        The second is None where nothing is outside.
        """
        texels = self.texels
        i = containing(u * np.float32(texels.width))
        j = containing(v * np.float32(texels.height))
        row = texels.row(self._wrap(j, texels.height))
        out = texels.at(row + texels.column(self._wrap(i, texels.width)))
        out *= texels.scale
        if self.extension != CLIP:
            return out, None
        inside = (self._inside(i, texels.width) & self._inside(j, texels.height)).astype(np.float32)
        out *= inside
        return out, inside

    def linear(self, u: Float32, v: Float32) -> tuple[Float32, Float32 | None]:
        """Bilinear between texel centres; see `closest`."""
        i, s = split(u * np.float32(self.texels.width))
        j, t = split(v * np.float32(self.texels.height))
        return self._filtered(i, (1 - s, s), j, (1 - t, t))

    def cubic(self, u: Float32, v: Float32) -> tuple[Float32, Float32 | None]:
        """Bicubic B-spline; see `closest`."""
        i, s = split(u * np.float32(self.texels.width))
        j, t = split(v * np.float32(self.texels.height))
        return self._filtered(i - 1, bspline(s), j - 1, bspline(t))

    def _filtered(
        self, i: Int32, across: tuple[Float32, ...], j: Int32, up: tuple[Float32, ...]
    ) -> tuple[Float32, Float32 | None]:
        """Sum over columns i, i + 1 ... and rows j, j + 1 ... with their weights."""
        texels = self.texels
        columns, within = self._taps(i, across, texels.width, texels.column)
        rows, within_rows = self._taps(j, up, texels.height, texels.row)
        out = np.zeros((texels.channels, len(i)), np.float32)
        for row, v in rows:
            for column, u in columns:
                part = texels.at(row + column)
                part *= v * u
                out += part
        out *= texels.scale
        return out, None if within is None or within_rows is None else within * within_rows

    def _taps(
        self, first: Int32, weights: tuple[Float32, ...], size: int, part: Callable[[Any], Any]
    ) -> tuple[Taps, Float32 | None]:
        """Address parts and weights along an axis, and the sum of the weights where it is not 1."""
        taps: Taps = []
        clipped = self.extension == CLIP
        for k, weight in enumerate(weights):
            index = first + np.int32(k)
            inside = weight * self._inside(index, size).astype(np.float32) if clipped else weight
            taps.append((part(self._wrap(index, size)), inside))
        if not clipped:
            return taps, None
        total = taps[0][1].copy()
        for _, weight in taps[1:]:
            total += weight
        return taps, total

    @staticmethod
    def _inside(i: Int32, size: int) -> NDArray[np.bool_]:
        return (i >= 0) & (i < size)


def bspline(t: Float32) -> tuple[Float32, Float32, Float32, Float32]:
    """Weights of the four texels around a point `t` past the second: the uniform cubic B-spline."""
    sixth, third = np.float32(1 / 6), np.float32(2 / 3)
    return (
        ((-sixth * t + 0.5) * t - 0.5) * t + sixth,
        (0.5 * t - 1) * t * t + third,
        ((-0.5 * t + 0.5) * t + 0.5) * t + sixth,
        sixth * t * t * t,
    )
