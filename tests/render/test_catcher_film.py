"""A shadow catcher's picture is the ratio of two films: closed forms, and what it drops."""

import numpy as np
import pytest

from pt_engine.render.catcher_film import CatcherFilm, Parts
from pt_engine.render.film import Film

PIXEL = np.zeros(1, np.int32)


def picture(shaded, alone, sky=None, matte=0.0, samples=4):
    """RGBA of one pixel all of whose samples are alike; the slots that were dropped."""
    film = Film(1, 1)
    caught = CatcherFilm(film, PIXEL)

    def rows(value):
        return np.full((3, samples), value, np.float32)

    parts = Parts(
        matte=rows(matte),
        matte_alpha=np.zeros(samples, np.float32),
        shaded=np.broadcast_to(np.asarray(shaded, np.float32), (3, samples)).copy(),
        alone=np.broadcast_to(np.asarray(alone, np.float32), (3, samples)).copy(),
        hit=np.ones(samples, np.float32),
        sky=None if sky is None else rows(sky),
    )
    film.add(PIXEL, 0, samples, parts.shaded + parts.matte, np.ones(samples, np.float32))
    dropped = caught.add(PIXEL, 0, samples, parts)
    return caught.image()[0, 0], dropped.tolist()


def test_a_shadow_covers_what_it_takes():
    """0.3 of 0.6 is left: coverage 1 − 0.3/0.6; before a sky of 0.8 that much less of it shows."""
    np.testing.assert_allclose(picture(0.3, 0.6)[0], [0, 0, 0, 0.5], atol=1e-6)
    np.testing.assert_allclose(picture(0.3, 0.6, sky=0.8, matte=0.1)[0], [0.5, 0.5, 0.5, 1], atol=1e-6)


def test_where_nothing_shines_there_is_no_shadow():
    np.testing.assert_allclose(picture(0.0, 0.0)[0], [0, 0, 0, 0], atol=1e-6)


@pytest.mark.parametrize("part", ["shaded", "alone"])
def test_samples_that_are_not_finite_are_dropped_from_the_ratio(part):
    """And told, whichever film they were for."""
    values = np.full(4, 0.5, np.float32)
    values[2] = np.nan
    both = {"shaded": 0.5, "alone": 0.5, part: values}
    image, dropped = picture(**both)
    assert dropped == [2]
    np.testing.assert_allclose(image[3], 0, atol=1e-6)
