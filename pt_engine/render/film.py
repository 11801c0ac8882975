"""The film: what the samples of each pixel add up to, exactly.

Per pixel it keeps the sum and the sum of squares of every channel (see `exact_sum`), the sum of alpha in
steps of 2⁻²⁴, and the count of samples: 108 bytes, 116 where pixels are stored in an order of their own.
Since sums are exact, adding samples in any order, in any chunks, on any number of films merged in any
order, gives the very same bits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from . import exact_sum
from .film_error import ErrorEstimate, estimate_error

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Ranges = tuple[tuple[int, int], ...]

ALPHA_STEPS = 2.0**24
SQUARE_SCALE = 64.0  # squares of dim pixels need finer steps: exact for |x| in 5e-7 … 5e7
BLOCK = 1 << 16  # pixels that are worked on at a time, to keep temporaries small


class Moments(NamedTuple):
    """Of some pixels: mean (3, n), variance of the mean (3, n; NaN below two samples), samples (n,)."""

    mean: Float64
    variance: Float64
    samples: NDArray[np.uint32]


class Film:
    """Sums for width × height pixels; pixel (x, y) is number y · width + x, y up.

    Parameters
    ----------
    width, height : int
    key : str
        What the render is: films merge only with films of the same key.
    order : (width · height,) int32, optional
        The pixels in the order in which units visit them. A unit that is a run of it is added without
        gathering and scattering, which halves the cost of small passes. It changes no result.
    reject_negative : bool
        Whether samples with a negative channel are dropped as well as those that are not finite.

    Attributes
    ----------
    dropped : int
        Samples refused so far.
    ranges : tuple of (first, count)
        The samples that were added, merged where they touch.
    """

    def __init__(
        self,
        width: int,
        height: int,
        key: str = "",
        order: NDArray[np.int32] | None = None,
        reject_negative: bool = False,
    ) -> None:
        if width < 1 or height < 1:
            raise ValueError(f"a film needs at least one pixel, not {width} × {height}")
        self.width, self.height, self.key = int(width), int(height), key
        self.reject_negative = reject_negative
        self.dropped = 0
        self.ranges: Ranges = ()
        n = self.pixels
        # Rows: red, green, blue, and the squares of each.
        self._high, self._low = np.zeros((6, n)), np.zeros((6, n))
        self._alpha: Float64 | None = None  # None: every sample had 1
        self._count = np.zeros(n, np.uint32)
        self._order = order
        self._rank: NDArray[np.int32] | None = None
        self._runs: dict[int, int] = {}

    @property
    def pixels(self) -> int:
        """How many there are."""
        return self.width * self.height

    # ------------------------------------------------------------------ in

    @stage("film")
    def add(
        self,
        pixels: slice | NDArray[np.integer],
        first: int,
        count: int,
        radiance: Float32,
        alpha: Float32 | None = None,
    ) -> NDArray[np.intp]:
        """Add samples `first` … `first + count − 1` of some pixels; not to be called by two threads at once.

        Parameters
        ----------
        pixels : (m,) integers, all different, or a slice of pixel numbers
        radiance : (3, count · m) float32
            Sample-major: slot = sample · m + pixel.
        alpha : (count · m,) float32 or None
            None means 1.

        Returns
        -------
        (k,) intp
            Slots that were dropped: not finite, or negative where that is refused. A dropped sample does
            not count.
        """
        where, m = self._place(pixels)
        if radiance.shape != (3, count * m):
            raise ValueError(f"expected radiance of shape {(3, count * m)}, got {radiance.shape}")
        self.ranges = _joined((*self.ranges, (int(first), int(count))))
        bad = self._refused(radiance, alpha)
        self._count[where] += np.uint32(count)
        if bad.size:
            self.dropped += int(bad.size)
            radiance = radiance.copy()
            radiance[:, bad] = 0
            if alpha is not None:
                alpha = alpha.copy()
                alpha[bad] = 0
            self._count[where] -= np.bincount(bad % m, minlength=m).astype(np.uint32)
        self._add_alpha(where, alpha, count, m, bad)
        for channel in range(3):
            values = radiance[channel].reshape(count, m)
            largest = max(float(values.max(initial=0)), -float(values.min(initial=0)))
            terms = values.astype(np.float64)
            squares = terms * SQUARE_SCALE
            squares *= terms
            exact_sum.add(self._high[channel], self._low[channel], where, terms, largest)
            largest *= largest * SQUARE_SCALE
            exact_sum.add(self._high[channel + 3], self._low[channel + 3], where, squares, largest)
        return bad

    def _place(self, pixels: slice | NDArray[np.integer]) -> tuple[exact_sum.Where, int]:
        """Where the pixels are stored, and how many they are."""
        if isinstance(pixels, slice):
            span = range(*pixels.indices(self.pixels))
            if self._order is None:
                return pixels, len(span)
            pixels = np.arange(span.start, span.stop, span.step)
        m = len(pixels)
        if self._order is None or m == 0:
            return pixels, m
        start = self._runs.get(int(pixels[0]))
        if start is None:
            start = self._runs[int(pixels[0])] = int(self._ranks()[pixels[0]])
        if np.array_equal(self._order[start : start + m], pixels):
            return slice(start, start + m), m
        return self._ranks()[pixels], m

    def _refused(self, radiance: Float32, alpha: Float32 | None) -> NDArray[np.intp]:
        with np.errstate(invalid="ignore", over="ignore"):
            total = radiance[0] + radiance[1]
            total += radiance[2]
            if alpha is not None:
                total += alpha
            bad: NDArray[np.bool_] = ~np.isfinite(total)
            if self.reject_negative and (bad.any() or np.min(radiance, initial=0) < 0):
                bad |= radiance.min(axis=0) < 0
        if not bad.any():
            return np.zeros(0, np.intp)
        slots = np.flatnonzero(bad)
        # The sum of finite numbers may overflow; look again at the few that are left.
        channels = radiance[:, slots]
        good = np.isfinite(channels).all(axis=0)
        if alpha is not None:
            good &= np.isfinite(alpha[slots])
        if self.reject_negative:
            good &= (channels >= 0).all(axis=0)
        return slots[~good]

    def _add_alpha(
        self, where: exact_sum.Where, alpha: Float32 | None, count: int, m: int, bad: NDArray[np.intp]
    ) -> None:
        if self._alpha is None:
            if alpha is None:
                return
            self._alpha = self._count.astype(np.float64)
            self._alpha[where] -= count - np.bincount(bad % max(m, 1), minlength=m)
        if alpha is None:
            self._alpha[where] += count - np.bincount(bad % max(m, 1), minlength=m)
        else:
            steps = np.rint(alpha.reshape(count, m) * ALPHA_STEPS, dtype=np.float64)
            self._alpha[where] += steps.sum(axis=0) * (1.0 / ALPHA_STEPS)

    def merge(self, other: Film) -> None:
        """Add another film of the same render; the result is bit for bit the film of all samples.

        Raises
        ------
        ValueError
            Size or key differ, or some samples are in both.
        """
        if (self.width, self.height) != (other.width, other.height):
            sizes = f"{self.width} × {self.height} and {other.width} × {other.height}"
            raise ValueError(f"films of {sizes} pixels do not merge")
        if self.key != other.key:
            raise ValueError(f"these films are of different renders: {self.key!r} and {other.key!r}")
        overlap = overlapping(self.ranges, other.ranges)
        if overlap is not None:
            raise ValueError(f"both films hold samples {overlap[0]} to {sum(overlap) - 1}")
        self.ranges = _joined(self.ranges + other.ranges)
        self.dropped += other.dropped
        theirs = slice(None) if self._order is other._order else other._gather(self._stored_pixels())
        for row in range(6):
            exact_sum.merge(
                self._high[row], self._low[row], other._high[row][theirs], other._low[row][theirs]
            )
        if self._alpha is not None or other._alpha is not None:
            mine = self._count.astype(np.float64) if self._alpha is None else self._alpha
            more = other._count.astype(np.float64) if other._alpha is None else other._alpha
            self._alpha = mine + more[theirs]
        self._count += other._count[theirs]

    # ------------------------------------------------------------------ out

    def image(self) -> Float32:
        """Mean radiance and alpha: (height, width, 4) float32, bottom row first; 0 without samples."""
        image = np.empty((self.pixels, 4), np.float32)
        for part in self._blocks():
            stored = self._gather(part)
            count = np.maximum(self._count[stored], 1)
            for channel in range(3):
                image[part, channel] = (self._high[channel][stored] + self._low[channel][stored]) / count
            if self._alpha is None:
                image[part, 3] = self._count[stored] > 0
            else:
                image[part, 3] = self._alpha[stored] / count
        return image.reshape(self.height, self.width, 4)

    def counts(self) -> NDArray[np.uint32]:
        """Samples of each pixel: (height, width) uint32."""
        return self._count[self._gather(slice(0, self.pixels))].reshape(self.height, self.width)

    def variance_of_mean(self) -> Float64:
        """Variance of each pixel's mean: (height, width, 3) float64, NaN below two samples.

        s²/n with the unbiased s². It is exact in expectation for independent samples; stratified ones
        (Sobol) have less error than it says, so it is an upper bound for them in practice.
        """
        result = np.empty((self.pixels, 3))
        for part in self._blocks():
            result[part] = self.moments(part).variance.T
        return result.reshape(self.height, self.width, 3)

    def moments(self, pixels: slice) -> Moments:
        """Means and their variances for a run of pixel numbers."""
        stored = self._gather(pixels)
        count = self._count[stored]
        n = np.maximum(count, 1).astype(np.float64)
        # One memory layout whatever the storage: numpy's sums depend on it in the last bit.
        total = np.ascontiguousarray(self._high[:, stored] + self._low[:, stored])
        mean = total[:3] / n
        # Σ(x − x̄)² = Σx² − n x̄²; what rounding makes negative is 0.
        spread = np.maximum(total[3:] * (1.0 / SQUARE_SCALE) - total[:3] * mean, 0.0)
        variance = spread / (n * np.maximum(n - 1.0, 1.0))
        variance[:, count < 2] = np.nan
        return Moments(mean, variance, count)

    def error(self) -> ErrorEstimate:
        """mse, mse_ci95, relmse, relmse_ci95 (None below two samples): see `film_error`."""
        return estimate_error(lambda: (self.moments(part) for part in self._blocks()))

    def state(self) -> dict[str, NDArray[np.generic]]:
        """The arrays that make the film, in the order of pixel numbers."""
        stored = self._gather(slice(0, self.pixels))
        high, low = exact_sum.canonical(self._high, self._low)
        arrays: dict[str, NDArray[np.generic]] = {
            "high": np.ascontiguousarray(high[:, stored]),
            "low": np.ascontiguousarray(low[:, stored]),
            "count": self._count[stored],
        }
        if self._alpha is not None:
            arrays["alpha"] = self._alpha[stored]
        return arrays

    def restore(self, high: Float64, low: Float64, count: NDArray[np.uint32], alpha: Float64 | None) -> None:
        """Take over arrays as `state` gives them."""
        stored = self._stored_pixels()
        self._high, self._low, self._count = high[:, stored], low[:, stored], count[stored]
        self._alpha = None if alpha is None else alpha[stored]

    # ------------------------------------------------------------------ storage

    def _blocks(self) -> list[slice]:
        return [slice(i, min(i + BLOCK, self.pixels)) for i in range(0, self.pixels, BLOCK)]

    def _ranks(self) -> NDArray[np.int32]:
        """Where each pixel is stored, if not at its own number."""
        if self._rank is None:
            if self._order is None or len(self._order) != self.pixels:
                raise ValueError("the film's order does not list every pixel once")
            self._rank = np.empty(self.pixels, np.int32)
            self._rank[self._order] = np.arange(self.pixels, dtype=np.int32)
        return self._rank

    def _gather(self, pixels: slice | NDArray[np.integer]) -> exact_sum.Where:
        return pixels if self._order is None else self._ranks()[pixels]

    def _stored_pixels(self) -> exact_sum.Where:
        return slice(0, self.pixels) if self._order is None else self._order


def overlapping(a: Ranges, b: Ranges) -> tuple[int, int] | None:
    """The first range (first, count) that is in both, or None."""
    for first, count in a:
        for other_first, other_count in b:
            low, high = max(first, other_first), min(first + count, other_first + other_count)
            if low < high:
                return low, high - low
    return None


def _joined(ranges: Ranges) -> Ranges:
    """Sorted, merged where they touch or overlap."""
    result: list[tuple[int, int]] = []
    for first, count in sorted(ranges):
        if result and first <= sum(result[-1]):
            start = result[-1][0]
            result[-1] = start, max(sum(result[-1]), first + count) - start
        elif count:
            result.append((first, count))
    return tuple(result)
