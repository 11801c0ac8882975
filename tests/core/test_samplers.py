"""Samplers: pure functions of (seed, pixel, sample, dimension), and Sobol' points that are a net."""

import itertools
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2, chisquare, qmc

from pt_engine.core import sobol
from pt_engine.core.samplers import GROUP_BITS, GROUPS, MAX_SAMPLES, SAMPLERS, Independent, Sobol


def of_pixel(sampler, n, dimension, count, pixel=5, first=0):
    sample = np.arange(first, first + n)
    return sampler.uniforms(sampler.state(np.full(n, pixel), sample), dimension, count).astype(np.float64)


def test_direction_numbers_are_joe_and_kuo():
    """The unscrambled points equal scipy's, up to its order (Gray code)."""
    directions = sobol.direction_numbers()
    n, d = 64, len(directions)
    ours = np.stack([sobol.linear_table(row[:6]) for row in directions]) / 2.0**32
    theirs = qmc.Sobol(d, scramble=False).random(n).T
    i = np.arange(n)
    np.testing.assert_array_equal(ours[:, i ^ (i >> 1)], theirs)


def test_bit_reversal():
    x = np.random.default_rng(0).integers(0, 2**32, 1000, dtype=np.uint32)
    expected = [int(f"{v:032b}"[::-1], 2) for v in x]
    np.testing.assert_array_equal(sobol.reverse_bits(x), expected)


def test_owen_scramble_is_nested_and_a_bijection():
    """Points that share their first k digits still share k digits, and first differ where they did."""
    x = np.random.default_rng(0).integers(0, 2**32, (2, 20_000), dtype=np.uint32)
    x[1] = x[0] ^ (x[1] >> np.arange(20_000, dtype=np.uint32) % 32)
    y = sobol.owen_scramble(x, 0xDEADBEEF)
    first_difference = np.floor(np.log2(np.maximum(x[0] ^ x[1], 1)))
    np.testing.assert_array_equal(np.floor(np.log2(np.maximum(y[0] ^ y[1], 1))), first_difference)


@pytest.mark.parametrize("pixel", [0, 123_456])
@pytest.mark.parametrize("m", [4, 8, 12])
def test_first_two_dimensions_fill_every_elementary_interval(pixel, m):
    """A (0, m, 2)-net: each box 2⁻ᵃ × 2^(a−m) holds exactly one of 2ᵐ points; scramble and shift keep it.

    Even samples are one such sequence, odd ones another.
    """
    both = of_pixel(Sobol(9), 2 ** (m + 1), 0, 2, pixel, first=2 ** (m + 1) * 3)
    for half, a in itertools.product(range(2), range(m + 1)):
        u = both[:, half::2]
        cell = (u[0] * 2**a).astype(int) * 2 ** (m - a) + (u[1] * 2 ** (m - a)).astype(int)
        assert np.unique(cell).size == 2**m


def test_every_dimension_is_stratified():
    both = of_pixel(Sobol(1), 512, 0, 100)
    for u in (both[:, ::2], both[:, 1::2]):
        np.testing.assert_array_equal(np.sort(u * 256 // 1, axis=1), np.tile(np.arange(256), (len(u), 1)))


@pytest.mark.parametrize("name", SAMPLERS)
def test_numbers_are_uniform_below_one_and_reach_sample_two_to_the_31(name):
    s = SAMPLERS[name](3)
    n = 100_000
    for first in (0, MAX_SAMPLES - n):
        u = s.uniforms(s.state(np.arange(n), np.arange(first, first + n)), 7, 5)
        assert u.dtype == np.float32
        assert u.shape == (5, n)
        assert u.min() >= 0
        assert u.max() < 1
        np.testing.assert_allclose(u.mean(1), 0.5, atol=5 / np.sqrt(12 * n))


@pytest.mark.parametrize("name", SAMPLERS)
@given(data=st.data())
@settings(max_examples=25, deadline=None)
def test_a_number_depends_on_nothing_but_its_key(name, data):
    """Alone, in a crowd, permuted, from a table or not, with other groups of dimensions: the same bits."""
    draw = data.draw
    n = draw(st.integers(1, 300))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    spread = draw(st.sampled_from([1, 64, 5000, MAX_SAMPLES]))
    pixel = rng.integers(0, 2**32, n)
    sample = rng.integers(0, spread, n)
    dimension = draw(st.sampled_from([0, 3, 250, 636, 5000]))
    seed = draw(st.integers(-(2**63), 2**63 - 1))
    make = SAMPLERS[name]
    s = make(seed)
    crowd = s.uniforms(s.state(pixel, sample), dimension, 6)
    other = make(seed)
    lane = draw(st.integers(0, n - 1))
    alone = other.uniforms(other.state(pixel[lane : lane + 1], sample[lane : lane + 1]), dimension + 2, 3)
    np.testing.assert_array_equal(alone[:, 0], crowd[2:5, lane])
    order = rng.permutation(n)
    np.testing.assert_array_equal(s.uniforms(s.state(pixel, sample)[:, order], dimension, 6), crowd[:, order])


def test_empty_batch():
    for make in SAMPLERS.values():
        s = make(0)
        assert s.uniforms(s.state(np.zeros(0, int), np.zeros(0, int)), 630, 20).shape == (20, 0)


def test_threads_share_a_sampler():
    """Blocks are replaced while other threads read them; every thread still gets the right numbers."""
    shared, pixel = Sobol(4), np.arange(512)

    def work(sample):
        return shared.uniforms(shared.state(pixel, np.full(512, sample)), 0, 8)

    samples = [int(s) for s in np.random.default_rng(0).integers(0, 4096, 400)]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(work, samples))
    alone = Sobol(4)
    for sample, numbers in zip(samples, together, strict=True):
        expected = alone.uniforms(alone.state(pixel, np.full(512, sample)), 0, 8)
        np.testing.assert_array_equal(numbers, expected)


def test_tables_stay_small_for_a_million_samples():
    s = Sobol(0)
    for sample in range(0, 1_000_000, 20_000):
        s.uniforms(s.state(np.arange(4), np.full(4, sample)), 0, 64)
    assert sum(table.nbytes for _, table in s._blocks.values()) <= 64 * 8192


def integrand_variance(make, n, dimension, f, d, pixels=512, seeds=4):
    means = []
    for seed in range(seeds):
        s = make(seed)
        state = s.state(np.tile(np.arange(pixels), n), np.repeat(np.arange(n), pixels))
        means.append(f(s.uniforms(state, dimension, d).astype(np.float64)).reshape(n, pixels).mean(0))
    return np.concatenate(means)


def x_y_squared(u):
    """Mean 1/6, variance 1/15 − 1/36, of which what x and y give together and not alone is 1/135."""
    return u[0] * u[1] ** 2


@pytest.mark.parametrize("dimension", [0, 12, 202])
def test_sobol_beats_independent_numbers_and_neither_is_biased(dimension):
    """∫ x y² dx dy = 1/6: both unbiased (5 σ); with 64 samples Sobol's variance is below a tenth."""
    independent = integrand_variance(Independent, 64, dimension, x_y_squared, 2)
    scrambled = integrand_variance(Sobol, 64, dimension, x_y_squared, 2)
    for estimate in (independent, scrambled):
        assert abs(estimate.mean() - 1 / 6) < 5 * estimate.std() / np.sqrt(estimate.size)
    assert scrambled.var() < 0.1 * independent.var()


@pytest.mark.parametrize("n", [64, 256])
def test_points_of_two_sets_meet_by_chance(n):
    """What x and y of two sets give together is as with independent numbers or little more, the rest is gone.

    Points of a run are in different parts of both sets: 1 + 1/(RUN − 1) times the variance at most, 1/(135 n)
    at least; to 5 standard errors.
    """
    estimate = integrand_variance(Sobol, n, 3, x_y_squared, 2, seeds=16)
    noise = 5 * np.sqrt(2 / estimate.size)
    assert 1 - noise < estimate.var() * 135 * n < (1 + 1 / (sobol.RUN - 1)) * (1 + noise)


def test_shuffled_numbers_keep_together_what_makes_a_net():
    """Blocks of 4, 8, … 4096 become blocks, and within a run of 4 all 24 orders are alike."""
    order = sobol.shuffled(np.arange(1 << 14, dtype=np.uint32), np.uint32(0xDEADBEEF)).astype(np.int64)
    for bits in range(2, 13):
        blocks = np.sort(order.reshape(-1, 1 << bits) >> bits, axis=1)
        assert (blocks[:, 0] == blocks[:, -1]).all()
        assert np.unique(blocks[:, 0]).size == len(blocks)
    assert np.unique(order).size == order.size
    orders = np.unique(order.reshape(-1, sobol.RUN) % sobol.RUN, axis=0, return_counts=True)[1]
    assert orders.size == 24
    assert chisquare(orders).pvalue > 1e-4


def test_pixels_share_their_scrambles_with_one_in_sixteen():
    """Two pixels' points differ by one shift alone where they are of one group, and by more elsewhere."""
    pixels, n = 400, 64
    u = Sobol(7).uniforms(Sobol(7).state(np.arange(pixels), 2 * np.arange(n)[:, None]), 5, 1)
    digits = (u.reshape(n, pixels) * 2.0**24).astype(np.uint32)
    patterns, counts = np.unique(digits ^ digits[0], axis=1, return_counts=True)
    assert patterns.shape[1] == 16
    assert chisquare(counts).pvalue > 1e-4


def test_errors_of_neighbouring_pixels_are_uncorrelated_under_sobol():
    """Scrambles are shared by many pixels, shifts are not: correlation 0 ± 5/√n."""
    errors = integrand_variance(Sobol, 16, 3, lambda u: ((u**2).sum(0) < 0.8) * 1.0, 2, 4096, 1) - 0.2 * np.pi
    r = np.corrcoef(errors[:-1], errors[1:])[0, 1]
    assert abs(r) < 5 / np.sqrt(errors.size)


def test_even_and_odd_samples_know_nothing_of_each_other():
    """Errors of the two halves of a pixel, and of one pixel's even with the next one's odd: uncorrelated.

    Given the scrambles, too, or the halves' difference would not tell the image's error: in each seed and
    group of pixels by itself, where n r² is a χ² of one degree of freedom.
    """
    n, pixels, square = 32, 8192, []
    for seed in range(3):
        s = Sobol(seed)
        group = s.state(np.arange(pixels), np.array(0))[0] >> np.uint32(32 - GROUP_BITS)
        state = s.state(np.tile(np.arange(pixels), n), np.repeat(np.arange(n), pixels))
        u = s.uniforms(state, 4, 2).astype(np.float64)
        inside = ((u**2).sum(0) < 0.8).reshape(n // 2, 2, pixels).mean(0)
        for alike in (group == k for k in range(GROUPS)):
            even, odd = inside[:, alike]
            for other in (odd, np.roll(odd, 1)):
                square.append(alike.sum() * np.corrcoef(even, other)[0, 1] ** 2)
    assert chi2(len(square)).sf(np.sum(square)) > 1e-4
