"""The picture of a scene with shadow catchers, made of several films as Cycles does it.

    shadow = 1 − α + α · (C − M) / B            C, α all; M before catchers; B the catchers alone
    colour = M        coverage = α_M + (1 − α_M) · (1 − mean(shadow))

Before a film that is not transparent, the sky lies behind: M + sky · (1 − coverage), and all is covered.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .film import Film

Float32 = NDArray[np.float32]


class Parts(NamedTuple):
    """What catchers make of N samples.

    Attributes
    ----------
    matte : (3, N) float32
        Radiance that the picture shows.
    matte_alpha : (N,) float32
    shaded, alone : (3, N) float32
        Light that leaves catchers in the whole scene, and with catchers alone.
    hit : (N,) float32
        1 where a catcher was met.
    sky : (3, N) float32 or None
        What lies behind; None for a transparent film.
    """

    matte: Float32
    matte_alpha: Float32
    shaded: Float32
    alone: Float32
    hit: Float32
    sky: Float32 | None


def empty_parts(like: Parts, shape: tuple[int, ...]) -> Parts:
    """Rows like those of `like`, by sample and pixel: room for `put`."""
    return Parts._make(
        None if row is None else np.zeros((*row.shape[:-1], *shape), row.dtype) for row in like
    )


def put(into: Parts, parts: Parts, rows: slice, columns: Any, size: tuple[int, int]) -> None:
    """The parts of `size` (samples, pixels) into the samples `rows` and pixels `columns`."""
    for target, row in zip(into, parts, strict=True):
        if target is not None and row is not None:
            target[..., rows, columns] = row.reshape(*row.shape[:-1], *size)


def flattened(parts: Parts) -> Parts:
    """Samples and pixels as slots again."""
    return Parts._make(None if row is None else row.reshape(*row.shape[:-2], -1) for row in parts)


class CatcherFilm:
    """Films of the parts, each like the `film` of the whole."""

    def __init__(self, film: Film, order: NDArray[np.int32]) -> None:
        self._whole = film
        self._films = [Film(film.width, film.height, order=order) for _ in range(4)]
        self._has_sky = False

    def add(self, pixels: NDArray[np.integer], first: int, count: int, parts: Parts) -> NDArray[np.integer]:
        """As `Film.add`; the slots that some film has dropped."""
        matte, shaded, alone, sky = self._films
        dropped = [
            matte.add(pixels, first, count, parts.matte, parts.matte_alpha),
            shaded.add(pixels, first, count, parts.shaded, parts.hit),
            alone.add(pixels, first, count, parts.alone),
        ]
        if parts.sky is not None:
            self._has_sky = True
            dropped.append(sky.add(pixels, first, count, parts.sky))
        return np.unique(np.concatenate(dropped))

    def image(self) -> Float32:
        """(height, width, 4) float32, as `Film.image`."""
        covered = np.clip(self._whole.image()[..., 3:], 0, 1)
        matte, shaded, alone, sky = (film.image() for film in self._films)
        b = alone[..., :3]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where((b != 0) & (shaded[..., 3:] > 0), shaded[..., :3] / b, 1)
        shadow = 1 - covered + covered * ratio
        alpha = np.clip(matte[..., 3], 0, 1)
        dark = 1 - np.clip(shadow.mean(axis=-1), 0, 1)
        alpha = alpha + (1 - alpha) * dark
        image = np.concatenate([matte[..., :3], alpha[..., None]], axis=-1)
        if self._has_sky:
            image[..., :3] += sky[..., :3] * (1 - alpha[..., None])
            image[..., 3] = 1
        return image.astype(np.float32)
