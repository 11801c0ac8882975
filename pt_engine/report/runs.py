"""One contender measured: squared error against core seconds, over a few runs with other seeds.

Seconds are of CPU cores, summed over threads: what other programs on the machine do does not count. What is
measured is the film, the light of the whole scene: nobody knows the noise of the picture that shadow
catchers leave of it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..render.ledger import Ledger
from ..render.progressive import Progress, render
from ..render.settings import RenderSettings
from .contenders import Contender
from .errors import Picture, mse

Float64 = NDArray[np.float64]
Asked = Callable[[], bool]


def never() -> bool:
    """Nobody stops it."""
    return False


class Point(NamedTuple):
    """A moment of a run: samples per pixel, core seconds, mean squared error."""

    samples: float
    seconds: float
    mse: float


@dataclass
class Runs:
    """All runs of a contender.

    Attributes
    ----------
    points : list of list of Point
        Of each run, at samples that double, and at its end.
    nonfinite : int
        Samples that were left out.
    """

    contender: Contender
    points: list[list[Point]] = field(default_factory=list)
    nonfinite: int = 0
    _image: Float64 | float = 0.0  # sums over the runs
    _variance: Float64 | float = 0.0

    def run(
        self, reference: Picture, seconds: float, should_stop: Asked = never, ledger: Ledger | None = None
    ) -> bool:
        """Run once more, with the next seed, for so many core seconds, or for its samples if that is less.

        A run that somebody has stopped does not count: False.
        """
        seed = self.contender.settings.seed + 1 + len(self.points)
        watch = Watch(reference, seconds)
        settings = replace(self.contender.settings, seed=seed, seconds=0.0)
        result = render(
            self.contender.scene,
            settings,
            watch.on_progress,
            lambda: watch.should_stop() or should_stop(),
            ledger,
        )
        if should_stop():
            return False
        self.points.append(watch.finish(result.progress))
        self.nonfinite += result.progress.nonfinite_count
        self._image = self._image + colours(result.film.image())
        self._variance = self._variance + result.film.variance_of_mean()
        return True

    @property
    def mean(self) -> Picture:
        """Mean image of all runs, and the variance of its noise as the samples themselves tell it."""
        number = len(self.points)
        return Picture(np.asarray(self._image / number), np.asarray(self._variance / number**2))


def measure(contender: Contender, reference: Picture, seconds: float, seeds: int) -> Runs:
    """A contender's runs, one after the other."""
    runs = Runs(contender)
    for _ in range(seeds):
        runs.run(reference, seconds)
    return runs


def plain(settings: RenderSettings) -> RenderSettings:
    """Without limits and without decisions that depend on the noise."""
    return replace(settings, samples=0, seconds=0.0, target_error=0.0, adaptive=False, half_buffers=False)


def colours(image: NDArray[np.float32]) -> Float64:
    """(height, width, 3) float64 of a film's image, bottom row first."""
    return image[..., :3].astype(np.float64)


class Watch:
    """Notes the error where the samples have doubled; its own time does not count."""

    def __init__(self, reference: Picture, budget: float) -> None:
        self._reference, self._budget = reference, budget
        self._points: list[Point] = []
        self._next = 1
        self._away = 0.0
        self._started = time.process_time()

    @property
    def seconds(self) -> float:
        """Core seconds that the render has taken so far."""
        return time.process_time() - self._started - self._away

    def on_progress(self, progress: Progress) -> None:
        """After every unit of work."""
        whole = progress.camera_samples % max(1, progress.film.pixels) == 0
        if (whole or progress.settings.adaptive) and progress.samples >= self._next:
            self._note(progress)
            self._next = progress.samples * 2

    def should_stop(self) -> bool:
        """Whether the time is used up; two samples are always taken, since one knows nothing of its noise."""
        return bool(self._points) and self._points[-1].samples >= 2 and self.seconds >= self._budget

    def _note(self, progress: Progress) -> None:
        seconds, before = self.seconds, time.process_time()
        samples = progress.camera_samples / progress.film.pixels
        self._points.append(Point(samples, seconds, mse(colours(progress.film.image()), self._reference)))
        self._away += time.process_time() - before

    def finish(self, progress: Progress) -> list[Point]:
        """All points, the last at the end of the run."""
        if not self._points or progress.camera_samples / progress.film.pixels > self._points[-1].samples:
            self._note(progress)
        return self._points
