"""What a report keeps of a render while it runs: how its error fell, and where it is large."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..render.film import Film
from ..render.progressive import Progress

WIDEST = 480  # pixels of an error picture


@dataclass
class Seen:
    """Follows a render.

    Attributes
    ----------
    history : list of (seconds, relative RMS error)
        At samples that double.
    film : Film or None
        The render's own.
    """

    history: list[tuple[float, float]] = field(default_factory=list)
    film: Film | None = None
    _next: int = 4

    def on_progress(self, progress: Progress) -> None:
        """After every unit of work."""
        self.film = progress.film
        whole = progress.camera_samples % max(1, progress.film.pixels) == 0
        if whole and progress.samples >= self._next:
            self._next = 2 * progress.samples
            relative = progress.film.error()["relmse"]
            if isinstance(relative, float) and relative > 0:
                self.history.append((progress.elapsed, math.sqrt(relative)))


def error_picture(film: Film) -> NDArray[np.float32]:
    """Each pixel's standard error over the image's mean, top row first, averaged down to a small picture."""
    error = np.sqrt(np.nan_to_num(film.variance_of_mean()).mean(axis=2))
    mean = float(film.image()[..., :3].mean())
    step = -(-film.width // WIDEST)
    height, width = -(-film.height // step), -(-film.width // step)
    rows = np.minimum(np.arange(height * step), film.height - 1)
    columns = np.minimum(np.arange(width * step), film.width - 1)
    blocks = error[np.ix_(rows, columns)].reshape(height, step, width, step)
    small: NDArray[np.float32] = (blocks.mean(axis=(1, 3)) / (mean or 1.0)).astype(np.float32)
    return small[::-1]
