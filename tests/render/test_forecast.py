"""When a render will be good enough: laws that are known, films that are known, and a room."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.rooms import SOFT_LAMP, room

from pt_engine.render import film_noise, film_windows, forecast
from pt_engine.render.film import Film
from pt_engine.render.film_error import ErrorSums
from pt_engine.render.film_windows import BELIEVED, FURTHER, LOG_FURTHER, OWN, Outlook, of_windows, outlook
from pt_engine.render.forecast import BETWEEN, GOES_ON
from pt_engine.render.progressive import Progress, render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare

SIZE, FILMS, EARLY, LATE = 24, 60, 16, 160
DRAWS = {
    "gaussian": lambda rng, shape: rng.normal(1.0, 0.8, shape),
    "exponential": lambda rng, shape: rng.exponential(1.0, shape),
    "rare bright": lambda rng, shape: 0.05 + np.where(rng.random(shape) < 0.03, 30.0, 0.0),
}


def looked_at(monkeypatch, tells, samples, settings):
    """A progress that has met such errors: `tells` gives a film's outlook at n samples."""
    film = Film(8, 8, correlated=True)
    film._count += np.uint32(3)  # between powers of two
    progress = Progress(film, settings, 0.0)
    monkeypatch.setattr(Progress, "elapsed", property(lambda p: p.camera_samples * 0.01))
    monkeypatch.setattr(forecast, "outlook", lambda *_, **how: tells(progress.camera_samples / film.pixels))
    for n in samples:
        progress.camera_samples = n * film.pixels
        progress.forecast.look(progress)
    return progress


def law(n, slope, falls=0.0, samples=1.0):
    """n^−a, and by so much more at 9 times so many samples: in the logarithm as 1/n."""
    cleared = (1 - samples / n) / (1 - 1 / FURTHER)
    return n**-slope * np.exp(-falls * cleared)


@pytest.mark.parametrize("falls", [0.0, 1.0])
@pytest.mark.parametrize("slope", [1.0, 1.1])
@pytest.mark.parametrize("target", [0.1, 0.01])
def test_errors_that_fall_as_a_power_are_foretold_exactly(slope, target, falls, monkeypatch):
    """relMSE = n^−a, steeper while rare samples are told from light: samples, seconds, interval, end."""
    stratified = 1 - np.sqrt((slope - 1) / GOES_ON)
    start, end = 32, 1000

    def tells(n):
        relmse = law(n, slope, falls, start)
        told = {"relmse": relmse, "relmse_ci95": (relmse / 1.3, relmse * 1.3), "stratified": stratified}
        return Outlook(told, falls, (0.0, 0.0))

    settings = RenderSettings(8, 8, samples=end, target_error=target, sampler="sobol")
    progress = looked_at(monkeypatch, tells, (8, 16, start), settings)
    latest = progress.forecast.latest
    assert latest.from_samples == start
    assert law(latest.samples, slope, falls, start) == pytest.approx(target**2)
    assert latest.error_at_end**2 == pytest.approx(law(end, slope, falls, start))
    assert latest.seconds == pytest.approx(latest.samples * 64 * 0.01)
    width = np.log(1.3) / slope  # and some for the exponent
    further = 0.15 * np.log(latest.samples / start) + 0.02
    assert width < np.log(latest.samples_ci95[1] / latest.samples) < width + further
    assert progress.forecast.early(80).from_samples == 8
    assert progress.forecast.early(81).from_samples == 16


def test_doubt_that_windows_settle_leaves_the_interval_narrower(monkeypatch):
    """Half of log `fireflies` widens it as squares add; at nine times the samples, what windows say of it."""

    def width(target):
        told = {"relmse": 0.04, "relmse_ci95": (0.04 / np.exp(0.5), 0.04 * np.exp(0.5)), "stratified": 1.0}
        settings = RenderSettings(8, 8, samples=0, target_error=target, sampler="independent")
        progress = looked_at(monkeypatch, lambda n: Outlook(told, 0.0, (0.4, 0.0)), (16,), settings)
        latest = progress.forecast.latest
        return np.log(latest.samples_ci95[1] / latest.samples)

    assert width(0.199) == pytest.approx(0.5, rel=0.01)  # √(0.3² + 0.4²): 0.3 is the noise's
    assert width(0.05) == pytest.approx(0.3, rel=0.02)


def test_sobol_points_that_lie_best_are_not_taken_for_the_rule(monkeypatch):
    """A look at 32 samples foretells what it takes between powers of two: ⅕ (1 − s)² more of relMSE."""
    told = {"relmse": 0.01, "relmse_ci95": (0.009, 0.011), "stratified": 0.5}
    found = []
    for count in (32, 33):
        settings = RenderSettings(8, 8, samples=0, target_error=0.05, sampler="sobol")
        with monkeypatch.context() as patched:
            patched.setattr(Film, "counts", lambda film, n=count: np.full((8, 8), n, np.uint32))
            progress = looked_at(patched, lambda n: Outlook(told, 0.0, (0.0, 0.0)), (32,), settings)
        found.append(progress.forecast.latest.samples)
    exponent = 1 + GOES_ON * 0.25
    assert np.log(found[0] / found[1]) == pytest.approx(BETWEEN * 0.25 / exponent)


def films(kind, samples=LATE, size=SIZE):
    """Samples of grey pixels of mean 1: (samples, size²), film by film."""
    rng = np.random.default_rng(5)
    for _ in range(FILMS):
        yield DRAWS[kind](rng, (samples, size * size)).astype(np.float32)


def film_of(values, size=SIZE):
    film = Film(size, size)
    film.add(slice(0, size * size), 0, len(values), np.broadcast_to(values.reshape(-1), (3, values.size)))
    return film


@pytest.mark.parametrize(("kind", "share"), [("gaussian", 0.9), ("exponential", 0.9), ("rare bright", 0.7)])
def test_a_tenth_of_the_samples_foretells_known_noise(kind, share, monkeypatch):
    """What 16 samples foretell of the error that 160 tell: so many within 20 %, intervals hold.

    Of 60 intervals of 95 %, 51 or fewer hold by chance once in 700. Where one sample in 33 brings nearly
    all the light, 16 samples of a pixel often have none, and the pixels around must tell.
    """
    held, found = 0, []
    for values in films(kind):
        target = film_of(values).error()["relmse"] ** 0.5
        early = film_of(values[:EARLY])
        settings = RenderSettings(SIZE, SIZE, samples=0, target_error=target, sampler="independent")
        progress = Progress(early, settings, 0.0, camera_samples=EARLY * early.pixels)
        monkeypatch.setattr(Progress, "elapsed", property(lambda p: 1.0))
        progress.forecast.look(progress)
        latest = progress.forecast.latest
        found.append(latest.samples / LATE)
        held += latest.samples_ci95[0] <= LATE <= latest.samples_ci95[1]
    assert held > 51
    assert np.mean(np.abs(np.array(found) - 1) < 0.2) >= share


def told_further(film):
    """The logarithm of n E² as windows tell it, over that which pixels tell."""
    moments = film_noise.moments_of(film.sums(slice(0, film.pixels)))
    pixels, windows = ErrorSums(film.mean()), ErrorSums(film.mean())
    by_mean, by_median = film_noise.levels(moments, film.width)
    pixels.add(moments._replace(level=by_mean, level_by_median=by_median))
    for part in of_windows(moments, film.width):
        windows.add(part)
    return np.log(windows.result()["relmse"] / pixels.result()["relmse"]) + LOG_FURTHER


def test_rare_samples_make_a_film_tell_too_much_and_windows_know_it():
    """One sample in 33 brings the light: at 16 samples n E² is at least half too large, windows' is right."""
    told, further = [], []
    for values in films("rare bright"):
        early = outlook(film_of(values[:EARLY]), even=True)
        late = np.log(film_of(values).error()["relmse"] * LATE)
        told.append(np.log(early.error["relmse"] * EARLY) - late)
        further.append(told[-1] - early.falls)
    assert np.median(told) > np.log(1.5)
    assert abs(np.median(further)) < 0.1


def test_pixels_that_are_ahead_within_a_pass_change_nothing():
    """The upper half, twice as noisy, has 32 samples and the lower 16: n E² is as with 24 everywhere."""
    rng = np.random.default_rng(2)
    scale = np.where(np.arange(SIZE * SIZE) < SIZE * SIZE // 2, 0.1, 0.2)
    values = (1 + scale * rng.standard_normal((32, SIZE * SIZE))).astype(np.float32)
    film = film_of(values[:16])
    upper = np.arange(SIZE * SIZE // 2, SIZE * SIZE)
    later = np.broadcast_to(values[16:, upper].reshape(-1), (3, 16 * upper.size))
    film.add(upper, 16, 16, later)
    expected = np.mean(scale**2) / 1.01
    assert 24 * outlook(film, even=True).error["relmse"] == pytest.approx(expected, rel=0.05)
    assert 24 * outlook(film, even=False).error["relmse"] < 0.9 * expected


def test_windows_are_means_of_the_pixels_around_each():
    """Against loops: 13 × 8 pixels, each once, fewer around those at the rim; half v is the pixel's own."""
    rng = np.random.default_rng(1)
    film = Film(8, 13)
    film.add(slice(0, 104), 0, 5, rng.exponential(1.0, (3, 520)).astype(np.float32))
    moments = film.moments(slice(0, 104))
    mean, variance = (x.reshape(3, 13, 8) for x in (moments.mean, moments.variance))
    seen = np.zeros((13, 8), int)
    corners = [(y, x) for y in range(3) for x in range(3)]
    for (first, left), part in zip(corners, of_windows(moments, 8), strict=True):
        places = [(y, x) for y in range(first, 13, 3) for x in range(left, 8, 3)]
        for number, (y, x) in enumerate(places):
            here = np.s_[:, max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2]
            around = variance[here].mean((1, 2))
            expected = OWN * variance[:, y, x] + (1 - OWN) * around
            np.testing.assert_allclose(part.mean[:, number], mean[here].mean((1, 2)))
            np.testing.assert_allclose(part.variance[:, number], expected / FURTHER)
            np.testing.assert_allclose(part.spread[number], around.mean() / mean[here][0].size)
            seen[y, x] += 1
        assert part.mean.shape == (3, len(places))
    assert np.all(seen == 1)


@pytest.mark.parametrize("power", [2.0, 3.0])
def test_noise_that_grows_with_light_inside_of_windows_is_foretold_half_as_wrongly(power, monkeypatch):
    """R rises sixfold and falls again within six pixels, v ~ Rᵏ, no sample is rare: n E² stays as it is.

    A window's mean variance over its level squared, which is what blocks of 3 × 3 pixels tell, says 0.3 and
    0.4 too much in the logarithm.
    """
    across = 1 + 5 * np.abs(np.arange(72) / 6 % 1 * 2 - 1)
    level = np.outer(across, across).reshape(-1)
    noise = 0.2 * np.random.default_rng(3).standard_normal((EARLY, level.size))
    film = film_of((level + noise * level ** (power / 2)).astype(np.float32), 72)
    found = told_further(film)
    monkeypatch.setattr(film_windows, "OWN", 0.0)
    by_means = told_further(film)
    assert by_means > 0.25
    assert abs(found) < 0.6 * by_means


def test_bands_of_rows_change_little_in_an_outlook(monkeypatch):
    """Worked on seven rows at a time: windows at a band's edge have fewer pixels, and that is all."""
    for values, _ in zip(films("rare bright"), range(3), strict=False):
        film = film_of(values[:EARLY])
        with monkeypatch.context() as patched:
            whole = outlook(film, even=True)
            patched.setattr(film_noise, "BAND", 7 * SIZE)
            parts = outlook(film, even=True)
        assert parts.error["relmse"] == pytest.approx(whole.error["relmse"], rel=1e-12)
        assert parts.falls == pytest.approx(whole.falls, abs=0.2)


@pytest.mark.parametrize("size", [(1, 1), (2, 40), (3, 3)])
def test_small_films_have_an_outlook(size):
    """Fewer pixels than a window has; where there is but one, n E² stays as it is."""
    film = Film(*size)
    rng = np.random.default_rng(0)
    film.add(slice(0, film.pixels), 0, 8, rng.exponential(1.0, (3, 8 * film.pixels)).astype(np.float32))
    found = outlook(film, even=True)
    assert found.error["relmse"] > 0
    assert 0 <= found.falls <= BELIEVED * found.doubt[0] * (1 + 1e-12)
    assert film.pixels > 1 or found.falls == 0
    assert outlook(Film(*size), even=True) is None


def test_what_a_tenth_of_a_render_foretells():
    """Where no sample is rare, independent samples to a target are foretold to 20 %: relMSE falls as 1/n."""
    scene = prepare(room(make.diffuse(0.5), SOFT_LAMP))
    settings = RenderSettings(24, 24, samples=0, target_error=0.05, sampler="independent", threads=1)
    result = render(scene, settings)
    taken = result.film.counts().mean()
    early = result.progress.forecast.early(taken)
    assert 0.1 * taken <= early.from_samples < 0.25 * taken
    assert early.samples == pytest.approx(taken, rel=0.2)
    assert early.seconds_ci95[0] < early.seconds < early.seconds_ci95[1]
