"""What an image says of its error, on pixels whose samples have known distributions."""

from __future__ import annotations

import numpy as np
import pytest

from pt_engine.render.film import Film

SIZE, FILMS = 16, 60
DRAWS = {
    "gaussian": lambda rng, shape: rng.normal(1.0, 0.8, shape),
    "exponential": lambda rng, shape: rng.exponential(1.0, shape),
    "rare bright": lambda rng, shape: 0.5 + np.where(rng.random(shape) < 0.05, 10.0, 0.0),
}


def films(kind, correlated, samples=64):
    """Films of grey pixels of mean 1; where halves tell, their samples happen to be independent as well."""
    rng = np.random.default_rng(3)
    for _ in range(FILMS):
        film = Film(SIZE, SIZE, correlated=correlated)
        values = DRAWS[kind](rng, samples * SIZE * SIZE).astype(np.float32)
        film.add(slice(0, SIZE * SIZE), 0, samples, np.broadcast_to(values, (3, values.size)))
        yield film


@pytest.mark.parametrize("correlated", [False, True], ids=["independent", "halves"])
@pytest.mark.parametrize("kind", DRAWS)
def test_the_interval_holds_the_error_of_its_own_image(kind, correlated):
    """Of 60 intervals of 95 %, 51 or fewer hold by chance once in 700; the mean told is the mean true one."""
    held, told, true = 0, [], []
    for film in films(kind, correlated):
        error = film.error()
        low, high = error["mse_ci95"]
        true.append(float(((film.image()[..., 0].astype(np.float64) - 1.0) ** 2).mean()))
        told.append(error["mse"])
        held += low <= true[-1] <= high
    assert held > 51
    # 256 squared errors in each of 60 images: their mean is good to 1 %, what is told to 1 to 2 %
    assert np.mean(told) == pytest.approx(np.mean(true), rel=0.06)


@pytest.mark.parametrize("kind", ["gaussian", "exponential"])
def test_even_noise_does_not_make_the_relative_error_larger(kind):
    """Noise of 1/10 in all pixels: to draw only the brighter ones to others would add 2 · 0.1 · 0.4 = 8 %."""
    told, true = [], []
    for film in films(kind, correlated=False):
        told.append(film.error()["relmse"])
        true.append(float(((film.image()[..., 0].astype(np.float64) - 1.0) ** 2).mean()) / 1.01)
    assert np.mean(told) == pytest.approx(np.mean(true), rel=0.05)
