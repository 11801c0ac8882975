"""Of many emitters the choice is by place: its probabilities are as claimed, and so is what rays meet."""

import numpy as np
import pytest
from support.chi2 import chi2_counts
from support.lamps import DELTA, SIZED, environment_map, floor, lamp, lights, placed, points, triangles

from pt_engine.emitters.many import Surfaces
from pt_engine.scene.accel import Accel


def surfaces(opaque=True, half=3.0):
    return Surfaces(*floor(half), opaque, Accel)


def scattered(count, seed=0, **settings):
    """Lamps at heights of 0.3 to 2, of very different power."""
    rng = np.random.default_rng(seed)
    place = rng.uniform((-3, -3, 0.3), (3, 3, 2), (count, 3))
    watts = rng.exponential(9, count).tolist()
    return [lamp("POINT", placed(*p), power=w, **settings) for p, w in zip(place, watts, strict=True)]


SORTS = [*SIZED.values(), *DELTA.values()]
MIXED = {
    "points": lambda opaque: lights(*scattered(300), surfaces=surfaces(opaque)),
    "every sort": lambda opaque: lights(
        *SORTS, triangles=triangles(20), environment=environment_map(), surfaces=surfaces(opaque)
    ),
}
PLACES = [((0.1, 0.2, 0.0), (0, 0, 1)), ((-2.5, 1.7, 0.0), (0, 0, -1)), ((1.0, 1.0, 5.0), (1, 0, 0))]


def here(position, normal, n):
    return points(n, position), points(n, normal)


@pytest.mark.parametrize("opaque", [True, False])
@pytest.mark.parametrize("name", MIXED)
def test_probabilities_are_those_of_the_choices(name, opaque):
    """Σ pmf = 1, all are > 0, χ² of 100,000 choices, and each is told its own pmf; also off all surfaces."""
    scene, n = MIXED[name](opaque), 100_000
    choice, count = scene.by_place, len(scene.power)
    assert choice is not None
    for position, normal in PLACES:
        p, side = here(position, normal, n)
        place = choice.place(p, side)
        assert (place[0] > 0) == (position[2] == 0.0)
        pmf = choice.ratio(place[:count], np.arange(count)).astype(np.float64) * scene.chance
        assert abs(pmf.sum() - 1.0) < 1e-6  # float32 tables
        assert (pmf > 0.0099 * scene.chance).all()  # a twentieth by groups' weights, a fifth of these power
        chosen, ratio = choice.sample(place, np.random.default_rng(1).random(n, np.float32))
        assert chi2_counts(np.bincount(chosen, minlength=count), n * pmf) > 1e-4
        np.testing.assert_allclose(ratio, choice.ratio(place, chosen), rtol=1e-6)


@pytest.mark.parametrize(("opaque", "half"), [(True, 3.0), (False, 3.0), (True, 500.0)])
def test_irradiance_is_the_sum_over_all_lamps_and_its_variance_is_small(opaque, half):
    """E = Σ Φ cosθ / 4π d²: by samples within 4.5 standard errors, and a tenth of the variance by power."""
    lamps, n = scattered(1000), 40_000
    power = np.array([x.power for x in lamps])
    centre = np.array([x.matrix[:3, 3] for x in lamps])
    u = np.random.default_rng(3).random((3, n), np.float32)
    for position in ((0.1, 0.2, 0.0), (-2.5, 1.7, 0.0)):
        p, up = here(position, (0, 0, 1), n)
        to = centre - position
        expected = (power / (4 * np.pi) * to[:, 2] / (to**2).sum(axis=1) ** 1.5).sum()
        variance = []
        for ground in (surfaces(opaque, half), None):
            s = lights(*lamps, surfaces=ground).sample(p, up, u)
            value = s.weight[0].astype(np.float64) * np.maximum(s.wo[2], 0.0)
            assert abs(value.mean() - expected) < 4.5 * value.std() / np.sqrt(n) + 2e-4 * expected
            variance.append(value.var())
        assert 10 * variance[0] < variance[1]


def test_few_emitters_and_those_far_away_are_chosen_by_power_as_ever():
    """The same bits with and without surfaces: seven lamps; dozens of suns."""
    n = 1000
    u = np.random.default_rng(2).random((3, n), np.float32)
    p, up = here((0.1, 0.2, 0.0), (0, 0, 1), n)
    suns = [lamp("SUN", placed(tilt=0.02 * k), power=3.0, angle=0.01) for k in range(40)]
    for lamps in (scattered(7), suns):
        scene = lights(*lamps, surfaces=surfaces())
        assert scene.by_place is None
        for a, b in zip(scene.sample(p, up, u)[:6], lights(*lamps).sample(p, up, u)[:6], strict=True):
            np.testing.assert_array_equal(a, b)


def test_rays_that_find_an_emitter_know_the_density_of_its_sample():
    """pdf_triangle, environment_pdf and intersect for the sample's own place: its pdf, to float32."""
    emitters, n = triangles(20), 20_000
    scene = lights(*SIZED.values(), triangles=emitters, environment=environment_map(), surfaces=surfaces())
    p, up = here((0.1, 0.2, 0.0), (0, 0, 1), n)
    s = scene.sample(p, up, np.random.default_rng(4).random((3, n), np.float32))
    number = s.emitter - scene.lamps
    faces = np.flatnonzero((number >= 0) & (number < 20))
    corners = emitters.vertices[number[faces]].astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.sqrt((normal**2).sum(axis=1, keepdims=True))
    d = s.wo[:, faces].T
    cos = np.abs((normal * d).sum(axis=1))
    t = np.abs(((corners[:, 0] - p[:, faces].T) * normal).sum(axis=1)) / cos
    pdf = scene.pdf_triangle(number[faces], t.astype(np.float32), cos.astype(np.float32), s.place[faces])
    steep = cos > 0.05
    np.testing.assert_allclose(pdf[steep], s.pdf[faces][steep], rtol=1e-3)
    sky = np.flatnonzero(number == 20)
    np.testing.assert_allclose(scene.environment_pdf(s.wo[:, sky], s.place[sky]), s.pdf[sky], rtol=1e-3)
    bright = np.flatnonzero((number < 0) & (s.weight[0] > 0))
    nearest = np.full(n, np.inf)
    for hits in scene.intersect(p, s.wo, np.full(n, np.inf, np.float32), None, s.place):
        off = np.abs(hits.pdf / s.pdf[hits.lanes] - 1.0)
        nearest[hits.lanes] = np.minimum(nearest[hits.lanes], off)
    assert faces.size > 100
    assert sky.size > 50
    assert np.quantile(nearest[bright], 0.99) < 2e-3  # rounding pushes a few rays off a rim


def test_lanes_do_not_depend_on_each_other():
    scene, n = MIXED["every sort"](True), 3000
    rng = np.random.default_rng(6)
    p, u = rng.uniform(-3, 3, (3, n)).astype(np.float32), rng.random((3, n), np.float32)
    p[2] = 0.0
    up = points(n, (0, 0, 1))
    every = scene.sample(p, up, u)
    some = np.flatnonzero(rng.random(n) < 0.2)
    part = scene.sample(p[:, some].copy(), up[:, some].copy(), u[:, some].copy())
    for a, b in zip((*every[:6], every.place), (*part[:6], part.place), strict=True):
        np.testing.assert_array_equal(a[..., some], b)


def gathered(scene, o, d, t, camera):
    """What each ray gathers in all: number of lamps, radiance, Σ pdf."""
    found = np.zeros((3, o.shape[1]))
    for lanes, radiance, pdf, _ in scene.intersect(o, d, t, camera):
        assert len(np.unique(lanes)) == len(lanes)
        found[:, lanes] += np.stack([np.ones(len(lanes)), radiance[0], pdf])
    return found


def ceiling(n=6):
    """Area lamps edge to edge in one plane, and each of them once more in the very same place."""
    tile = {"shape": "RECTANGLE", "size": (1.0, 1.0)}
    return [lamp("AREA", placed(x - n / 2, y - n / 2, 2.0), **tile) for x in range(n) for y in range(n)] * 2


CROWDS = {
    "spheres that the camera sees": scattered(150, radius=0.15, visibility=63),
    "every sort, many of each": [*SIZED.values()] * 3 + scattered(30, radius=0.3),
    "tiles and their doubles": ceiling(),
    "soft": scattered(60, radius=0.2, soft_falloff=True),
}


FEW = {
    **{name: [lamp] for name, lamp in SIZED.items() if lamp.kind != "SUN"},
    "several sorts, suns and delta lamps among them": [*SIZED.values()][:13] + [*DELTA.values()],
    "far from the origin": scattered(8, radius=0.3, seed=2) + [lamp("POINT", placed(4e3), radius=2.0)],
    "seen by the camera, or not": scattered(6, radius=0.4) + scattered(6, seed=1, radius=0.4, visibility=63),
    "over each other": [lamp("AREA", placed(), shape="DISK", size=(1.0, 1.0))] * 5,
}


@pytest.mark.parametrize("name", FEW)
def test_few_lamps_are_met_as_without_the_balls_around_them(name):
    """To the bit, by rays from everywhere that are aimed at their very edges, past them or anywhere."""
    few, alone = lights(*FEW[name]), lights(*FEW[name])
    assert few._crowd is not None
    alone._crowd = None
    rng, n = np.random.default_rng(7), 30_000
    o = rng.uniform((-3, -3, 0), (3, 3, 3), (n, 3))
    centre = np.array([lamp.matrix[:3, 3] for lamp in FEW[name]])[rng.integers(len(FEW[name]), size=n)]
    off = rng.normal(size=(n, 3))
    off *= (rng.choice([1e-4, 0.1, 0.3, 0.4, 0.7, 1.2, 1.9], n) / np.sqrt((off**2).sum(axis=1)))[:, None]
    d = np.where(rng.random(n)[:, None] < 0.8, centre + off - o, rng.normal(size=(n, 3)))
    d /= np.sqrt((d**2).sum(axis=1, keepdims=True))
    t = np.where(rng.random(n) < 0.3, rng.exponential(2.0, n), 1e30).astype(np.float32)
    t[:50] = -1.0
    rays = [np.ascontiguousarray(x.T, np.float32) for x in (o, d)]
    camera = rng.random(n) < 0.3
    got, want = gathered(few, *rays, t, camera), gathered(alone, *rays, t, camera)
    assert want[0].sum() > 100
    np.testing.assert_array_equal(got, want)


@pytest.mark.parametrize("name", CROWDS)
def test_a_crowd_of_lamps_is_met_as_one_by_one(name):
    """Rays from outside, from inside of lamps, and short ones gather the same lamps, radiance and density."""
    crowd, alone = lights(*CROWDS[name], surfaces=surfaces()), lights(*CROWDS[name])
    assert crowd._crowd is not None
    rng, n = np.random.default_rng(5), 10_000
    o = rng.uniform((-3, -3, 0), (3, 3, 3), (n, 3)).T.astype(np.float32).copy()
    d = rng.normal(size=(3, n))
    d = (d / np.sqrt((d**2).sum(axis=0))).astype(np.float32)
    t = np.where(rng.random(n) < 0.5, rng.exponential(1.0, n), 1e30).astype(np.float32)
    t[:50] = -1.0
    camera = rng.random(n) < 0.3
    got, want = gathered(crowd, o, d, t, camera), gathered(alone, o, d, t, camera)
    assert want[0].sum() > 500
    assert (want[0] > 1).any()
    np.testing.assert_array_equal(got[0], want[0])
    np.testing.assert_allclose(got[1:], want[1:], rtol=1e-5, atol=1e-9)
