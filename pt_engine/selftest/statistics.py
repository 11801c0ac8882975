"""Statistics: sums, merging, roulette, and random numbers where float32 and 32 bits run out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..core.hashing import lowbias32
from ..core.samplers import SAMPLERS, Sampler
from ..render.film import Film
from ..render.path_state import PathState
from ..render.survivors import roulette
from . import scenes as make
from .case import Group
from .geometry import worst

STATISTICS = Group("Statistics")
Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
NONE = float("nan")
ONE_PIXEL = np.zeros(1, np.int32)


def film_of(values: Float32, chunk: int = 1 << 16) -> Film:
    """A film of one pixel with these samples."""
    film = Film(1, 1)
    for first in range(0, len(values), chunk):
        part = values[first : first + chunk]
        film.add(ONE_PIXEL, first, len(part), np.repeat(part[None], 3, axis=0))
    return film


@STATISTICS.case(
    "sums of a million samples",
    "a float32 sum of 1e6 numbers loses the small ones",
    "relative error of the mean of a million samples, one in a thousand 1e4 times as bright",
    0.0,
    1e-7,
    "the mean is rounded to float32 once",
    naive=lambda: sum_error(lambda x: float(np.add.accumulate(x)[-1]) / len(x)),
)
def million() -> float:
    return sum_error(lambda x: float(film_of(x).image()[0, 0, 0]))


def sum_error(mean: Callable[[Float32], float]) -> float:
    """Against float64."""
    x = np.random.default_rng(1).random(1_000_000, np.float32)
    x[::1000] *= 1e4
    return abs(mean(x) / float(x.astype(np.float64).mean()) - 1)


@STATISTICS.case(
    "variance under a firefly",
    "Σx² − n x̄² of 1 ± 1e-3 and one 1e6 cancels all digits of float32",
    "relative error of the variance of the mean of 10,000 samples 1000 ± 0.1",
    0.0,
    1e-4,
    "squares are kept in steps of 2⁻⁴²",
    naive=lambda: variance_error(naive_variance),
)
def firefly() -> float:
    return variance_error(lambda x: float(film_of(x).variance_of_mean()[0, 0, 0]))


def variance_error(of_mean: Callable[[Float32], float]) -> float:
    """Against float64, the worse of a small spread on a large mean, and one firefly among small numbers."""
    rng = np.random.default_rng(2)
    steady = (1000 + 0.1 * rng.standard_normal(10_000)).astype(np.float32)
    wild = rng.random(10_000, np.float32)
    wild[77] = 1e6
    return max(
        abs(of_mean(x) / (float(np.var(x.astype(np.float64), ddof=1)) / len(x)) - 1) for x in (steady, wild)
    )


def naive_variance(x: Float32) -> float:
    """(Σx²/n − x̄²)/(n − 1) of float32 sums."""
    total, squares = np.add.accumulate(x)[-1], np.add.accumulate(x * x)[-1]
    n = np.float32(len(x))
    return float((squares / n - (total / n) ** 2) / (n - 1))


@STATISTICS.case(
    "a sample of 1e30",
    "its square is 1e60; exact sums have an end",
    "relative error of a pixel's mean, of 64 samples 1 and one 1e30",
    0.0,
    1e-6,
    "rounding to float32",
)
def enormous() -> float:
    x = np.ones(65, np.float32)
    x[5] = 1e30
    film = film_of(x)
    finite = np.isfinite(film.variance_of_mean()).all()
    return abs(float(film.image()[0, 0, 0]) * 65 / 1e30 - 1) if finite and not film.dropped else NONE


@STATISTICS.case(
    "one sample, and none",
    "the variance of one sample is 0/0",
    "radiance of a pixel with one sample 0.5 beside one without any, if no error is claimed",
    0.5,
    0.0,
    "exact",
)
def one_sample() -> float:
    film = Film(2, 1)
    film.add(ONE_PIXEL, 0, 1, np.full((3, 1), 0.5, np.float32))
    image, claimed = film.image(), film.error()["mse"]
    return float(image[0, :, 0].sum()) if claimed is None and np.isfinite(image).all() else NONE


@STATISTICS.case(
    "merging unequal films",
    "3 and 61 samples, in either order, must be the 64 of one run",
    "bits that differ",
    0.0,
    0.0,
    "sums are exact",
    naive=lambda: merged(plain_sum),
)
def merging() -> float:
    return merged(film_sum)


def merged(total: Callable[[list[Float32]], float]) -> float:
    """How many orders of the parts give another sum than the whole."""
    x = np.random.default_rng(3).lognormal(0, 4, 64).astype(np.float32)
    a, b, c = x[:3], x[3:20], x[20:]
    whole = total([x])
    return float(sum(total(list(parts)) != whole for parts in ((a, b, c), (c, a, b), (b, c, a))))


def film_sum(parts: list[Float32]) -> float:
    """Of films merged."""
    films, first = [], 0
    for part in parts:
        film = Film(1, 1)
        film.add(ONE_PIXEL, first, len(part), np.repeat(part[None], 3, axis=0))
        films.append(film)
        first += len(part)
    for other in films[1:]:
        films[0].merge(other)
    return float(films[0].image()[0, 0, 0]) + float(films[0].moments(slice(0, 1)).variance[0, 0])


def plain_sum(parts: list[Float32]) -> float:
    """Of float32 sums of the parts."""
    return float(sum((np.add.accumulate(part)[-1] for part in parts), start=np.float32(0)))


@STATISTICS.case(
    "non-finite samples",
    "one NaN in a sum is NaN for ever",
    "mean of a pixel with samples 1, NaN, 1, ∞, −∞, 1",
    1.0,
    0.0,
    "they are dropped, counted, and not divided by",
    naive=lambda: float(np.array([1, np.nan, 1, np.inf, -np.inf, 1], np.float32).mean()),
)
def dropped() -> float:
    film = film_of(np.array([1, np.nan, 1, np.inf, -np.inf, 1], np.float32))
    return float(film.image()[0, 0, 0]) if film.dropped == 3 else NONE


def roulette_mean(throughput: float) -> float:
    """E[β'] / β after roulette, over the 2²⁴ numbers that a uniform may be (in steps of 64 above 2¹⁶)."""
    near = np.arange(1 << 16, dtype=np.float64)
    far = np.arange((1 << 16) + 32, 1 << 24, 64, dtype=np.float64)
    u = (np.concatenate([near, far]) * 2.0**-24).astype(np.float32)
    path = PathState.empty(u.size)
    path.beta[:] = throughput
    roulette(path, np.full(u.size, throughput, np.float32), u)
    beta = path.beta[0].astype(np.float64)
    return float((beta[: near.size].sum() + 64 * beta[near.size :].sum()) * 2.0**-24 / throughput)


@STATISTICS.case(
    "roulette with throughput above 1",
    "a probability above 1 would multiply what can't be divided",
    "expected throughput over that before, for β = 0.5, 1, 50, 1e6",
    1.0,
    1e-5,
    "uniforms are multiples of 2⁻²⁴",
    naive=lambda: min(1.0, 50.0) / 50.0 * 1.0,
)
def bright_roulette() -> float:
    return worst([roulette_mean(beta) for beta in (0.5, 1.0, 50.0, 1e6)], 1.0)


@STATISTICS.case(
    "roulette with throughput near 0",
    "no uniform but 0 is below 2⁻²⁴: a path of less would live too often or never",
    "expected throughput over that before, for β = 1e-2, 1e-6, 1e-9",
    1.0,
    5e-4,
    "a hundredth, the least chance, is met by 167,772 uniforms, which are counted in steps of 64",
    naive=lambda: 2.0**-24 / 1e-9,
)
def faint_roulette() -> float:
    return worst([roulette_mean(beta) for beta in (1e-2, 1e-6, 1e-9)], 1.0)


def uniforms(
    sampler: Sampler, pixel: NDArray[np.integer], sample: NDArray[np.integer], dimension: int = 5
) -> Float32:
    """(N,) of one dimension."""
    row: Float32 = sampler.uniforms(sampler.state(pixel, sample), dimension, 1)[0]
    return row


@STATISTICS.case(
    "sample numbers beyond 2²⁴",
    "as float32 two of three neighbours become one",
    "different numbers among 999 neighbouring samples beyond 2²⁴ and 2³⁰, both samplers, the least",
    999.0,
    2.0,
    "999 of 2²⁴ possible numbers: 0.03 coincidences",
    naive=lambda: float(
        np.unique(lowbias32((2**24 + np.arange(999)).astype(np.float32).astype(np.uint32))).size
    ),
)
def large_samples() -> float:
    k, zero = np.arange(999), np.zeros(999, int)
    values = [
        np.unique(uniforms(kind(1), zero, start + k)).size
        for kind in SAMPLERS.values()
        for start in (2**24 - 500, 2**30, 2**31 - 1000)
    ]
    return float(min(values))


@STATISTICS.case(
    "seeds 0, 1 and 2³¹ − 1",
    "a seed of 0 may be a fixed point of a hash, neighbouring ones alike",
    "largest correlation of 65,536 numbers between the seeds, and deviation of their means from ½",
    0.0,
    0.02,
    "five standard errors of 65,536",
)
def seeds() -> float:
    pixel = np.arange(65_536)
    found = []
    for kind in SAMPLERS.values():
        rows = [uniforms(kind(seed), pixel, pixel * 0) for seed in (0, 1, 2**31 - 1)]
        matrix = np.corrcoef(rows)
        found += [np.abs(matrix - np.eye(3)).max(), max(abs(float(row.mean()) - 0.5) for row in rows)]
    return float(max(found))


@STATISTICS.case(
    "no pattern between neighbours",
    "a weak hash shows as lines in the picture",
    "largest correlation between neighbouring pixels, rows, samples and dimensions",
    0.0,
    0.02,
    "five standard errors of 65,536",
    naive=lambda: neighbours(
        lambda p, s, d: ((p * 16807 + s * 48271 + d * 69621) % 65536 / 65536).astype(np.float32)
    ),
)
def patterns() -> float:
    sobol, independent = SAMPLERS["sobol"](3), SAMPLERS["independent"](3)
    return max(
        neighbours(lambda p, s, d: uniforms(sobol, p, s, d), samples=False),
        neighbours(lambda p, s, d: uniforms(independent, p, s, d)),
    )


def neighbours(draw: Callable[..., Float32], samples: bool = True) -> float:
    """Of numbers that are drawn by (pixel, sample, dimension); Sobol's samples avoid each other."""
    p, s = np.arange(65_536), np.zeros(65_536, int)
    here = draw(p, s, 4)
    others = [draw(p + 1, s, 4), draw(p + 1920, s, 4), draw(p, s, 5)]
    others += [draw(p, s + 1, 4)] if samples else []
    return float(max(abs(np.corrcoef(here, other)[0, 1]) for other in others))


@STATISTICS.case(
    "threads, tiles and parts",
    "sums whose last bits depend on who was first",
    "bits that differ between 1 and 4 threads, and between large and small units",
    0.0,
    0.0,
    "random numbers are keyed, sums exact",
)
def schedule() -> float:
    ball = (make.sphere(0.5, 12), np.eye(4), make.shader("BsdfGlossy", "g", Color=make.WHITE, Roughness=0.3))
    snapshot = make.scene(
        [ball], make.perspective((0, -3, 0.4), (0, 0, 0), 0.3), sky=make.world((1.0, 0.5, 0.2))
    )
    images = [
        make.rendered(snapshot, 16, samples=8, sampler="sobol", **how).image()
        for how in ({"threads": 1}, {"threads": 4}, {"threads": 2, "lanes": 64})
    ]
    return float(sum(np.count_nonzero(image != images[0]) for image in images))
