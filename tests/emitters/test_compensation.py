"""MIS compensation (Karlik et al. 2019): a sky's emitter sampling leaves dim directions to BSDF sampling.

Checked where the integral is known: a white Lambert plane under the sky L = s(1 + c·z) sees

    E = π s (1 + 2c/3)   upward,   and both strategies, each weighted by MIS, must add up to it.
"""

import numpy as np
import pytest
from support.chi2 import chi2_sphere, significance
from support.lamps import gradient, lamp, lights, points, triangles, up, white

from pt_engine.core.warps import square_to_cosine_hemisphere
from pt_engine.emitters.environment import EnvironmentMap, texel_directions
from pt_engine.render import integrators  # noqa: F401  (fills the registry)
from pt_engine.render.integrator import INTEGRATORS
from pt_engine.render.path_state import mis

pytestmark = pytest.mark.slow  # physics that no Python changes

N = 200_000


def sky(radiance, height=32):
    """The environment of a radiance function."""
    image = radiance(texel_directions(height, 2 * height)).mean(axis=0).reshape(height, 2 * height)
    return EnvironmentMap(image, radiance)


def slope(d):
    """L = 1 + 0.8 z."""
    return np.repeat((1.0 + 0.8 * d[2])[None], 3, axis=0)


def shares(scene, seed=5):
    """Per lane, the two MIS-weighted estimates of E: by emitter sampling and by cosine sampling."""
    rng = np.random.default_rng(seed)
    light = scene.sample(points(N), up(N), rng.random((3, N), np.float32))
    cosine = np.maximum(light.wo[2], 0)
    by_emitter = light.weight[0] * cosine * mis(light.pdf, cosine / np.float32(np.pi))
    d = square_to_cosine_hemisphere(*rng.random((2, N), np.float32))
    pdf = d[2] / np.float32(np.pi)
    by_bsdf = sky_radiance(scene, d)[0] * np.float32(np.pi) * mis(pdf, scene.environment_pdf(d))
    return by_emitter, by_bsdf


def sky_radiance(scene, d):
    return scene._environment.environment.radiance(d)


def test_both_strategies_add_up_under_a_slope():
    """Within 4.5 σ of the closed form; emitter sampling alone, complete, would find all of it."""
    parts = shares(lights(environment=sky(slope)).compensated())
    total = parts[0] + parts[1]
    error = total.std() / np.sqrt(N)
    assert abs(total.mean() - np.pi * (1 + 0.8 * 2 / 3)) < 4.5 * error + 2e-4


def test_it_takes_noise_away():
    """Under a sky with a small sun the two together have less than half the variance of before."""
    scene = lights(environment=sky(gradient, 64))
    before, after = (sum(shares(s)) for s in (scene, scene.compensated()))
    error = np.hypot(before.std(), after.std()) / np.sqrt(N)
    assert abs(before.mean() - after.mean()) < 4.5 * error
    assert after.var() < 0.5 * before.var()


def test_emitter_sampling_alone_would_miss_the_dim_half():
    """Why `Integrator.combines` is off by default: the compensated density is 0 where L is below its mean."""
    scene = lights(environment=sky(slope)).compensated()
    down = np.array([[0.0], [0.0], [-1.0]], np.float32)
    assert scene.environment_pdf(down)[0] == 0
    alone = {name for name, cls in INTEGRATORS.items() if cls.combines}
    assert alone == {"direct_mis", "path_fixed", "path_active", "path"}


@pytest.mark.parametrize("radiance", [slope, gradient])
def test_directions_follow_the_compensated_density(radiance):
    environment = sky(radiance).compensated

    def draw(_, u1, u2):
        d, pdf = environment.sample(u1, u2)
        return d, pdf > 0.0

    assert chi2_sphere(draw, environment.pdf, n=50_000, resolution=(8, 16)) > significance(2, 0.001)


def test_a_sky_without_contrast_is_drawn_whole():
    """Nothing is brighter than the mean: the density stays 1/4π."""
    environment = sky(np.ones_like).compensated
    d = texel_directions(8, 16)
    np.testing.assert_allclose(environment.pdf(d), 1 / (4 * np.pi), rtol=1e-5)
    assert environment.compensated.irradiance == pytest.approx(4 * np.pi)


@pytest.mark.parametrize("others", [{}, {"lamp": lamp("POINT")}, {"triangles": triangles()}])
def test_a_sky_that_is_the_same_everywhere_is_left_to_bsdf_samples(others):
    """Karlik's density is 0 in all directions; what else shines gets all of the samples."""
    given = dict(others)
    lamps = [given.pop("lamp")] if "lamp" in given else []
    whole, alone = lights(*lamps, environment=white(), **given), lights(*lamps, **given)
    left = whole.compensated()
    d = texel_directions(4, 8)
    assert whole.environment_pdf(d).min() > 0
    assert (left.environment_pdf(d) == 0).all()
    changed = []
    same = whole.changed(changed.append)
    assert left.description == same.compensated().description == alone.description
    assert [one.description for one in changed] == [whole.description, left.description]
    u = np.random.default_rng(1).random((3, 64), np.float32)
    samples = (choice.sample(points(64), up(64), u) for choice in (left, alone))
    for mine, theirs in zip(*samples, strict=True):
        np.testing.assert_array_equal(mine, theirs)
