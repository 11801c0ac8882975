"""Suns drawn on their own: the density is that of the mixture, and a disc's irradiance is in closed form."""

import numpy as np
import pytest
from support.chi2 import chi2_sphere, significance
from support.lamps import density, irradiance, lights, points, smooth, up

from pt_engine.emitters.environment import EnvironmentMap, texel_directions
from pt_engine.emitters.sunny import Disc, SunnyEnvironment, cone_directions

pytestmark = pytest.mark.slow  # physics that no Python changes

HIGH, LOW = (0.6, 0.0, 0.8), (0.0, 0.995, 0.0998749)
SUNS = {
    "half a degree": [(HIGH, 0.0047, 4e4)],
    "tiny": [(HIGH, 0.00025, 1e7)],
    "wide": [(LOW, 0.4, 10.0)],
    "overlapping": [(HIGH, 0.2, 20.0), ((0.5, 0.0, 0.8660254), 0.15, 30.0), (LOW, 0.1, 5.0)],
}


def sky_with(suns, sky=smooth):
    """Radiance of a sky with uniformly bright discs, and the environment that samples it."""

    def radiance(d):
        out = sky(d).astype(np.float32)
        for toward, half, bright in suns:
            w = np.asarray(toward, np.float64)
            chord = ((d - w[:, None]) ** 2).sum(axis=0)
            out = out + np.float32(bright) * (chord < 4 * np.sin(half / 2) ** 2)
        return out

    image = sky(texel_directions(32, 64))[1].reshape(32, 64)
    discs = [Disc(np.array(t), a, b * 4 * np.pi * np.sin(a / 2) ** 2) for t, a, b in suns]
    return SunnyEnvironment(EnvironmentMap(image, radiance), discs, radiance)


@pytest.mark.parametrize("name", SUNS)
def test_a_plane_under_discs(name):
    """E = ∫ L cosθ dω = Σ Lᵢ·π sin²αᵢ·cosθᵢ for discs above the horizon, plus the sky's π(1 + 0.8·2/3)."""
    scene = lights(environment=sky_with(SUNS[name]))
    expected = np.pi * (1 + 0.8 * 2 / 3)
    for toward, half, bright in SUNS[name]:
        if toward[2] > np.sin(half):
            expected += bright * np.pi * np.sin(half) ** 2 * toward[2]
        else:  # cut by the horizon: the part above it, by quadrature over a disc's directions
            u, v = np.divmod(np.arange(500 * 500), 500)
            d = cone_directions(np.array(toward), half, *((a + 0.5).astype(np.float32) / 500 for a in (u, v)))
            expected += (
                bright * 4 * np.pi * np.sin(half / 2) ** 2 * np.maximum(d[2], 0).mean(dtype=np.float64)
            )
    value, error = irradiance(scene, 400_000)
    assert abs(value - expected) < 4.5 * error + 1e-4 * expected
    assert error < 0.01 * expected


@pytest.mark.parametrize("name", SUNS)
def test_samples_have_the_density_of_their_direction(name):
    """Lanes from inside a disc, from its rim and from the map: one density. float32 leaves 1e-4 of it."""
    scene, n = lights(environment=sky_with(SUNS[name])), 50_000
    s = scene.sample(points(n), up(n), np.random.default_rng(3).random((3, n), np.float32))
    pdf = scene.environment_pdf(s.wo)
    same = np.abs(pdf - s.pdf) <= 1e-4 * s.pdf
    assert same.mean() > 0.999  # a rim's rounding decides the others, where no sun shines
    assert same[s.weight[0] * s.pdf > 3].all()


def test_directions_follow_the_density():
    scene = lights(environment=sky_with(SUNS["overlapping"]))

    def draw(u0, u1, u2):
        s = scene.sample(points(u0.size), up(u0.size), np.stack([u0, u1, u2]))
        return s.wo, s.pdf > 0.0

    def pdf(d):
        return density(scene, None, points(d.shape[1]), d)

    p = chi2_sphere(draw, pdf, n=30_000, resolution=(8, 16), pole=(0.0, 0.0, 1.0), cap=2.0)
    assert p > significance(1, 0.001)


def test_cones_hold_their_discs():
    """All directions of a disc lie within its cone's float32 test, for the smallest sun there is."""
    for half in (0.00025, 0.0047, 0.4):
        rng = np.random.default_rng(1)
        u = np.concatenate([rng.random(5000), np.full(5000, 1 - 2.0**-24)]).astype(np.float32)
        d = cone_directions(np.array(HIGH), half, u, rng.random(u.size, np.float32))
        environment = sky_with([(HIGH, half, 1.0)])
        assert (environment._of_suns(d) > 0).all()
