"""Pixel reconstruction by sampling the filter: every sample belongs to one pixel, with weight 1.

Offsets from the pixel's centre are drawn in proportion to a separable filter f(x) f(y), all of them
positive (Ernst et al. 2006, "Filter Importance Sampling"). Blender's filter width w gives

    BOX                1                                                         |x| ≤ w / 2
    GAUSSIAN           exp(−2 (2x / w)²)                                         |x| ≤ 3w / 2
    BLACKMAN_HARRIS    0.35875 + 0.48829 cos t + 0.14128 cos 2t + 0.01168 cos 3t   |x| ≤ w,  t = π x / w

The inverse of the cumulative function is tabulated as in Cycles and read with linear interpolation. One thing
differs: Cycles' table has 1024 entries of which its symmetric filling leaves the last at 0, so that one
sample in a thousand lands between the filter's far end and the pixel's corner. Here there are 1023.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]

STEPS = 1023  # samples of f in the half-range, entries of the table, and intervals of the cumulative sum


def gaussian(x: Float64, width: float) -> Float64:
    return np.exp(-2.0 * (2.0 * x / width) ** 2)


def blackman_harris(x: Float64, width: float) -> Float64:
    t = np.pi * x / width
    value: Float64 = 0.35875 + 0.48829 * np.cos(t) + 0.14128 * np.cos(2 * t) + 0.01168 * np.cos(3 * t)
    return value


def box(x: Float64, width: float) -> Float64:
    return np.ones_like(x)


# kind -> (f(x, width), reach / width)
FILTERS: dict[str, tuple[Callable[[Float64, float], Float64], float]] = {
    "BLACKMAN_HARRIS": (blackman_harris, 1.0),
    "GAUSSIAN": (gaussian, 1.5),
    "BOX": (box, 0.5),
}


class FilterTable:
    """Offsets from the pixel's centre for uniform numbers.

    Attributes
    ----------
    kind : str
        A key of `FILTERS`.
    width : float
        In pixels.
    reach : float
        Largest offset.
    table : (1023,) float32
        Offset at u = i / 1022, rising from −reach to reach.
    """

    def __init__(self, kind: str = "BLACKMAN_HARRIS", width: float = 1.5) -> None:
        if kind not in FILTERS:
            raise ValueError(f"unknown pixel filter {kind!r}; known: {', '.join(FILTERS)}")
        if not (np.isfinite(width) and width > 0):
            raise ValueError(f"the filter width must be positive, got {width}")
        function, reach = FILTERS[kind]
        self.kind, self.width, self.reach = kind, float(width), reach * float(width)
        self.table = _inverse_cdf(lambda x: function(x, self.width), self.reach)
        self._slope = np.diff(self.table)

    def sample(self, u: Float32) -> Float32:
        """Offset along one axis, in pixels, for u in [0, 1); the shape of u, one call serves both axes."""
        if self.kind == "BOX":
            return (u - np.float32(0.5)) * np.float32(self.width)
        scaled = u * np.float32(STEPS - 1)
        index = np.minimum(scaled.astype(np.intp), STEPS - 2)
        scaled -= index.astype(np.float32)
        offset: Float32 = self._slope.take(index, mode="wrap")
        offset *= scaled
        offset += self.table.take(index, mode="wrap")
        return offset


def _inverse_cdf(f: Callable[[Float64], Float64], reach: float) -> Float32:
    """Inverse over [0, reach], mirrored about the middle."""
    x: Float64 = np.arange(STEPS, dtype=np.float64) * (reach / (STEPS - 1))
    cdf = np.concatenate([[0.0], np.cumsum(f(x))])
    cdf /= cdf[-1]
    target = np.arange(STEPS // 2 + 1) / float(STEPS // 2)
    above = np.searchsorted(cdf, target, side="right")
    inner = np.minimum(above, STEPS - 1)
    # `above` is the first entry beyond the target, so this steps back from it, with the next slope.
    part = (target - cdf[inner]) / (cdf[inner + 1] - cdf[inner])
    position = np.where(above < STEPS, np.maximum(inner + part, 0.0), float(STEPS))
    half = position * (reach / STEPS)
    return np.concatenate([-half[:0:-1], half]).astype(np.float32)
