"""Which moment of the shutter each sample sees.

Embree knows no time, so a wavefront renders one moment: a slice of the scene. Which one is a random number of
the render's own sampler, in a dimension that nothing else uses, with a crowd in the place of the pixel and a
run of samples in the place of the sample:

    time(crowd, run) = shutter⁻¹(u(crowd, run, SHUTTER))

- Each time is uniform over the shutter, so the mean over samples tends to the integral over time and not to a
  sum over some fixed times; with Sobol numbers, powers of two of the even runs are stratified, and of the
  odd.
- It depends on seed, pixel and sample number alone: neither threads nor tiles nor the range of samples change
  it, films of disjoint ranges merge, and a replay finds the same moment.
- Pixels belong to crowds by a hash, and each crowd has times of its own. So what moves is dithered between
  many more moments than a pixel has samples, and does not show as that many copies.

A rolling shutter makes each row a crowd: its times are its own (`Slices.at`), and a run is long, for a row
has few pixels.

Where little moves, a run is one sample and there are many crowds; where much moves, what is built for a slice
has to serve more samples: an even run the even samples of a block, an odd one the odd samples, so that the
film's halves A and B never see the same moment. Both numbers come from the scene and the image's full size.

Pixels of a crowd see the same moments, so what the moments leave of noise is alike in pixels that see the
same thing move: the image's error has fewer independent parts than pixels there.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from threading import Lock
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..core.hashing import lowbias32
from ..core.samplers import Sampler
from ..scene.scene import Scene
from ..scene.slices import Slices
from .dimensions import SHUTTER
from .schedule import Unit
from .settings import RenderSettings

UInt32 = NDArray[np.uint32]
Pixels = NDArray[np.int32]
Value = TypeVar("Value")

MOST_CROWDS = 16
LONGEST_RUN = 8  # samples
FEWEST_LANES = 1 << 15  # a wavefront of fewer is slow
CHEAP = 4  # times the triangles that move: as many pixels make what a slice builds a small part of its time


class Moment(NamedTuple):
    """A slice's name."""

    crowd: int
    run: int


class Part(NamedTuple):
    """Samples `rows` and pixels `columns` of a unit, which see the same moment, as a unit of their own."""

    unit: Unit
    rows: slice
    columns: slice | NDArray[np.intp]
    moment: Moment


class Moments:
    """The slices of a render.

    Parameters
    ----------
    slices : Slices
    settings : RenderSettings
    sampler : Sampler
    seen : callable
        `Worker.seen`.

    Attributes
    ----------
    crowds : int
        A power of two; with a rolling shutter the number of rows.
    run : int
        Samples of a pixel that see the same moment; a power of two.
    block : int
        Samples from a multiple of it on that are best rendered together: two runs, if they are of several.
    """

    def __init__(
        self, slices: Slices, settings: RenderSettings, sampler: Sampler, seen: Callable[[Scene], Scene]
    ) -> None:
        pixels, triangles = settings.width * settings.height, slices.triangles
        self._rolls = slices.exposure < 1
        self.crowds, self.run = (settings.height, LONGEST_RUN // 2) if self._rolls else (1, 1)
        most = 1 if self._rolls else MOST_CROWDS
        while self.crowds < most and 2 * self.crowds * max(FEWEST_LANES, CHEAP * triangles) <= pixels:
            self.crowds *= 2
        while self.run < LONGEST_RUN and pixels * self.run < triangles:
            self.run *= 2
        self.block = 2 * self.run if self.run > 1 else 1
        self._slices, self._settings, self._sampler, self._seen = slices, settings, sampler, seen
        kept = max(min(self.crowds, MOST_CROWDS), min(2, self.block))
        self._kept: Kept[Moment, Scene] = Kept(kept)

    def scene(self, moment: Moment) -> Scene:
        """The slice of a moment, built when first asked for."""
        return self._kept.get(moment, lambda: self._built(moment))

    def _built(self, moment: Moment) -> Scene:
        state = self._sampler.state(np.array([moment.crowd]), np.array([moment.run]))
        u = float(self._sampler.uniforms(state, SHUTTER, 1)[0, 0])
        down = 1 - moment.crowd / self._settings.height if self._rolls else 0.5
        return self._seen(self._slices.at(u, down))

    def groups(self, order: Pixels) -> list[Pixels]:
        """The window's pixels crowd by crowd, in their order."""
        crowd = self._crowd(order)
        by_crowd = np.argsort(crowd, kind="stable")
        ends = np.flatnonzero(np.diff(crowd[by_crowd])) + 1
        return np.split(order[by_crowd], ends)

    def parts(self, unit: Unit) -> Iterator[Part]:
        """A unit cut into what sees one moment; those cut by `groups` and runs already are one part."""
        crowd = self._crowd(unit.pixels)
        present = np.unique(crowd)
        samples = np.arange(unit.first, unit.first + unit.spp)
        run_of = samples if self.run == 1 else 2 * (samples // self.block) + samples % 2
        step = 1 if self.run == 1 else 2
        for run in np.unique(run_of):
            of_run = samples[run_of == run]
            first, count = int(of_run[0]), len(of_run)
            rows = slice(first - unit.first, int(of_run[-1]) - unit.first + 1, step)
            for k in present:
                columns = slice(None) if len(present) == 1 else np.flatnonzero(crowd == k)
                part = Unit(unit.pixels[columns], first, count, step)
                yield Part(part, rows, columns, Moment(int(k), int(run)))

    def _crowd(self, pixels: Pixels) -> UInt32:
        """(n,) crowd of pixels of the window, by their place in the full image."""
        if self.crowds == 1:
            return np.zeros(len(pixels), np.uint32)
        x0, y0, x1, _ = self._settings.window
        y, x = np.divmod(pixels.astype(np.int64), x1 - x0)
        if self._rolls:
            return (y + y0).astype(np.uint32)
        number = (y + y0) * self._settings.width + x + x0
        crowd: UInt32 = lowbias32(number.astype(np.uint32)) & np.uint32(self.crowds - 1)
        return crowd


Key = TypeVar("Key")


class Kept(Generic[Key, Value]):
    """The latest few of some values that are made once, by whoever asks first; others wait for it."""

    def __init__(self, size: int) -> None:
        self._size, self._lock = size, Lock()
        self._values: OrderedDict[Key, Future[Value]] = OrderedDict()

    def get(self, key: Key, make: Callable[[], Value]) -> Value:
        """The value of a key."""
        with self._lock:
            known = self._values.get(key)
            future = known or self._values.setdefault(key, Future())
            self._values.move_to_end(key)
            while len(self._values) > self._size:
                self._values.popitem(last=False)
        if known is None:
            try:
                future.set_result(make())
            except BaseException as error:
                future.set_exception(error)
        return future.result()
