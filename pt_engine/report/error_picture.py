"""What a report keeps of a film: where the image's error is large."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..render.film import Film

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
WIDEST, SMALL = 480, 240  # pixels of an error picture, and of one among many


def error_picture(film: Film) -> Float32:
    """Each pixel's standard error over the image's mean, top row first, averaged down to a small picture."""
    error = np.sqrt(np.nan_to_num(film.variance_of_mean()).mean(axis=2))
    return shrunk(error, WIDEST, float(film.image()[..., :3].mean()))


def difference_picture(image: Float64, reference: Float64) -> Float32:
    """Each pixel's difference from a reference over the reference's mean, in the same way."""
    error = np.sqrt(((image - reference) ** 2).mean(axis=2))
    return shrunk(error, SMALL, float(reference.mean()))


def shrunk(values: Float64, widest: int, scale: float) -> Float32:
    """(height, width) from the bottom row: averaged over blocks, over `scale`, from the top row."""
    full_height, full_width = values.shape
    step = -(-full_width // widest)
    height, width = -(-full_height // step), -(-full_width // step)
    rows = np.minimum(np.arange(height * step), full_height - 1)
    columns = np.minimum(np.arange(width * step), full_width - 1)
    blocks = values[np.ix_(rows, columns)].reshape(height, step, width, step)
    small: Float32 = (blocks.mean(axis=(1, 3)) / (scale or 1.0)).astype(np.float32)
    return small[::-1]
