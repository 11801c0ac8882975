"""What the emitters share: a resolved lamp, what a sample is, and how rows of lamps become lanes.

A *kind* (point.py, spot.py, sun.py, area.py) holds all lamps of one sort as columns of small tables.
Its `sample` draws directions from reference points; its `hits` finds what a given ray sees of one lamp.
The probability that the lamp was chosen is folded into both when the kind is built.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..scene.snapshot import LightData

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Index = NDArray[np.intp]

FAR = 1e30  # distance to what lies at infinity
TINY = 1e-30  # keeps divisions by a squared length finite


class LampShader(Protocol):
    """A node tree that makes a lamp vary."""

    @property
    def brightness(self) -> float:
        """Mean factor."""
        ...

    def factor(self, p: Float32, wo: Float32) -> Float32:
        """(3, n) factor on what points p (3, n) receive from directions wo (3, n)."""
        ...


@dataclass(frozen=True)
class Lamp:
    """A lamp ready to be tabulated.

    Attributes
    ----------
    data : LightData
    strength : (3,) float64
        Power (sun: irradiance) times colour times the node tree's factor.
    centre : (3,) float64
        Relative to the scene's recentring origin.
    shader : LampShader or None
        Another factor, where it varies.
    """

    data: LightData
    strength: Float64
    centre: Float64
    shader: LampShader | None = None

    @property
    def linear(self) -> Float64:
        """(3, 3) local to world, scale included, without the translation."""
        return np.asarray(self.data.matrix, np.float64)[:3, :3]

    @property
    def direction(self) -> Float64:
        """(3,) unit, where the lamp shines: its local -Z in the world."""
        return unit(-self.linear[:, 2], fallback=(0.0, 0.0, -1.0))


NO_LANES: Index = np.empty(0, np.intp)
NO_BARYCENTRIC: Float32 = np.empty((2, 0), np.float32)


class Draw(NamedTuple):
    """Directions to emitters of one sort.

    Attributes
    ----------
    wo : (3, N) float32
        Unit, world space, from the reference point toward the emitter.
    distance : (N,) float32
        How far a shadow ray has to look.
    weight : (3, N) float32
        Radiance / pdf, 0 where the sample failed (then pdf is 0 or meaningless).
    pdf : (N,) float32
        Per solid angle, times the probability of the emitter; of a delta lamp that probability alone.
    varying, triangle, barycentric :
        As in `lights.LightSample`.
    """

    wo: Float32
    distance: Float32
    weight: Float32
    pdf: Float32
    varying: Index = NO_LANES
    triangle: Index = NO_LANES
    barycentric: Float32 = NO_BARYCENTRIC


class Hits(NamedTuple):
    """What rays see of one lamp: lanes (k,), radiance (3, k) and pdf (k,) as in `Draw`; its light group."""

    lanes: Index
    radiance: Float32
    pdf: Float32
    group: int | NDArray[np.integer] = 0


NO_HITS = Hits(NO_LANES, np.empty((3, 0), np.float32), np.empty(0, np.float32))


class Kind(Protocol):
    """Lamps of one sort; `chance` is each one's probability of being chosen."""

    delta: ClassVar[bool]

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None: ...

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Draw from lamp `row[lane]`, or from the only lamp if `row` is None; u, v: (N,) uniforms."""
        ...

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """What rays o + s·d, 0 < s < t, meet of lamp `row`, or each of its own lamp `row[lane]`."""
        ...


def unit(v: Float64, fallback: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Float64:
    """`v` (3,) normalised, or `fallback` where it has no length."""
    length = float(np.sqrt((v * v).sum()))
    return v / length if length > 0.0 else np.asarray(fallback, np.float64)


def columns(vectors: Sequence[Float64]) -> Float32:
    """(3, K) float32 table of K vectors."""
    return np.ascontiguousarray(np.stack(vectors, axis=1), np.float32)


def scalars(values: Sequence[float] | Float64) -> Float32:
    """(K,) float32 table of K numbers."""
    return np.asarray(values, np.float32)


def at(table: Float32, row: Index | None) -> Float32:
    """Columns of a table, one per lane; the table itself, to broadcast, if it has a single column."""
    return table if row is None else table.take(row, axis=-1, mode="wrap")


def one(table: Float32, row: int | Index) -> Float32:
    """Column `row` alone, to broadcast; of several rows, a column each."""
    return table[..., row : row + 1] if isinstance(row, int) else at(table, row)


def of_met(table: Float32, row: int | Index, lanes: Index) -> Float32:
    """A column for each of `lanes`, those of all rays that have met their lamp: `row`, or `row[lane]`."""
    return at(table, rows_met(row, lanes))


def rows_met(row: int | Index, lanes: Index) -> Index:
    """(k,) the lamp that each of `lanes` has met."""
    return np.full(lanes.size, row, np.intp) if isinstance(row, int) else row.take(lanes)
