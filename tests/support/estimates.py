"""Compare Monte Carlo estimates with numbers and with each other, by their own measured variance."""

from __future__ import annotations

import numpy as np

from pt_engine.render.progressive import RenderResult


def mean_and_error(result: RenderResult) -> tuple[np.ndarray, np.ndarray]:
    """Mean over all pixels per channel (3,), and its standard error from the film's variances."""
    image = result.film.image()[..., :3].astype(np.float64)
    variance = result.film.variance_of_mean().reshape(-1, 3)
    return image.reshape(-1, 3).mean(axis=0), np.sqrt(variance.sum(axis=0)) / len(variance)


def assert_within_standard_errors(
    result: RenderResult, expected: float | np.ndarray, z: float = 4.5, relative: float = 2e-6
) -> None:
    """The image's mean lies within z standard errors of `expected` (false alarm at 4.5: 7e-6 per channel).

    `relative` allows for float32 rounding along a path, where the estimator has no variance at all.
    """
    mean, error = mean_and_error(result)
    slack = z * error + relative * np.abs(expected)
    assert (np.abs(mean - expected) <= slack).all(), f"{mean} ± {error}, expected {expected}"


def assert_same_mean(a: RenderResult, b: RenderResult, z: float = 4.5) -> None:
    """Two independent renders estimate the same image mean."""
    (mean_a, error_a), (mean_b, error_b) = mean_and_error(a), mean_and_error(b)
    slack = z * np.hypot(error_a, error_b) + 1e-6 * np.abs(mean_a)
    assert (np.abs(mean_a - mean_b) <= slack).all(), f"{mean_a} ± {error_a} against {mean_b} ± {error_b}"
