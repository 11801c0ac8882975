"""Emitters are drawn from with the density that they claim, and rays that find them agree."""

import numpy as np
import pytest
from support.chi2 import chi2_counts, chi2_sphere, significance
from support.lamps import (
    DELTA,
    SIZED,
    density,
    environment_map,
    gradient,
    irradiance,
    lamp,
    lights,
    placed,
    points,
    smooth,
    triangles,
    up,
    white,
)

from pt_engine.emitters.environment import EnvironmentMap, texel_directions

pytestmark = pytest.mark.slow  # physics that no Python changes

MIXED = (SIZED["sphere"], SIZED["rectangle"], SIZED["disk"], SIZED["sun"], SIZED["spot"])
SCENES = {name: (lights(one), None) for name, one in SIZED.items()}
SCENES["constant environment"] = lights(environment=white()), None
SCENES["environment map"] = lights(environment=environment_map(sky=smooth)), None
SCENES["triangles"] = lights(triangles=triangles(3)), triangles(3)
SCENES["everything"] = (
    lights(*MIXED, triangles=triangles(2), environment=environment_map(sky=smooth)),
    triangles(2),
)


def axis_of(scene):
    """Where most samples go, and 1 − cos of a cap around it that holds all of them but for stray ones."""
    n = 2000
    u = np.random.default_rng(0).random((3, n), np.float32)
    s = scene.sample(points(n), up(n), u)
    valid = s.pdf > 0.0
    mean = s.wo[:, valid].astype(np.float64).mean(axis=1)
    length = np.sqrt((mean**2).sum())
    if length < 0.3:
        return (0.0, 0.0, 1.0), 2.0
    mean /= length
    reach = float((1.0 - mean @ s.wo[:, valid]).max())
    return tuple(mean), min(1.5 * reach, 2.0)


@pytest.mark.parametrize("name", [*list(SCENES)[:-1], pytest.param("everything", marks=pytest.mark.slow)])
def test_directions_follow_the_density(name):
    """χ² of the sampler against the sum of all emitters' densities; a few hundred cells."""
    scene, emitters = SCENES[name]
    pole, cap = axis_of(scene)

    def draw(u0, u1, u2):
        s = scene.sample(points(u0.size), up(u0.size), np.stack([u0, u1, u2]))
        return s.wo, s.pdf > 0.0

    def pdf(d):
        return density(scene, emitters, points(d.shape[1]), d)

    p_value = chi2_sphere(draw, pdf, n=50_000, resolution=(12, 24), pole=pole, cap=cap)
    assert p_value > significance(len(SCENES), 0.001)


def test_environment_texels_are_drawn_in_proportion_to_their_brightness():
    """χ² of 32 × 64 texels with a sun in them; mass = density at the centre × ∫ dz dφ of the texel."""
    scene, n, (rows, columns) = lights(environment=environment_map()), 400_000, (32, 64)
    s = scene.sample(points(n), up(n), np.random.default_rng(3).random((3, n), np.float32))
    np.testing.assert_allclose(scene.environment_pdf(s.wo), s.pdf, rtol=1e-4)
    v = 1.0 - np.arccos(np.clip(s.wo[2], -1.0, 1.0)) / np.pi
    u = (0.5 - np.arctan2(s.wo[1], s.wo[0]) / (2 * np.pi)) % 1.0
    texel = np.minimum((v * rows).astype(int), rows - 1) * columns + np.minimum((u * columns).astype(int), 63)
    solid = np.diff(-np.cos(np.pi * np.arange(rows + 1) / rows)) * 2 * np.pi / columns
    density_at_centre = scene.environment_pdf(texel_directions(rows, columns)).astype(np.float64)
    mass = density_at_centre * np.repeat(solid, columns)
    np.testing.assert_allclose(mass.sum(), 1.0, rtol=1e-6)
    assert chi2_counts(np.bincount(texel, minlength=rows * columns), n * mass) > 1e-4


def test_what_is_interpolated_between_a_bright_texel_and_a_black_one_can_be_drawn():
    """Density next to a lone bright texel: 1/8 · 6/8 of its neighbours' mean, 1/64 at the corners."""
    image = np.zeros((8, 16))
    image[4, 0] = 64.0
    scene = lights(environment=EnvironmentMap(image, gradient))
    pdf = scene.environment_pdf(texel_directions(8, 16)).reshape(8, 16)
    around = pdf[3:6, [15, 0, 1]] / pdf[4, 0] * 36
    np.testing.assert_allclose(around, [[1, 6, 1], [6, 36, 6], [1, 6, 1]], rtol=1e-6)
    assert np.count_nonzero(pdf) == 9


@pytest.mark.parametrize("name", SIZED)
def test_a_ray_along_the_sample_meets_the_lamp_with_the_same_density_and_radiance(name):
    """Rounding may push rays off the rim: one in a thousand may miss. float32 leaves 1e-3 of the pdf."""
    scene, n = lights(SIZED[name]), 20_000
    p = points(n)
    p[:2] = np.random.default_rng(5).uniform(-0.5, 0.5, (2, n))
    s = scene.sample(p, up(n), np.random.default_rng(1).random((3, n), np.float32))
    wanted = np.flatnonzero(s.weight[0] > 0.0)
    hits = [h for h in scene.intersect(p, s.wo, np.full(n, np.inf, np.float32)) if h.lanes.size]
    assert len(hits) == 1
    lanes, radiance, pdf, _ = hits[0]
    common = np.intersect1d(wanted, lanes)
    assert common.size > 0.999 * wanted.size - 1 or name == "tiny sphere"
    place = np.searchsorted(lanes, common)
    np.testing.assert_allclose(pdf[place], s.pdf[common], rtol=1e-3)
    bright = radiance[0, place] > 1e-2 * radiance[0].max()  # a beam's last per cent is steep in rounding
    got, want = radiance[0, place] / pdf[place], s.weight[0, common]
    np.testing.assert_allclose(got[bright], want[bright], rtol=5e-3)


@pytest.mark.parametrize("name", [n for n in SIZED if n not in ("tiny sphere", "thin sun", "far rectangle")])
def test_irradiance_two_ways(name):
    """E = ∫ L cosθ dω by light sampling, and by cosine-distributed rays that meet the lamp: π · mean L."""
    scene, n = lights(SIZED[name]), 400_000
    expected, error = irradiance(scene, n)
    u, v = np.random.default_rng(2).random((2, n))
    d = np.stack([np.sqrt(u) * np.cos(2 * np.pi * v), np.sqrt(u) * np.sin(2 * np.pi * v), np.sqrt(1 - u)])
    found = np.zeros(n)
    d, far = d.astype(np.float32), np.full(n, np.inf, np.float32)
    for lanes, radiance, *_ in scene.intersect(points(n), d, far):
        found[lanes] += radiance[0]
    found *= np.pi
    standard_error = np.hypot(error, found.std() / np.sqrt(n))
    assert abs(found.mean() - expected) < 4.5 * standard_error + 2e-4 * expected  # float32: 2e-4


def test_emitters_are_chosen_in_proportion_to_their_power():
    """χ² of the choices against 0.99 · power / Σ power + 0.01 / count; the latter is the even share."""
    lamps = [lamp("POINT", placed(x), power=power) for x, power in enumerate((1.0, 5.0, 20.0))]
    scene = lights(*lamps, SIZED["disk"], SIZED["sun"], triangles=triangles(), environment=white())
    n = 200_000
    s = scene.sample(points(n), up(n), np.random.default_rng(4).random((3, n), np.float32))
    np.testing.assert_allclose(scene.chance, 0.99 * scene.power / scene.power.sum() + 0.01 / scene.power.size)
    observed = np.bincount(s.emitter, minlength=scene.power.size)
    assert chi2_counts(observed, n * scene.chance) > 1e-4


def test_powers_are_watts_and_flux_through_the_cross_section():
    """Sun of irradiance E, white world L, radius R: π R² E and π R² · 4π L; two-sided triangles 2π A L."""
    emitters = triangles(1)
    lamps = lamp("POINT", power=7.0), lamp("SUN", power=3.0)
    scene = lights(*lamps, triangles=emitters, environment=white(2.0))
    cross_section = np.pi * 3.0**2
    glow = 2 * np.pi * emitters.areas()[0] * emitters.radiance[0].mean()
    np.testing.assert_allclose(
        scene.power, [7.0, 3.0 * cross_section, glow, cross_section * 4 * np.pi * 2.0], rtol=1e-6
    )


def test_results_do_not_depend_on_the_batch():
    """Any subset of lanes gives the same bits as all of them."""
    scene = lights(*MIXED, *DELTA.values(), triangles=triangles(varying=True), environment=environment_map())
    n = 5000
    rng = np.random.default_rng(6)
    p, u = rng.uniform(-1, 1, (3, n)).astype(np.float32), rng.random((3, n), np.float32)
    every = scene.sample(p, up(n), u)
    some = np.flatnonzero(rng.random(n) < 0.2)
    part = scene.sample(p[:, some].copy(), up(some.size), u[:, some].copy())
    for a, b in zip(every[:6], part[:6], strict=True):
        np.testing.assert_array_equal(a[..., some], b)


def test_varying_triangles_leave_their_emission_out():
    """weight · pdf = 1 on the lanes named `varying`, and p0 + b1·e1 + b2·e2 lies along wo."""
    emitters = triangles(varying=True)
    scene, n = lights(triangles=emitters), 4000
    s = scene.sample(points(n), up(n), np.random.default_rng(8).random((3, n), np.float32))
    assert np.isin(s.triangle, np.flatnonzero(emitters.varies)).all()
    np.testing.assert_array_equal(s.varying, np.flatnonzero(emitters.varies[s.emitter]))
    np.testing.assert_allclose(s.weight[:, s.varying] * s.pdf[s.varying], 1.0, rtol=1e-5)
    a, b, c = emitters.vertices[s.triangle].transpose(1, 2, 0)
    place = a + s.barycentric[0] * (b - a) + s.barycentric[1] * (c - a)
    place /= np.sqrt((place**2).sum(axis=0))
    np.testing.assert_allclose(place, s.wo[:, s.varying], atol=2e-6)
