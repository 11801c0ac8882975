"""The film: what the samples of each pixel add up to, exactly.

Per pixel it keeps sums (see `exact_sum`), the sum of alpha in steps of 2⁻²⁴, and the count of samples.

    independent samples    sums and sums of squares of every channel                              108 bytes
    correlated samples     sums of every channel in halves A and B, one sum of squares of all     128 bytes

8 bytes more where pixels are stored in an order of their own. A is the even samples, B the odd ones: see
`film_error` for what they tell. Since sums are exact, adding samples in any order, in any chunks, on any
number of films merged in any order, gives the very same bits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from ..core.rows import columns
from . import exact_sum
from .film_error import ErrorEstimate, estimate_error
from .film_moments import SQUARE_SCALE, Moments, Sums, moments_of
from .film_noise import bands, moments_by_band, pixel_variance
from .sample_ranges import Ranges, joined, overlapping

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]

ALPHA_STEPS = 2.0**24
BLOCK = 1 << 16  # pixels that are worked on at a time, to keep temporaries small


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
    correlated : bool
        Whether even samples of a pixel know of each other, and odd ones (Sobol points).
    halves : bool
        Whether A and B are kept apart where samples are independent, too: 52 bytes a pixel.

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
        correlated: bool = False,
        halves: bool = False,
    ) -> None:
        if width < 1 or height < 1:
            raise ValueError(f"a film needs at least one pixel, not {width} × {height}")
        self.width, self.height, self.key = int(width), int(height), key
        self.reject_negative = reject_negative
        self.correlated, self.halves = correlated, correlated or halves
        self.dropped = 0
        self.ranges: Ranges = ()
        n = self.pixels
        # Rows: red, green, blue, of all or of half A; of half B; and the squares, of each or all together.
        self._squares = 6 if self.halves else 3
        rows = self._squares + (1 if correlated else 3)
        self._high, self._low = np.zeros((rows, n)), np.zeros((rows, n))
        self._alpha: Float64 | None = None  # None: every sample had 1
        self._count = np.zeros(n, np.uint32)
        self._count_b = np.zeros(n if self.halves else 0, np.uint32)
        self._order = order
        self._rank: NDArray[np.int32] | None = None
        self._runs: dict[int, int] = {}

    @property
    def pixels(self) -> int:
        """How many there are."""
        return self.width * self.height

    @property
    def rows(self) -> int:
        """Sums that are kept of each pixel."""
        return len(self._high)

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
        self.ranges = joined((*self.ranges, (int(first), int(count))))
        bad = self._refused(radiance, alpha)
        if bad.size:
            self.dropped += int(bad.size)
            radiance = radiance.copy()
            radiance[:, bad] = 0
            if alpha is not None:
                alpha = alpha.copy()
                alpha[bad] = 0
        self._add_counts(where, first, count, m, bad)
        self._add_alpha(where, alpha, count, m, bad)
        self._add_radiance(where, first, radiance.reshape(3, count, m))
        return bad

    def _add_counts(
        self, where: exact_sum.Where, first: int, count: int, m: int, bad: NDArray[np.intp]
    ) -> None:
        self._count[where] += np.uint32(count)
        if self.halves:
            self._count_b[where] += np.uint32((first + count) // 2 - first // 2)
        if bad.size:
            self._count[where] -= np.bincount(bad % m, minlength=m).astype(np.uint32)
        if bad.size and self.halves:
            odd = bad[(bad // m + first) % 2 == 1]
            self._count_b[where] -= np.bincount(odd % m, minlength=m).astype(np.uint32)

    def _add_radiance(self, where: exact_sum.Where, first: int, radiance: Float32) -> None:
        """`radiance`: (3, count, m) of samples from `first` on."""
        together = np.zeros(radiance.shape[1:]) if self.correlated else None
        largest_of_all = 0.0
        for channel, values in enumerate(radiance):
            largest = max(float(values.max(initial=0)), -float(values.min(initial=0)))
            terms = values.astype(np.float64)
            squares = terms * SQUARE_SCALE
            squares *= terms
            if together is None:
                row, square = self._squares + channel, largest * largest * SQUARE_SCALE
                exact_sum.add(self._high[row], self._low[row], where, squares, square)
            else:
                together += squares
                largest_of_all += largest * largest * SQUARE_SCALE
            for half in range(2 if self.halves else 1):
                row = channel + 3 * half
                part = np.ascontiguousarray(terms[(first + half) % 2 :: 2]) if self.halves else terms
                if len(part):
                    exact_sum.add(self._high[row], self._low[row], where, part, largest)
        if together is not None:
            exact_sum.add(self._high[-1], self._low[-1], where, together, largest_of_all)

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
        if self.halves != other.halves:
            raise ValueError("one of these films keeps halves A and B, the other does not")
        overlap = overlapping(self.ranges, other.ranges)
        if overlap is not None:
            raise ValueError(f"both films hold samples {overlap[0]} to {sum(overlap) - 1}")
        self.ranges = joined(self.ranges + other.ranges)
        self.dropped += other.dropped
        theirs = slice(None) if self._order is other._order else other._gather(self._stored_pixels())
        for row in range(len(self._high)):
            exact_sum.merge(
                self._high[row], self._low[row], other._high[row][theirs], other._low[row][theirs]
            )
        if self._alpha is not None or other._alpha is not None:
            mine = self._count.astype(np.float64) if self._alpha is None else self._alpha
            more = other._count.astype(np.float64) if other._alpha is None else other._alpha
            self._alpha = mine + more[theirs]
        self._count += other._count[theirs]
        if self.halves:
            self._count_b += other._count_b[theirs]

    # ------------------------------------------------------------------ out

    def image(self) -> Float32:
        """Mean radiance and alpha: (height, width, 4) float32, bottom row first; 0 without samples."""
        image = np.empty((self.pixels, 4), np.float32)
        for part in self._blocks():
            sums = self.sums(part)
            count = np.maximum(sums.samples, 1)
            image[part, :3] = (sums.total / count).T
            if self._alpha is None:
                image[part, 3] = sums.samples > 0
            else:
                image[part, 3] = self._alpha[self._gather(part)] / count
        return image.reshape(self.height, self.width, 4)

    def half(self, number: int) -> Float32:
        """Mean radiance of half 0 (A, even samples) or 1 (B): (height, width, 3) float32, 0 if empty."""
        if not self.halves:
            raise ValueError("this film keeps no halves")
        image = np.empty((self.pixels, 3), np.float32)
        for part in self._blocks():
            sums = self.sums(part)
            count, total = sums.half(number)
            image[part] = (total / np.maximum(count, 1)).T
        return image.reshape(self.height, self.width, 3)

    def mean(self) -> float:
        """Of the image, over pixels and channels."""
        total = 0.0
        for part in self._blocks():
            sums = self.sums(part)
            total += float((sums.total / np.maximum(sums.samples, 1)).sum())
        return total / (3 * max(self.pixels, 1))

    def counts(self) -> NDArray[np.uint32]:
        """Samples of each pixel: (height, width) uint32."""
        return self._count[self._gather(slice(0, self.pixels))].reshape(self.height, self.width)

    def variance_of_mean(self) -> Float64:
        """Variance of each pixel's mean: (height, width, 3) float64, NaN below two samples.

        s²/n with the unbiased s² where samples are independent. For correlated ones its shape over the image
        is kept, and its size is taken from the halves of the pixels around: see `film_noise`.
        """
        result = np.empty((self.height, self.width, 3))
        for y0, y1 in bands(self):
            result[y0:y1] = pixel_variance(self, y0, y1)
        return result

    def standard_error(self) -> Float32:
        """Of each pixel's mean: (height, width, 3) float32, NaN below two samples."""
        return np.sqrt(self.variance_of_mean()).astype(np.float32)

    def sums(self, pixels: slice) -> Sums:
        """What is kept of a run of pixel numbers, in one memory layout whatever the storage."""
        stored = self._gather(pixels)
        high, low = (columns(rows, stored) for rows in (self._high, self._low))
        # numpy's own sums depend on the layout in the last bit
        total = np.ascontiguousarray(high + low)
        if not self.halves:
            return Sums(self._count[stored], total[:3], total[3:], self.correlated)
        whole = high[:3] + high[3:6]
        whole += low[:3] + low[3:6]  # rounded once: the very bits of a film without halves
        return Sums(
            self._count[stored],
            np.ascontiguousarray(whole),
            total[6:],
            self.correlated,
            total[:3],
            total[3:6],
            self._count_b[stored],
        )

    def moments(self, pixels: slice) -> Moments:
        """Means and their variances for a run of pixel numbers."""
        return moments_of(self.sums(pixels))

    def error(self) -> ErrorEstimate:
        """How wrong the image is: `mse`, `relmse`, `rmse`, each with its `_ci95`: see `film_error`."""
        return estimate_error(moments_by_band(self), self.mean())

    def state(self) -> dict[str, NDArray[np.generic]]:
        """The arrays that make the film, in the order of pixel numbers."""
        stored = self._gather(slice(0, self.pixels))
        high, low = exact_sum.canonical(self._high, self._low)
        arrays: dict[str, NDArray[np.generic]] = {
            "high": np.ascontiguousarray(high[:, stored]),
            "low": np.ascontiguousarray(low[:, stored]),
            "count": self._count[stored],
        }
        if self.halves:
            arrays["count_b"] = self._count_b[stored]
        if self._alpha is not None:
            arrays["alpha"] = self._alpha[stored]
        return arrays

    def restore(
        self,
        high: Float64,
        low: Float64,
        count: NDArray[np.uint32],
        count_b: NDArray[np.uint32] | None = None,
        alpha: Float64 | None = None,
    ) -> None:
        """Take over arrays as `state` gives them."""
        stored = self._stored_pixels()
        self._high, self._low, self._count = high[:, stored], low[:, stored], count[stored]
        if count_b is not None:
            self._count_b = count_b[stored]
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
