"""Hash quality: avalanche, bijection, and no memory of neighbouring pixels, samples, dimensions or seeds."""

import numpy as np
import pytest
from support.chi2 import chi2_counts, significance

from pt_engine.core.hashing import hash_words, lowbias32, lowbias32_inplace, to_unit_interval
from pt_engine.core.samplers import Independent, Sobol


def test_hash_of_zero_to_a_million_has_no_collision_and_is_pure():
    """A bijection cannot collide; the input is left alone."""
    x = np.arange(1_000_000, dtype=np.uint32)
    assert np.unique(lowbias32(x)).size == x.size
    np.testing.assert_array_equal(x, np.arange(1_000_000))
    y = x.copy()
    lowbias32_inplace(y, np.empty_like(y))
    np.testing.assert_array_equal(y, lowbias32(x))


def test_avalanche():
    """Each input bit flips each output bit with probability 1/2, within 2 % (z = 10 for 65,536 draws)."""
    x = np.random.default_rng(0).integers(0, 2**32, 65_536, dtype=np.uint32)
    h = lowbias32(x)
    for bit in range(32):
        flipped = h ^ lowbias32(x ^ np.uint32(1 << bit))
        rate = np.array([((flipped >> k) & 1).mean() for k in range(32)])
        assert np.abs(rate - 0.5).max() < 0.02


def test_hash_words_separates_order_sign_and_length():
    words = [(), (0,), (1,), (0, 0), (0, 1), (1, 0), (-1,), (2**32,), (2**32 - 1,), (2**63,)]
    assert len({hash_words(*w) for w in words}) == len(words)


def test_unit_interval_is_24_bits_and_below_one():
    bits = np.array([0, 255, 256, 2**32 - 1], np.uint32)
    out = np.empty(4, np.float32)
    to_unit_interval(bits, out)
    np.testing.assert_array_equal(out, np.array([0, 0, 2.0**-24, 1 - 2.0**-24], np.float32))


def pair_p_value(x, y, cells=32):
    """χ² of the joint histogram of two columns against independence and uniformity."""
    joint = np.histogram2d(x, y, bins=cells, range=[[0, 1], [0, 1]])[0]
    return chi2_counts(joint, np.full(cells * cells, x.size / cells**2))


N = 200_000
LANES = np.arange(N)


def numbers(sampler, pixel, sample, dimension):
    return sampler.uniforms(sampler.state(pixel, sample), dimension, 1)[0]


NEIGHBOURS = {
    "pixels": lambda s: (numbers(s(1), LANES, LANES * 0, 3), numbers(s(1), LANES + 1, LANES * 0, 3)),
    "rows": lambda s: (numbers(s(1), LANES, LANES * 0, 3), numbers(s(1), LANES + 1920, LANES * 0, 3)),
    "dimensions": lambda s: (numbers(s(1), LANES, LANES * 0, 3), numbers(s(1), LANES, LANES * 0, 4)),
    "seeds": lambda s: (numbers(s(1), LANES, LANES * 0, 3), numbers(s(2), LANES, LANES * 0, 3)),
    "negative seeds": lambda s: (numbers(s(-1), LANES, LANES * 0, 3), numbers(s(0), LANES, LANES * 0, 3)),
    "samples": lambda s: (numbers(s(1), LANES, LANES * 0, 3), numbers(s(1), LANES, LANES * 0 + 1, 3)),
    "pixel to next dimension": lambda s: (
        numbers(s(1), LANES, LANES * 0, 3),
        numbers(s(1), LANES + 1, LANES * 0, 4),
    ),
    "pixel to next seed": lambda s: (
        numbers(s(1), LANES, LANES * 0, 3),
        numbers(s(2), LANES + 1, LANES * 0, 3),
    ),
}


@pytest.mark.parametrize(
    ("sampler", "which"),
    [(s, w) for s in (Independent, Sobol) for w in NEIGHBOURS if (s, w) != (Sobol, "samples")],
)
def test_neighbours_are_independent(sampler, which):
    """All but the samples of one pixel under Sobol, which are stratified on purpose."""
    assert pair_p_value(*NEIGHBOURS[which](sampler)) > significance(16, 1e-4)


def test_independent_sequence_within_a_pixel():
    """Along the samples of one pixel: uniform, and no lag-1 or dimension-to-dimension structure."""
    s = Independent(5)
    x = s.uniforms(s.state(np.full(N, 17), LANES), 0, 3)
    assert pair_p_value(x[0][:-1], x[0][1:]) > 1e-5
    assert pair_p_value(x[0], x[1]) > 1e-5
    assert pair_p_value(x[1], x[2]) > 1e-5


def test_low_digits_are_uniform_too():
    """Bits 8 to 13 below the leading ones, where a multiplicative hash is weakest."""
    s = Independent(5)
    x = s.uniforms(s.state(LANES, LANES * 0), 0, 1)[0].astype(np.float64)
    assert pair_p_value((x * 2**14) % 1, (x * 2**8) % 1) > 1e-5
