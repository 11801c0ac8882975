"""Pictures of light groups: a film for each, of the shares of the samples that the whole film took."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .film import Film

Float32 = NDArray[np.float32]


class GroupFilms:
    """Films of the groups of these names, each like the `film` of the whole."""

    def __init__(self, film: Film, order: NDArray[np.int32], names: tuple[str, ...]) -> None:
        self.films = {name: Film(film.width, film.height, film.key, order) for name in names}

    def add(
        self,
        pixels: NDArray[np.integer],
        first: int,
        count: int,
        shares: Float32,
        refused: NDArray[np.intp],
    ) -> None:
        """As `Film.add`; `shares` (3, G + 1, count · m); `refused` are slots that the whole film dropped."""
        for number, film in enumerate(self.films.values(), start=1):
            share = shares[:, number]
            if refused.size:
                share = share.copy()
                share[:, refused] = np.nan  # dropped here, too: all have the same counts
            film.add(pixels, first, count, share)

    def image(self, name: str) -> Float32:
        """(height, width, 3) float32 of a group, bottom row first."""
        return self.films[name].image()[..., :3]
