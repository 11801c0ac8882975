"""The comparison of images itself: equal expectations pass at the stated rate, unequal ones don't."""

import numpy as np
from support.ztest import compare

HEIGHT, WIDTH = 60, 80


def images(mean, count, seed, fireflies=0.0):
    """`count` noisy images; fireflies are rare pixels worth `fireflies` of the mean in total."""
    rng = np.random.default_rng(seed)
    shape = (count, HEIGHT, WIDTH, 3)
    noise = rng.gamma(50.0, 1 / 50, shape)
    rare = 1e-3
    noise += fireflies * ((rng.random(shape) < rare) / rare - 1) * (fireflies > 0)
    return mean * noise


def test_equal_images_pass():
    """Of 60 pairs none is rejected at 1e-4, with or without fireflies; p-values are not all tiny."""
    for fireflies in (0.0, 0.5):
        found = []
        for seed in range(30):
            a0, a1, b0, b1 = images(0.7, 4, seed, fireflies)
            found.append(compare((a0, a1), (b0, b1)).p)
        assert min(found) > 1e-4
        assert np.median(found) > 0.1


def test_error_beyond_noise_is_unbiased():
    """A cell pattern of ±10 % shows as 10 %, although a pixel's noise is 14 %."""
    pattern = np.ones((HEIGHT, WIDTH, 1))
    pattern[:, : WIDTH // 2] = 1.2
    a0, a1 = images(1.0, 2, 1) * pattern
    b0, b1 = images(1.0, 2, 2)
    agreement = compare((a0, a1), (b0, b1))
    assert abs(agreement.error - np.sqrt(0.02)) < 0.02
    assert abs(agreement.pixel_error - np.sqrt(0.02)) < 0.04
    assert agreement.p < 1e-6
    assert not agreement.agrees()


def test_a_small_bias_of_the_whole_image_is_found():
    """1.2 % everywhere: 0.6 σ of a cell, 6 σ of the image."""
    a0, a1, b0, b1 = images(1.0, 4, 4)
    assert compare((1.012 * a0, 1.012 * a1), (b0, b1)).p < 1e-4


def test_a_local_difference_is_found():
    a0, a1, b0, b1 = images(1.0, 4, 3)
    for image in (a0, a1):
        image[:8, :7] *= 1.5
    agreement = compare((a0, a1), (b0, b1))
    assert agreement.p < 1e-6
    assert agreement.worst[:2] == (0, 0)


def test_noiseless_images_agree_up_to_rounding():
    flat = np.full((HEIGHT, WIDTH, 3), 0.5, np.float32)
    other = flat * np.float32(1 + 1e-6)
    assert compare((flat, flat), (other, other)).agrees(tolerance=1e-4)
    assert not compare((flat, flat), (flat * 1.1, flat * 1.1)).agrees()
