"""IES files: how strongly a luminaire shines in each direction, by the photometric standard LM-63.

Angles are made those of type C: vertical from 0 (down) to 180, horizontal all around. Between them the
values are interpolated by cubics through four neighbours in both angles, as in Blender, which also says what
lies past the table's ends: nothing.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]
Int = NDArray[np.intp]
F = np.float32

CANDELA_TO_WATTS: Final = 0.0706650768394  # 4π / 177.83 lm/W, the efficacy of daylight D65
UNREADABLE: Final = F(100)  # what Blender shines with for a file that it cannot read
NUMBER: Final = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)")
WHOLE: Final = re.compile(r"\s*([+-]?\d+)")
CLOSE: Final = 1e-4  # degrees


class IesError(ValueError):
    """The text is not that of an IES file."""


class Numbers:
    """Reads one number after the other, as C's strtod and strtol do."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0

    def next(self, pattern: re.Pattern[str] = NUMBER) -> float:
        """The number that follows."""
        found = pattern.match(self.text, self.at)
        if found is None:
            raise IesError("a number is missing")
        self.at = found.end()
        return float(found[1])

    def whole(self) -> int:
        """The whole number that follows."""
        return int(self.next(WHOLE))

    def several(self, count: int) -> list[float]:
        """The `count` numbers that follow."""
        return [self.next() for _ in range(count)]


class Luminaire:
    """Light distribution of one IES file.

    Attributes
    ----------
    vertical, horizontal : (V,), (H,) float32
        Radians, ascending.
    watts : (H, V) float32
    """

    def __init__(self, text: str) -> None:
        vertical, horizontal, values, kind = parsed(text)
        v, h, w = {1: of_type_c, 2: of_type_b, 3: of_type_a}[kind](vertical, horizontal, values)
        self.vertical, self.horizontal = (np.array(a, np.float32) * F(np.pi / 180) for a in (v, h))
        self.watts = np.array(w, np.float32)

    def strength(self, horizontal: Float32, vertical: Float32) -> Float32:
        """(n,) at angles in radians; 0 outside of the table."""
        h, v = self.horizontal, self.vertical
        if len(h) < 2 or len(v) < 2:  # no interval, nothing to be within
            return np.zeros_like(vertical)
        within = (vertical >= v[0]) & (vertical < v[-1]) & (horizontal >= h[0]) & (horizontal < h[-1])
        around = bool(h[0] < 1e-7 and h[-1] > F(2 * np.pi) - F(1e-7))  # in float32: strictly past a full turn
        i, s = located(h, horizontal)
        j, t = located(v, vertical)
        low, high = bool(v[0] < 1e-7), bool(v[-1] > F(np.pi) - F(1e-7))
        inner = (self._column(i, j, t, low, high), self._column(i + 1, j, t, low, high))
        first, last = i > 0, i + 2 < len(h)
        before = self._column(np.where(first, i - 1, len(h) - 2 if around else i), j, t, low, high)
        after = self._column(np.where(last, i + 2, 1 if around else i), j, t, low, high)
        out: Float32 = np.maximum(cubic(before, *inner, after, s), F(0)) * within
        return out

    def _column(self, i: Int, j: Int, t: Float32, low: bool, high: bool) -> Float32:
        """Between vertical angles; past a pole as on this side of it, for luminaires are symmetric."""
        count = len(self.vertical)
        before = np.where(j > 0, j - 1, 1 if low else j)
        after = np.where(j + 2 < count, j + 2, count - 2 if high else j + 1)
        a, b, c, d = (self.watts[i, k] for k in (before, j, j + 1, after))
        return cubic(a, b, c, d, t)


def cubic(a: Float32, b: Float32, c: Float32, d: Float32, x: Float32) -> Float32:
    """Catmull–Rom between b and c."""
    out: Float32 = F(0.5) * (((d + 3 * (b - c) - a) * x + (2 * a - 5 * b + 4 * c - d)) * x + (c - a)) * x + b
    return out


def located(angles: Float32, x: Float32) -> tuple[Int, Float32]:
    """Interval that holds x, and the share of it below x."""
    i = np.clip(np.searchsorted(angles, x, side="left") - 1, 0, len(angles) - 2)
    return i, ((x - angles[i]) / (angles[i + 1] - angles[i])).astype(np.float32, copy=False)


Table = list[list[float]]  # a row of values over the vertical angles for each horizontal angle


def parsed(text: str) -> tuple[list[float], list[float], Table, int]:
    """Vertical angles, horizontal angles, values in watts, and the type (1 C, 2 B, 3 A)."""
    text = text.replace(",", " ")
    start = text.find("\nTILT=")
    if start < 0:
        raise IesError("no TILT")
    if text.startswith("\nTILT=INCLUDE", start):
        read = Numbers(text[start + 13 :])
        read.next()  # how the lamp is mounted
        read.several(2 * read.whole())  # the tilts and their factors
        read.at += 1
    else:
        line = text.find("\n", start + 1)
        read = Numbers(text[line + 1 :] if line >= 0 else "")
    read.whole(), read.next()  # lamps, lumens of each
    factor = read.next()
    count_v, count_h, kind = read.whole(), read.whole(), read.whole()
    if kind not in (1, 2, 3):
        raise IesError(f"type {kind} is not known")
    read.whole(), read.several(3)  # size of the opening
    factor *= read.next() * read.next()  # ballast
    read.next()  # watts that it takes
    vertical, horizontal = read.several(count_v), read.several(count_h)
    values = [[CANDELA_TO_WATTS * factor * x for x in read.several(count_v)] for _ in range(count_h)]
    if not vertical or not horizontal:
        raise IesError("no angles")
    return vertical, horizontal, values, kind


def close(a: float, b: float) -> bool:
    """The same angle."""
    return abs(a - b) < CLOSE


def of_type_a(v: list[float], h: list[float], w: Table) -> tuple[list[float], list[float], Table]:
    """Car lamps: vertical −90 to 90, horizontal −90 to 90, or 0 to 90 and mirrored."""
    horizontal, values = [180 - a for a in reversed(h)], w[::-1]
    if close(h[0], 0):
        horizontal, values = horizontal + [180 + a for a in h[1:]], values + w[1:]
    return [a + 90 for a in v], horizontal, values


def of_type_b(v: list[float], h: list[float], w: Table) -> tuple[list[float], list[float], Table]:
    """Floodlights: the polar axis is horizontal, so the angles change places."""
    horizontal, vertical, values = list(v), list(h), [list(column) for column in zip(*w, strict=True)]
    if close(horizontal[0], 0):
        values = values[:0:-1] + values
        horizontal = [90 - a for a in horizontal[:0:-1]] + [90 + a for a in horizontal]
    else:
        horizontal = [a + 90 for a in horizontal]
    if close(vertical[0], 0):
        values = [row[:0:-1] + row for row in values]
        vertical = [90 - a for a in vertical[:0:-1]] + [90 + a for a in vertical]
    else:
        vertical = [a + 90 for a in vertical]
    return vertical, horizontal, values


def of_type_c(v: list[float], h: list[float], w: Table) -> tuple[list[float], list[float], Table]:
    """All others: horizontal angles over a quadrant, a half or all around, or one where it is round."""
    h = [a - 90 for a in h] if close(h[0], 90) else list(h)
    if len(h) == 1:
        h, w = [0.0, 360.0], [w[0], w[0]]
    for end, whole in ((90, 180), (180, 360)):
        if close(h[-1], end):
            h, w = h + [whole - a for a in h[-2::-1]], w + w[-2::-1]
    if close(h[0], 0) and not close(h[-1], 360) and len(h) > 1:
        gap = 360 - h[-1]
        if close(h[-1] - h[-2], gap) or close(h[1] - h[0], gap):
            h, w = [*h, 360.0], [*w, w[0]]
    return list(v), h, w


@lru_cache(maxsize=64)
def luminaire(text: str) -> Luminaire | None:
    """The luminaire of a file's text; None where it is not understood."""
    try:
        return Luminaire(text)
    except (IesError, ValueError, OverflowError):
        return None
