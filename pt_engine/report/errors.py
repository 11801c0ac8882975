"""How far images are from a reference: squared errors, and bias with its z-score.

With x an image, R the reference and v_R the variance that is known of R's own noise,

    MSE    = mean of (x − R)² − v_R              the error against what R would converge to
    relMSE = mean of that / (R² + 0.01 m²)       m the reference's mean
    bias   = mean over pixels of x̄ − R           x̄ the mean over runs; in parts of the reference's mean
    z      = bias / √(variance of the means of x̄ and of R)

The reference's own noise moves all MSE by the same δ = mean of (R − T)² − v_R, T the truth. An MSE below
1.96 standard deviations of δ is not known, whoever's it is.

A local bias can hide in the mean: `worst` is the largest |z| of 6 × 4 cells, and p is corrected for their
number. Pixels whose noise nobody knows (of a single sample) have no say in any z.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .fits import two_sided_p

Float64 = NDArray[np.float64]
CELLS, LEAST = (4, 6), 8  # rows and columns, of so many pixels at least: fewer do not know their own noise
BIASED = 1e-4  # chance at which an unbiased estimator is called biased


class Picture(NamedTuple):
    """Radiance (height, width, 3) and the variance of its noise, or None where it is not known."""

    mean: Float64
    variance: Float64 | None


class Bias(NamedTuple):
    """Of a mean image: part of the reference's energy, z of the mean, largest z of a cell, corrected p."""

    relative: float
    z: float
    worst: float
    p: float

    @property
    def significant(self) -> bool:
        """Whether chance hardly does that."""
        return self.p < BIASED


def squared_error(image: Float64, reference: Picture) -> Float64:
    """(height, width) mean over channels; single pixels may be negative where the reference has noise."""
    squared: Float64 = ((image - reference.mean) ** 2).mean(axis=2)
    if reference.variance is not None:
        squared -= known(reference.variance).mean(axis=2)
    return squared


def known(variance: Float64) -> Float64:
    """A variance, 0 where it is not known."""
    return np.where(np.isfinite(variance), variance, 0.0)


def mse(image: Float64, reference: Picture) -> float:
    """Mean squared error; at least 0."""
    return max(0.0, float(squared_error(image, reference).mean()))


def least_known(reference: Picture) -> float:
    """The MSE below which a reference tells nothing: 1.96 √(Σ 2 v²) / pixels, v the mean of channels."""
    if reference.variance is None:
        return 0.0
    v = known(reference.variance).mean(axis=2)  # channels share their noise
    return 1.96 * math.sqrt(2 * float((v * v).sum())) / v.size


def relative_mse(image: Float64, reference: Picture) -> float:
    """Squared error in parts of the reference's square."""
    r = reference.mean
    squared = (image - r) ** 2
    if reference.variance is not None:
        squared -= known(reference.variance)
    scale = r**2 + 0.01 * r.mean() ** 2
    return max(0.0, float((squared / (scale + (scale == 0))).mean()))


def bias(image: Picture, reference: Picture) -> Bias:
    """Of an image whose noise is known."""
    difference = image.mean - reference.mean
    variance = np.zeros_like(difference)
    for picture in (image, reference):
        if picture.variance is not None:
            variance += picture.variance
    total = float(reference.mean.mean())
    relative = float(difference.mean()) / (total or 1.0)
    z = float(z_scores(difference, variance, (1, 1), total)[0, 0])
    cells = z_scores(difference, variance, CELLS, total)
    worst = max(cells.ravel().tolist(), key=abs)
    p = min(two_sided_p(z), two_sided_p(worst))
    return Bias(relative, z, worst, -math.expm1((cells.size + 1) * math.log1p(-min(p, 1 - 1e-12))))


def z_scores(difference: Float64, variance: Float64, cells: tuple[int, int], scale: float) -> Float64:
    """(rows, columns) of a grid of cells: mean difference over its standard error, 0 where nothing is known.

    What float32 rounds, 10⁻⁵ of the mean, is no difference.
    """
    told = np.isfinite(variance).all(axis=2)
    rows, columns = (
        min(n, max(1, size // LEAST)) for n, size in zip(cells, difference.shape[:2], strict=True)
    )
    z = np.zeros((rows, columns))
    for i, part in enumerate(np.array_split(np.arange(difference.shape[0]), rows)):
        for j, across in enumerate(np.array_split(np.arange(difference.shape[1]), columns)):
            where = np.ix_(part, across)
            # channels share their noise: the mean of three has at most the mean of their variances
            d, v = (part[where][told[where]].mean(axis=1) for part in (difference, variance))
            if v.size:
                error = math.sqrt(float(v.sum())) / v.size
                z[i, j] = float(d.mean()) / math.hypot(error, 1e-5 * abs(scale), 1e-30)
    return z
