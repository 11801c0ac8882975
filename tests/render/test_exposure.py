"""A film's exposure multiplies colours, as Cycles' does, and nothing else."""

from dataclasses import replace

import numpy as np
from support import scenes as make
from support.rooms import SOFT_LAMP, half_transparent, room

from pt_engine.render.replay import replay
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare

VEIL = room(half_transparent(0.5), SOFT_LAMP, make.world((0.3, 0.4, 0.6)))


def image(exposure):
    return make.rendered(replace(VEIL, exposure=exposure), 12, samples=4, film_transparent=True).image()


def test_a_power_of_two_is_exact():
    plain, brighter = image(1.0), image(4.0)
    np.testing.assert_array_equal(brighter[..., :3], 4 * plain[..., :3])
    np.testing.assert_array_equal(brighter[..., 3], plain[..., 3])


def test_any_factor_is_exact_up_to_one_rounding_of_each_sample():
    np.testing.assert_allclose(image(1.7)[..., :3], np.float32(1.7) * image(1.0)[..., :3], rtol=3e-7)


def test_no_exposure_is_black():
    assert not image(0.0)[..., :3].any()


def test_a_replayed_path_tells_it():
    settings = RenderSettings(12, 12, samples=1)
    plain, brighter = (replay(prepare(replace(VEIL, exposure=e)), settings, 6, 6, 0) for e in (1.0, 2.5))
    assert plain.radiance.any()
    np.testing.assert_array_equal(brighter.radiance, plain.radiance * np.float32(2.5))
    assert brighter.events[-1].numbers == {"factor": 2.5}
    total = sum(e.contribution for e in brighter.events if e.contribution is not None)
    np.testing.assert_allclose(total, brighter.radiance, rtol=1e-5)
