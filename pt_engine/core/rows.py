"""Named rows of one flat buffer, so that a whole set of lanes moves with a single take.

    class PathState(Rows, float_rows=(("beta", 3), ("pdf", 1)), int_rows=(("slot", 1),)): ...

gives `state.beta` as a (3, N) float32 view, `state.slot` as an (N,) int32 view of the same buffer.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray


class Rows:
    """Base of structs of arrays that live in one (R, N) float32 buffer."""

    ROWS: ClassVar[int]

    def __init_subclass__(
        cls,
        float_rows: Sequence[tuple[str, int]] = (),
        int_rows: Sequence[tuple[str, int]] = (),
        **kwargs: Any,
    ) -> None:
        super().__init_subclass__(**kwargs)
        first = 0
        for is_int, rows in ((False, float_rows), (True, int_rows)):
            for name, count in rows:
                setattr(cls, name, _row_view(first, count, is_int))
                first += count
        cls.ROWS = first

    def __init__(self, data: NDArray[np.float32]) -> None:
        self.data = data
        self.integers = data.view(np.int32)

    @classmethod
    def empty(cls, n: int) -> Self:
        """Uninitialised rows for `n` lanes."""
        return cls(np.empty((cls.ROWS, n), np.float32))

    @property
    def size(self) -> int:
        """Number of lanes."""
        return int(self.data.shape[1])

    def take(self, index: NDArray[np.intp]) -> Self:
        """The lanes at `index`, in that order, in a new contiguous buffer."""
        return type(self)(self.data.take(index, axis=1, mode="wrap"))

    def part(self, span: slice) -> Self:
        """A view of consecutive lanes."""
        return type(self)(self.data[:, span])

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """All lanes of some parts, one part after the other."""
        return cls(np.concatenate([part.data for part in parts], axis=1))


def _row_view(first: int, count: int, is_int: bool) -> property:
    where: int | slice = first if count == 1 else slice(first, first + count)

    def get(self: Rows) -> NDArray[Any]:
        view: NDArray[Any] = (self.integers if is_int else self.data)[where]
        return view

    def put(self: Rows, value: Any) -> None:
        (self.integers if is_int else self.data)[where] = value

    return property(get, put)


def scatter(target: NDArray[Any], lanes: NDArray[np.integer], values: NDArray[Any]) -> None:
    """target[:, lanes] = values, row by row: numpy's two-dimensional form takes three times as long."""
    lanes = lanes.astype(np.intp, copy=False)  # once, not a row at a time
    for row, value in zip(target, values, strict=True):
        row[lanes] = value


def scatter_add(target: NDArray[Any], lanes: NDArray[np.integer], values: NDArray[Any]) -> None:
    """target[:, lanes] += values for lanes that are all different, row by row."""
    lanes = lanes.astype(np.intp, copy=False)
    for row, value in zip(target, values, strict=True):
        row[lanes] = row.take(lanes, mode="wrap") + value


def columns(rows: NDArray[Any], where: slice | NDArray[np.integer]) -> NDArray[Any]:
    """rows[:, where]: numpy's indexing of two dimensions takes three times as long as a take."""
    return rows[:, where] if isinstance(where, slice) else rows.take(where, axis=1, mode="wrap")
