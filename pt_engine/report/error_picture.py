"""What a report keeps of a film: where the image's error is large."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..render.film import Film

WIDEST = 480  # pixels of an error picture


def error_picture(film: Film) -> NDArray[np.float32]:
    """Each pixel's standard error over the image's mean, top row first, averaged down to a small picture."""
    error = np.sqrt(np.nan_to_num(film.variance_of_mean()).mean(axis=2))
    mean = float(film.image()[..., :3].mean(dtype=np.float64))  # a sum of huge pixels is no float32
    step = -(-film.width // WIDEST)
    height, width = -(-film.height // step), -(-film.width // step)
    rows = np.minimum(np.arange(height * step), film.height - 1)
    columns = np.minimum(np.arange(width * step), film.width - 1)
    blocks = error[np.ix_(rows, columns)].reshape(height, step, width, step)
    small: NDArray[np.float32] = (blocks.mean(axis=(1, 3)) / (mean or 1.0)).astype(np.float32)
    return small[::-1]
