"""What to render in which order: units of work of at most one wavefront each.

A unit is a tile of pixels and a range of samples. Passes grow from one sample, so that a first picture
comes soon, to as many as fill a wavefront. Neither tiles nor passes change the image: each sample's random
numbers depend on its pixel and number alone, and the film's sums are exact.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .settings import RenderSettings

Pixels = NDArray[np.int32]


class Unit(NamedTuple):
    """Pixels (their numbers in the window, row-major from the bottom) and `spp` samples, every `step`-th."""

    pixels: NDArray[np.int32]
    first: int
    spp: int
    step: int = 1


class Step(NamedTuple):
    """What to do until the next decision: that many samples more, of these pixels; 0 ends the render."""

    samples: int
    pixels: NDArray[np.int32]


Decide = Callable[[int], Step]
WAIT = None  # in place of a unit: go on when everything before is in the film
WAVES = 4  # wavefronts of a unit, at most
LARGEST_PASS = 16  # samples: the more, the less of the scene a unit sees, but pixels are uneven for longer


def units(
    settings: RenderSettings,
    order: Pixels,
    decide: Decide | None = None,
    split: Callable[[Pixels], list[Pixels]] = lambda pixels: [pixels],
    aligned: int = 0,
    in_time: Callable[[], float] = lambda: math.inf,
) -> Iterator[Unit | None]:
    """Every unit of the render, pass after pass; without end where samples are unlimited.

    Parameters
    ----------
    order : (n,) int32
        The pixels of the window.
    decide : callable, optional
        Samples done → the next step. It is asked after a WAIT, so the film then holds just what was done.
    split : callable
        Cuts pixels into groups; a unit takes a run of one of them.
    aligned : int
        No pass crosses a sample whose number is a multiple of this, unless it is 0.
    in_time : callable
        How many lanes a unit may have just now.
    """
    done, until = 0, 0
    while settings.samples == 0 or done < settings.samples:
        if decide is not None and done == until:
            yield WAIT
            step = decide(done)
            until, order = done + step.samples, step.pixels
            if step.samples == 0 or order.size == 0:
                return
        count = min(LARGEST_PASS, max(1, done), settings.lanes)
        if aligned:
            count = min(count, aligned - (settings.first_sample + done) % aligned)
        if settings.samples:
            count = min(count, settings.samples - done)
        if decide is not None:
            count = min(count, until - done)
        for group in split(order):
            start = 0
            while start < len(group):
                most = int(min(settings.lanes, in_time()))
                size = even_share(len(group) - start, max(1, most // count))
                yield Unit(group[start : start + size], settings.first_sample + done, count)
                start += size
        done += count


def even_share(pixels: int, most: int) -> int:
    """How many at a time, at most `most`, so that all times are alike."""
    times = max(1, -(-pixels // most))
    return max(1, -(-pixels // times))


def unit_lanes(settings: RenderSettings, waves: int) -> int:
    """Lanes of a unit: so many wavefronts, but no fewer units in a pass than threads are busy with."""
    x0, y0, x1, y1 = settings.window
    threads = settings.threads or os.cpu_count() or 1
    busy = threads + 1 if threads > 1 else 1
    return max(settings.lanes, min(waves * settings.lanes, (x1 - x0) * (y1 - y0) * LARGEST_PASS // busy))


def morton_order(width: int, height: int) -> NDArray[np.int32]:
    """Pixel numbers along a Z curve: neighbours in a wavefront are neighbours in the image."""
    y, x = np.divmod(np.arange(width * height, dtype=np.int64), width)
    return np.argsort(_spread(x) | (_spread(y) << 1), kind="stable").astype(np.int32)


def _spread(v: NDArray[np.int64]) -> NDArray[np.int64]:
    """Put a zero between the bits of 16-bit numbers."""
    for shift, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        v = (v | (v << shift)) & mask
    return v
