"""What to render in which order: units of work of at most one wavefront each.

A unit is a tile of pixels and a range of samples. Passes grow from one sample, so that a first picture
comes soon, to as many as fill a wavefront. Neither tiles nor passes change the image: each sample's random
numbers depend on its pixel and number alone, and the film's sums are exact.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .settings import RenderSettings


class Unit(NamedTuple):
    """Pixels (their numbers in the window, row-major from the bottom) and a range of samples."""

    pixels: NDArray[np.int32]
    first: int
    count: int


def units(settings: RenderSettings) -> Iterator[Unit]:
    """Every unit of the render, pass after pass; without end where samples are unlimited."""
    x0, y0, x1, y1 = settings.window
    order = morton_order(x1 - x0, y1 - y0)
    tiles = max(1, -(-len(order) // settings.lanes))
    parts = np.array_split(order, tiles)
    first, done = settings.first_sample, 0
    largest = max(1, settings.lanes // max(len(part) for part in parts))
    while settings.samples == 0 or done < settings.samples:
        count = min(largest, max(1, done))
        if settings.samples:
            count = min(count, settings.samples - done)
        for part in parts:
            yield Unit(part, first + done, count)
        done += count


def morton_order(width: int, height: int) -> NDArray[np.int32]:
    """Pixel numbers along a Z curve: neighbours in a wavefront are neighbours in the image (coherent rays)."""
    y, x = np.divmod(np.arange(width * height, dtype=np.int64), width)
    return np.argsort(_spread(x) | (_spread(y) << 1), kind="stable").astype(np.int32)


def _spread(v: NDArray[np.int64]) -> NDArray[np.int64]:
    """Put a zero between the bits of 16-bit numbers."""
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        v = (v | (v << shift)) & mask
    return v
