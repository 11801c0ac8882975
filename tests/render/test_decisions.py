"""Target error and adaptive sampling: where they end, that nothing changes a bit, and no bias."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support import scenes as make
from support.rooms import GLASS, ROUGH, SOFT_LAMP, room

from pt_engine.render.adaptive import LOOKS, RING, looks, wanted_samples
from pt_engine.render.decisions import decisions, lies_in, quarter_error, quarters
from pt_engine.render.film import Film
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare


@cache
def scene(name: str = "rough"):
    sky = make.world((0.3, 0.4, 0.6))
    things = {"glass": (GLASS,), "matte": (make.diffuse(0.5), SOFT_LAMP), "rough": (ROUGH, SOFT_LAMP, sky)}
    return prepare(room(*things[name]))


def rendered(size=20, name="rough", **how):
    width, height = size if isinstance(size, tuple) else (size, size)
    return render(scene(name), RenderSettings(width, height, **{"threads": 1, **how}))


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


def test_each_quarter_ends_where_the_others_say():
    """At n samples that are no fewer than the mean of what they say, m (E/target)², each at m ≤ n samples."""
    target = 0.06
    how = {"samples": 0, "target_error": target, "sampler": "independent"}
    result = rendered(**how)
    assert result.stopped_by == "target"
    counts = result.film.counts()
    ends = {(y, x): int(counts[y, x]) for y, x in RING}
    settings = RenderSettings(20, 20, **how)

    def says(quarter, known):
        error = quarter_error(rendered(samples=known, sampler="independent").film, settings, quarter)
        return known * (error / target) ** 2

    for (y, x), end in ends.items():
        assert (counts[y::2, x::2] == end).all()
        others = [other for other in RING if other != (y, x)]
        needed = np.mean([says(other, min(ends[other], end)) for other in others])
        assert needed <= end
        if all(ends[other] < end for other in others):
            assert end == np.ceil(needed)


@pytest.mark.parametrize("exponent", [1.0, 1.25, 1.5])
def test_a_target_is_not_overshot_where_the_error_falls_faster(exponent, monkeypatch):
    """relMSE = n^−a is at E² after E^(−2/a) samples, whether or not a first look from afar says so."""
    done, target = 0, 0.03
    monkeypatch.setattr("pt_engine.render.decisions.quarter_error", lambda *_: done ** (-exponent / 2))
    film = Film(8, 8)
    monkeypatch.setattr(film, "counts", lambda: np.full((8, 8), done, np.uint32))
    settings = RenderSettings(8, 8, samples=0, target_error=target, min_samples=4)
    decide = decisions(film, settings, np.arange(64, dtype=np.int32))
    while (step := decide(done)).samples:
        done += step.samples
    needed = target ** (-2 / exponent)
    assert needed <= done <= 1.05 * needed + 1


def test_noise_of_most_pixels_ends_the_render():
    result = rendered(samples=4096, target_error=0.25, target_percentile=80.0)
    assert result.stopped_by == "target"
    image = result.image()[..., :3]
    relative = result.film.variance_of_mean() / (image**2 + 0.01 * image.mean() ** 2)
    assert np.sqrt(np.percentile(relative.mean(axis=-1), 80)) < 0.3


def test_samples_and_least_samples_hold():
    """A target that is out of reach ends at the samples; one that is reached at once, at the least."""
    assert rendered(samples=20, target_error=1e-6).stopped_by == "samples"
    assert (rendered(samples=20, target_error=1e-6).film.counts() == 20).all()
    easy = rendered(samples=64, target_error=9.0, min_samples=10)
    assert (easy.film.counts() == 10).all()


@pytest.mark.parametrize("size", [(1, 1), (9, 1), (1, 9), (3, 2)])
def test_every_pixel_has_a_witness_and_ends(size):
    """However thin the image: a single row has two quarters, a single pixel has but itself."""
    film = rendered(size, samples=0, target_error=0.5).film
    assert sum(lies_in(q, np.arange(film.pixels), film.width).sum() for q in quarters(film)) == film.pixels


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


def sampled(radiance, size, **how):
    """The film of an image whose samples `radiance` (3, n, pixels) are known before, taken as decided."""
    settings = RenderSettings(size, size, **{"threads": 1, "sampler": "independent", **how})
    film = Film(size, size, correlated=settings.sampler == "sobol")
    pixels, done = np.arange(size * size, dtype=np.int32), 0
    decide = decisions(film, settings, pixels)
    while done < settings.samples:
        more, pixels = decide(done)
        more = min(more, settings.samples - done)
        if more == 0 or pixels.size == 0:
            break
        chosen = np.ascontiguousarray(radiance[:, done : done + more][:, :, pixels])
        film.add(pixels, done, more, chosen.reshape(3, -1))
        done += more
    return film


def sparkling(rng, size, samples, rare=0.05):
    """Radiance of an exponential distribution with mean 1, and rarely 20 times as much."""
    radiance = rng.exponential(1.0, (samples, size * size))
    radiance *= np.where(rng.random(radiance.shape) < rare, 20.0, 1.0)
    return np.broadcast_to(radiance.astype(np.float32), (3, *radiance.shape))


@pytest.mark.parametrize("sampler", ["sobol", "independent"])
def test_a_pixels_own_samples_never_decide_about_it(sampler):
    """Whatever they are, it gets as many, though others then get more: after all looks, not only one."""
    rng, size = np.random.default_rng(5), 9
    how = {"samples": 64, "adaptive": True, "min_samples": 4, "sampler": sampler}
    samples = sparkling(rng, size, 64)
    counts = sampled(samples, size, **how).counts().reshape(-1)
    assert len(np.unique(counts)) > 3
    for pixel in (0, 1, 9, 40):
        other = samples.copy()
        other[:, :, pixel] = 100.0 * rng.exponential(1.0, 64)
        changed = sampled(other, size, **how).counts().reshape(-1)
        assert changed[pixel] == counts[pixel]
        assert (changed != counts).any()


@pytest.mark.parametrize("percentile", [0.0, 80.0])
def test_a_quarters_own_samples_do_not_decide_about_it(percentile):
    """However much noisier those that end first become, they get as many, and only others get more."""
    size = 8
    how = {"samples": 96, "min_samples": 4, "target_error": 0.4, "target_percentile": percentile}
    samples = sparkling(np.random.default_rng(7), size, 96)
    counts = sampled(samples, size, **how).counts()
    assert len(np.unique(counts)) > 1
    for y, x in [quarter for quarter in RING if counts[quarter] == counts.min()]:
        other = samples.reshape(3, 96, size, size).copy()
        other[:, :, y::2, x::2] = np.exp(
            3 * np.random.default_rng(8).standard_normal((96, size // 2, size // 2))
        )
        changed = sampled(other.reshape(samples.shape), size, **how).counts()
        assert changed[y, x] == counts[y, x]
        assert (changed > counts).any()


@pytest.mark.slow
def test_a_target_has_no_bias():
    """300 images of 4 × 4 pixels against the same with all their samples: within 3.5 standard errors.

    Images that stop by what all their pixels tell are 2 % too dark: those with a bright sample go on.
    """
    rng = np.random.default_rng(3)
    all_samples = [sparkling(rng, 4, 48) for _ in range(300)]
    films = [sampled(x, 4, samples=48, min_samples=4, target_error=0.4) for x in all_samples]
    assert np.std([film.counts().mean() for film in films]) > 1  # it does decide
    difference = np.array(
        [f.mean() - x.mean(dtype=np.float64) for f, x in zip(films, all_samples, strict=True)]
    )
    assert abs(difference.mean()) < 3.5 * difference.std(ddof=1) / np.sqrt(difference.size)


@pytest.mark.slow
def test_adaptive_sampling_of_rare_bright_samples_has_no_bias():
    """Mean of 100 images of 4 × 4 pixels with closed-form mean 1 + 19/20: within 4 standard errors."""
    rng = np.random.default_rng(11)
    how = {"samples": 32, "adaptive": True, "min_samples": 4}
    films = [sampled(sparkling(rng, 4, 32), 4, **how) for _ in range(100)]
    assert np.std([film.counts().mean() for film in films]) > 1  # it does decide
    means = np.array([film.mean() for film in films])
    assert abs(means.mean() - 1.95) < 4 * means.std(ddof=1) / np.sqrt(means.size)


def test_three_looks_share_the_samples_evenly_in_the_logarithm():
    assert list(looks(RenderSettings(8, 8, samples=128, adaptive=True), 16)) == [16, 32, 64]
    assert len(RING) == LOOKS + 1  # else a chain of looks could come round


def test_a_quarter_without_witnesses_gets_all_samples():
    film = rendered(samples=16).film
    line = Film(20, 1)
    line.add(slice(0, 20), 0, 16, np.random.default_rng(0).random((3, 320), dtype=np.float32))
    settings = RenderSettings(20, 1, samples=64, adaptive=True)
    assert np.isinf(wanted_samples(line, settings)[1::2]).all()
    assert np.isfinite(wanted_samples(film, settings)).all()


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
