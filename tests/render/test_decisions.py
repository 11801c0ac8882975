"""Target error, adaptive sampling and forecasts: where they end, that nothing changes a bit, and no bias."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support import scenes as make
from support.rooms import GLASS, ROUGH, SOFT_LAMP, room

from pt_engine.render.decisions import relative_error, wanted_samples
from pt_engine.render.film_noise import drawn_half
from pt_engine.render.forecast import Look, fitted_exponent
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare


@cache
def scene(name: str = "rough"):
    sky = make.world((0.3, 0.4, 0.6))
    return prepare(room(GLASS) if name == "glass" else room(ROUGH, SOFT_LAMP, sky))


def rendered(size=20, name="rough", **how):
    return render(scene(name), RenderSettings(size, size, **{"threads": 1, **how}))


RULES = {
    "image": {"target_error": 0.2},
    "pixels": {"target_error": 0.3, "target_percentile": 90.0},
    "adaptive": {"samples": 64, "adaptive": True},
    "adaptive to a target": {"target_error": 0.2, "adaptive": True},
}


@pytest.mark.parametrize("name", RULES)
@pytest.mark.parametrize("sampler", ["sobol", "independent"])
def test_decisions_do_not_depend_on_threads_or_tiles(name, sampler):
    """Which samples are taken follows from the film: the same bits from one large unit and many small."""
    how = {"samples": 256, "sampler": sampler, **RULES[name]}
    alone = rendered(**how)
    other = rendered(threads=2, lanes=997, **how)
    np.testing.assert_array_equal(other.film.counts(), alone.film.counts())
    np.testing.assert_array_equal(other.image(), alone.image())
    assert other.error() == alone.error()
    assert other.stopped_by == alone.stopped_by


def test_each_half_of_the_pixels_ends_where_the_other_says():
    """The first is finished when the other is below the target, which then goes on to n (E/target)²."""
    target = 0.06
    result = rendered(samples=0, target_error=target, sampler="independent")
    assert result.stopped_by == "target"
    counts = result.film.counts().reshape(-1)
    half = drawn_half(0, counts.size)
    ends = [int(counts[half == k][0]) for k in (0, 1)]
    np.testing.assert_array_equal(counts, np.take(ends, half))
    first = int(np.argmin(ends))
    then = rendered(samples=min(ends), sampler="independent").film
    assert relative_error(then, half=1 - first) <= target
    asked = min(ends) * (relative_error(then, half=first) / target) ** 2
    assert max(ends) == max(min(ends), np.ceil(asked))
    before = rendered(samples=max(16, min(ends) - 8), sampler="independent").film
    assert min(relative_error(before, half=k) for k in (0, 1)) > target


def test_noise_of_most_pixels_ends_the_render():
    result = rendered(samples=4096, target_error=0.25, target_percentile=80.0)
    assert result.stopped_by == "target"
    assert relative_error(result.film, 80.0) < 0.3


def test_samples_and_least_samples_hold():
    """A target that is out of reach ends at the samples; one that is reached at once, at the least."""
    assert rendered(samples=20, target_error=1e-6).stopped_by == "samples"
    assert (rendered(samples=20, target_error=1e-6).film.counts() == 20).all()
    easy = rendered(samples=64, target_error=9.0, min_samples=10)
    assert (easy.film.counts() == 10).all()


def test_halves_of_the_pixels_share_none():
    first, second = (np.flatnonzero(drawn_half(100, 5000) == half) for half in (0, 1))
    assert first.size + second.size == 5000
    assert abs(first.size - 2500) < 5 * np.sqrt(1250)
    np.testing.assert_array_equal(drawn_half(100, 5000)[40:], drawn_half(140, 4960))


def test_adaptive_films_are_parts_of_uniform_ones():
    """Each pixel has the first so many samples; films of disjoint ranges merge, whatever each decided."""
    first = rendered(samples=48, adaptive=True)
    counts = first.film.counts()
    assert counts.min() < counts.max() <= 48
    for n in np.unique(counts)[:3]:
        whole = rendered(samples=int(n)).image()
        np.testing.assert_array_equal(first.image()[counts == n], whole[counts == n])
    second = rendered(samples=48, first_sample=48, adaptive=True)
    total = counts + second.film.counts()
    second.film.merge(first.film)
    np.testing.assert_array_equal(second.film.counts(), total)


def test_a_pixels_own_samples_do_not_decide_about_it():
    """Another sample in one pixel changes what its surroundings get, not what it gets itself."""
    film = rendered(samples=16).film
    before = wanted_samples(film, RenderSettings(20, 20, target_error=0.1, target_percentile=95.0))
    film.add(np.array([12 * 20 + 7]), 16, 1, np.full((3, 1), 50.0, np.float32))
    # the image's mean, to which all errors are relative, moves a little: by 50 / (17 · 400)
    after = wanted_samples(film, RenderSettings(20, 20, target_error=0.1, target_percentile=95.0))
    assert after[12 * 20 + 7] == pytest.approx(before[12 * 20 + 7], rel=0.05)
    assert after[12 * 20 + 8] > 1.5 * before[12 * 20 + 8]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["image", "adaptive"])
def test_stopping_and_adapting_have_no_bias(name):
    """Mean of 100 short renders against 4,096 samples: within 4.5 standard errors (1,000 of them: bench)."""
    how = {**RULES[name], "min_samples": 4, "samples": 32, "max_depth": 2, "sampler": "independent"}
    if name == "image":
        how["target_error"] = 0.25
    results = [rendered(6, seed=k, **how) for k in range(100)]
    assert np.std([result.film.counts().mean() for result in results]) > 0  # it does decide
    images = np.array([result.image()[..., :3].mean() for result in results])
    truth = rendered(6, samples=1 << 12, max_depth=2, sampler="independent", seed=10**6)
    error = np.sqrt(images.var(ddof=1) / images.size + truth.film.variance_of_mean().mean() / 108)
    assert abs(images.mean() - truth.image()[..., :3].mean()) < 4.5 * error


@pytest.mark.parametrize(("slope", "noise"), [(1.0, 0.01), (1.4, 0.01), (1.3, 5.0)])
def test_the_exponent_is_learnt_as_far_as_the_noise_allows(slope, noise):
    looks = [Look(n, n * 0.1, n**-slope, noise) for n in (4.0, 8.0, 16.0, 32.0)]
    found, spread = fitted_exponent(looks, 1.15, 0.12)
    if noise < 1:
        assert found == pytest.approx(slope, abs=0.01)
        assert spread < 0.02
    else:
        assert found == pytest.approx(1.15, abs=0.01)
        assert spread == pytest.approx(0.12, rel=0.05)


def test_what_a_tenth_of_a_render_foretells():
    """Independent samples: relMSE falls as 1/n, so the samples to a target are foretold to 30 %."""
    result = rendered(24, samples=0, target_error=0.04, sampler="independent")
    early = result.progress.forecast.early
    assert early is not None
    assert early.from_samples < 0.25 * result.progress.samples
    assert early.samples == pytest.approx(result.progress.samples, rel=0.3)
    assert early.seconds_ci95[0] < early.seconds < early.seconds_ci95[1]
