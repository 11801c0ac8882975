"""The film: exact sums in any order, honest errors, files that come back."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pt_engine.core.samplers import Sobol
from pt_engine.render import exact_sum
from pt_engine.render.film import Film, overlapping
from pt_engine.render.film_file import load_film, save_film
from pt_engine.render.schedule import morton_order


def same_bits(a, b):
    """Both films hold the very same bits, and so give the same images and errors."""
    mine, theirs = a.state(), b.state()
    assert mine.keys() == theirs.keys()
    for name in mine:
        np.testing.assert_array_equal(
            np.ascontiguousarray(mine[name]).view(np.uint8), np.ascontiguousarray(theirs[name]).view(np.uint8)
        )
    np.testing.assert_array_equal(a.image(), b.image())
    assert a.error() == b.error()
    np.testing.assert_array_equal(a.variance_of_mean(), b.variance_of_mean())
    assert (a.ranges, a.dropped) == (b.ranges, b.dropped)


def radiance(rng, samples, pixels, spread=3.0):
    """(3, samples, pixels) over many orders of magnitude, some zeros, some negative."""
    values = np.exp(rng.normal(0, spread, (3, samples, pixels))) * rng.integers(-1, 4, (3, samples, pixels))
    return values.astype(np.float32)


def filled(width, height, values, alpha, first=0, **keys):
    film = Film(width, height, **keys)
    n = values.shape[1]
    film.add(slice(None), first, n, values.reshape(3, -1), None if alpha is None else alpha.reshape(-1))
    return film


KINDS = st.sampled_from([{}, {"correlated": True}, {"halves": True}])


@given(st.integers(0, 2**32 - 1), st.integers(1, 12), st.booleans(), st.booleans(), KINDS)
@settings(max_examples=60, deadline=None)
def test_any_order_chunking_and_merge_gives_the_same_bits(seed, samples, with_alpha, ordered, kind):
    """One add of everything, against random pieces in random order on three films merged in random order."""
    rng = np.random.default_rng(seed)
    w, h = rng.integers(1, 9, 2)
    values = radiance(rng, samples, w * h)
    values[0, 0, 0] = rng.choice([0, np.nan, np.inf, 1e6, -0.0])
    alpha = rng.random((samples, w * h), np.float32) if with_alpha else None
    whole = filled(w, h, values, alpha, **kind)

    order = morton_order(w, h) if ordered else None
    films = [Film(w, h, order=order if rng.random() < 0.7 else None, **kind) for _ in range(3)]
    owner = np.sort(rng.integers(0, 3, samples))
    parts = np.array_split(order if ordered else rng.permutation(w * h), rng.integers(1, 4))
    pieces = [(s, p) for s in range(samples) for p in parts if len(p)]
    for i in rng.permutation(len(pieces)):
        s, p = pieces[i]
        films[owner[s]].add(p, s, 1, values[:, s, p], None if alpha is None else alpha[s, p])
    a, b, c = rng.permutation(3)
    films[a].merge(films[b])
    films[a].merge(films[c])
    same_bits(films[a], whole)


@given(st.lists(st.floats(-(2.0**40), 2.0**40, width=32), min_size=1, max_size=40))
@settings(max_examples=200, deadline=None)
def test_sums_are_the_exact_sums_of_rounded_terms(terms):
    """Against rational arithmetic: Σ round(x, 2⁻³⁶), with 0 ≤ low < 16 and high a multiple of 16."""
    high, low = np.zeros(1), np.zeros(1)
    x = np.array(terms, np.float64)[:, None]
    exact_sum.add(high, low, slice(None), x.copy(), float(np.abs(x).max()))
    expected = sum(Fraction(round(Fraction(t) * 2**36), 2**36) for t in terms)
    assert Fraction(high[0]) + Fraction(low[0]) == expected
    high, low = exact_sum.canonical(high, low)
    assert Fraction(high[0]) + Fraction(low[0]) == expected
    assert 0 <= low[0] < 16
    assert high[0] % 16 == 0


@pytest.mark.parametrize("value", [0.0, 2.0**-36, 16 - 2.0**-36, 16.0, 24.0, -(2.0**-36), -8.0, -16.0, 4e4])
def test_canonical_form_is_unique(value):
    """However a sum is split, it comes out as the same pair, also at the ties of rounding."""
    for moved in (-64.0, -16.0, 0.0, 16.0, 4096.0):
        high, low = exact_sum.canonical(np.array([moved]), np.array([value - moved]))
        assert low[0] == value - 16 * np.floor(value / 16)
        assert high[0] + low[0] == value


def test_sums_are_carried_in_time():
    """A million terms near 0.3 in 30 calls: the low part would lose digits at 2¹⁷ = 131,072."""
    high, low = np.zeros(1), np.zeros(1)
    x = np.full((33_334, 1), 0.3)
    for _ in range(30):
        exact_sum.add(high, low, slice(None), x.copy(), 0.3)
    assert Fraction(high[0]) + Fraction(low[0]) == Fraction(round(Fraction(0.3) * 2**36), 2**36) * 33_334 * 30
    assert abs(low[0]) < 2**16


def test_many_large_terms_stay_exact():
    """10,000 terms of 15.999 in one call leave no room for a sloppy carry."""
    x = np.full((10_000, 2), 15.999)
    high, low = np.zeros(2), np.zeros(2)
    exact_sum.add(high, low, slice(None), x.copy(), 15.999)
    expected = Fraction(round(Fraction(15.999) * 2**36), 2**36) * 10_000
    assert Fraction(high[0]) + Fraction(low[0]) == expected


def test_image_is_the_mean():
    rng = np.random.default_rng(0)
    values = rng.random((3, 50, 12), np.float32)
    alpha = rng.random((50, 12), np.float32)
    film = filled(4, 3, values, alpha)
    image = film.image()
    assert image.shape == (3, 4, 4)
    assert image.dtype == np.float32
    np.testing.assert_allclose(image[..., :3].reshape(12, 3), values.mean(1, np.float64).T, rtol=2e-7)
    np.testing.assert_allclose(image[..., 3].ravel(), alpha.mean(0, np.float64), rtol=2e-7)
    expected = values.astype(np.float64).var(1, ddof=1).T / 50
    np.testing.assert_allclose(film.variance_of_mean().reshape(12, 3), expected, rtol=1e-6)
    assert (film.counts() == 50).all()


def test_empty_film_and_single_samples():
    film = Film(3, 2)
    assert not film.image().any()
    assert set(film.error().values()) == {None}
    film.add(np.array([1, 4]), 0, 1, np.ones((3, 2), np.float32))
    np.testing.assert_array_equal(film.image()[..., 3], [[0, 1, 0], [0, 1, 0]])
    assert film.error()["mse"] is None
    assert np.isnan(film.variance_of_mean()).all()


def test_alpha_that_comes_late_counts_from_the_start():
    """Samples without alpha have alpha 1."""
    film = Film(1, 1)
    film.add(slice(None), 0, 3, np.ones((3, 3), np.float32))
    film.add(slice(None), 3, 1, np.ones((3, 1), np.float32), np.zeros(1, np.float32))
    film.add(slice(None), 4, 1, np.ones((3, 1), np.float32))
    assert film.image()[0, 0, 3] == np.float32(0.8)


def test_bad_samples_are_dropped_counted_and_named():
    values = np.ones((3, 2, 3), np.float32)  # 2 samples of 3 pixels
    values[1, 0, 2] = np.nan
    values[2, 1, 0] = -np.inf
    values[0, 1, 1] = -2
    bad = (film := Film(3, 1)).add(slice(None), 0, 2, values.reshape(3, -1))
    np.testing.assert_array_equal(bad, [2, 3])
    assert film.dropped == 2
    np.testing.assert_array_equal(film.counts(), [[1, 2, 1]])
    np.testing.assert_array_equal(film.image()[0, :, 0], [1, -0.5, 1])
    assert np.isnan(values[1, 0, 2])  # the caller's array is left alone
    strict = Film(3, 1, reject_negative=True)
    np.testing.assert_array_equal(strict.add(slice(None), 0, 2, values.reshape(3, -1)), [2, 3, 4])
    alpha = np.array([1, 1, 1, 1, np.nan, 1], np.float32)
    np.testing.assert_array_equal(Film(3, 1).add(slice(None), 0, 2, values.reshape(3, -1), alpha), [2, 3, 4])


def test_huge_radiance_neither_warns_nor_spoils_the_others():
    """A mirrored sun of 1e12 W·m⁻²·sr⁻¹: its sum is exact, its square only as good as float64."""
    film = Film(2, 1)
    film.add(slice(None), 0, 2, np.array([[1e12, 1, 3e38, 1]] * 3, np.float32))
    np.testing.assert_allclose(film.image()[0, :, 0], [1.5e38, 1], rtol=1e-6)
    assert np.isfinite(film.variance_of_mean()).all()


def test_merge_refuses_what_does_not_belong_together():
    def film(first=0, **keys):
        given = {"width": 2, "height": 2, **keys}
        result = Film(**given)
        result.add(slice(None), first, 4, np.ones((3, 4 * result.pixels), np.float32))
        return result

    with pytest.raises(ValueError, match="2 × 2 and 4 × 1"):
        film().merge(film(4, width=4, height=1))
    with pytest.raises(ValueError, match="different renders"):
        film().merge(film(4, key="other"))
    with pytest.raises(ValueError, match="samples 3 to 3"):
        film().merge(film(3))
    one = film()
    one.merge(film(8))
    one.merge(film(4))
    assert one.ranges == ((0, 12),)


def test_overlapping_ranges():
    assert overlapping(((0, 4), (8, 4)), ((4, 4),)) is None
    assert overlapping(((0, 4), (8, 4)), ((3, 6),)) == (3, 1)
    assert overlapping(((8, 4),), ((0, 9),)) == (8, 1)


@pytest.mark.parametrize("with_alpha", [False, True])
@pytest.mark.parametrize("ordered", [False, True])
@pytest.mark.parametrize("kind", [{}, {"correlated": True}])
def test_file_brings_the_film_back(tmp_path, with_alpha, ordered, kind):
    rng = np.random.default_rng(1)
    alpha = rng.random((5, 35), np.float32) if with_alpha else None
    order = morton_order(7, 5) if ordered else None
    film = filled(7, 5, radiance(rng, 5, 35), alpha, first=3, key="scène", order=order, **kind)
    path = tmp_path / "a film"
    save_film(film, path)
    save_film(film, path)
    assert [p.name for p in tmp_path.iterdir()] == ["a film"]
    same_bits(load_film(path), film)
    assert load_film(path).key == "scène"


def test_files_that_are_no_films_are_refused(tmp_path):
    path = tmp_path / "film"
    path.write_bytes(b"hello")
    with pytest.raises(ValueError, match="not a film"):
        load_film(path)
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(ValueError, match="not a film"):
        load_film(tmp_path / "other.npz")
    np.savez(tmp_path / "pickle.npz", header=np.array([{"a": 1}], object))
    with pytest.raises(ValueError, match="not a film"):
        load_film(tmp_path / "pickle.npz")
    save_film(filled(2, 2, np.ones((3, 1, 4), np.float32), None), path)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match="not a film"):
        load_film(path)
    with pytest.raises(OSError, match="nowhere"):
        load_film(tmp_path / "nowhere")


def noisy(rng, n, sigma, mean):
    h, w = sigma.shape
    values = mean + sigma.reshape(-1) * rng.standard_exponential((3, n, h * w)) - sigma.reshape(-1)
    return filled(w, h, values.astype(np.float32), None)


@pytest.mark.parametrize(("size", "n"), [(48, 8), (7, 4)])
def test_error_is_unbiased_and_its_interval_covers(size, n):
    """Exponential noise of known σ(x, y): MSE = mean σ²/n, in the 95 % interval ≥ 90 % of 150 times."""
    y, x = np.mgrid[0:size, 0:size] / size
    sigma = 0.1 + 0.3 * x**2 + 0.1 * np.sin(9 * y) ** 2
    mse = float((sigma**2).mean() / n)
    relmse = float((sigma**2 / n / (1.0 + 0.01)).mean())
    rng = np.random.default_rng(5)
    errors = [noisy(rng, n, sigma, 1.0).error() for _ in range(150)]
    estimates = np.array([e["mse"] for e in errors])
    assert abs(estimates.mean() - mse) < 5 * estimates.std() / np.sqrt(len(errors))
    covered = np.mean([e["mse_ci95"][0] <= mse <= e["mse_ci95"][1] for e in errors])
    assert covered >= (0.90 if size > 8 else 0.75)  # 49 pixels: as χ², though the noise is not normal
    if size > 8:
        # R in the denominator is itself noisy, which is worth a few per cent here.
        assert abs(np.mean([e["relmse"] for e in errors]) / relmse - 1) < 0.15
        widths = [e["mse_ci95"][1] / e["mse_ci95"][0] for e in errors]
        assert np.median(widths) < 1.5


def test_fireflies_are_told_where_few_samples_carry_the_light():
    """Dark pixels that one sample in 80 lights up: light or noise? An even image leaves no doubt."""
    rng = np.random.default_rng(5)
    even = 0.02 + 0.02 * rng.random((16, 24 * 24))
    rare = np.where(rng.random(even.shape) < 1 / 80, 3.0, even)
    sparkling, level = (
        filled(24, 24, np.broadcast_to(x, (3, *x.shape)).astype(np.float32), None).error()
        for x in (rare, even)
    )
    assert level["fireflies"] < 1.05
    assert sparkling["fireflies"] > 1.5
    (low, high), told = sparkling["relmse_ci95"], sparkling["relmse"]
    assert high / told >= np.sqrt(sparkling["fireflies"])  # both answers lie in it
    assert high / told == pytest.approx(told / low)


def test_constant_image_has_no_error():
    film = filled(8, 8, np.full((3, 16, 64), 0.1, np.float32), None)
    assert film.error()["mse"] < 1e-14
    black = filled(8, 8, np.zeros((3, 16, 64), np.float32), None)
    assert black.error().pop("fireflies") == 1.0
    assert set(black.error().values()) == {0.0, (0.0, 0.0), 1.0}


def sobol_film(size, n, f, seed=2, **keys):
    """Each pixel integrates f(u, v) by n Sobol samples."""
    sampler, pixel = Sobol(seed), np.arange(size * size)
    u = sampler.uniforms(sampler.state(np.tile(pixel, n), np.repeat(np.arange(n), pixel.size)), 0, 2)
    film = Film(size, size, **keys)
    film.add(slice(None), 0, n, np.repeat(f(*u)[None], 3, axis=0).astype(np.float32))
    return film


def test_error_of_sobol_samples_is_their_own():
    """∫ x y = 1/4 in each pixel by 64 samples: the halves see what stratification gained, a factor of > 5."""
    film = sobol_film(48, 64, np.multiply, correlated=True)
    real = float(((film.image()[..., :3].astype(np.float64) - 0.25) ** 2).mean())
    low, high = film.error()["mse_ci95"]
    assert low < real < high
    assert high < 0.3 * sobol_film(48, 64, np.multiply).error()["mse"]
    z = (film.image()[..., 0] - 0.25) / film.standard_error()[..., 0]
    student = np.sqrt(49 / 47)  # as many differences around tell each standard error
    assert abs(z.std() / student - 1) < 0.05  # 2304 pixels: its own error is 1.5 %


def test_halves_are_the_even_and_the_odd_samples():
    rng = np.random.default_rng(4)
    values = rng.random((3, 9, 12), np.float32)
    for keys in ({"correlated": True}, {"halves": True}):
        film = filled(4, 3, values, None, first=3, **keys)
        for half in range(2):
            expected = values[:, 1 - half :: 2].mean(1, np.float64).T  # the first sample is number 3
            np.testing.assert_allclose(film.half(half).reshape(12, 3), expected, rtol=1e-6)
        np.testing.assert_array_equal(film.image(), filled(4, 3, values, None, first=3).image())
    with pytest.raises(ValueError, match="no halves"):
        filled(4, 3, values, None).half(0)


def test_memory_per_pixel():
    """At most 150 bytes, alpha and an order of its own included."""
    for keys in ({}, {"correlated": True}):
        film = Film(64, 64, order=morton_order(64, 64), **keys)
        film.add(morton_order(64, 64), 0, 1, np.ones((3, 4096), np.float32), np.ones(4096, np.float32))
        held = [x for x in vars(film).values() if isinstance(x, np.ndarray)]
        assert sum(x.nbytes for x in held) / 4096 <= 150
