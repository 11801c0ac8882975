"""Random numbers as functions take them: an array, or rows that are made only when somebody asks.

A surface with one closure chooses no lobe, a scene with one lamp no lamp: such numbers are never made.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias, overload

import numpy as np
from numpy.typing import NDArray

from .rows import columns

Float32 = NDArray[np.float32]


class LazyRows:
    """(count, N) float32 whose rows are made when first read, and kept.

    Reads like the array: `u[0]` is a row, `u[:, lanes]` all rows of some lanes, `_, v, w = u` unpacks.

    Parameters
    ----------
    parts : (count, make) each
        So many rows, which are made together: `make()` → (count, N).
    """

    def __init__(self, *parts: tuple[int, Callable[[], Float32]]) -> None:
        self._parts = parts
        self._made: list[Float32 | None] = [None] * len(parts)
        self._where = [(part, row) for part, (count, _) in enumerate(parts) for row in range(count)]

    def __len__(self) -> int:
        return len(self._where)

    @overload
    def __getitem__(self, key: int) -> Float32: ...
    @overload
    def __getitem__(self, key: tuple[slice, Any]) -> LazyRows: ...
    def __getitem__(self, key: int | tuple[slice, Any]) -> Float32 | LazyRows:
        if isinstance(key, tuple):
            return self._of(key[1])
        part, number = self._where[key]
        row: Float32 = self._rows(part)[number]
        return row

    def _rows(self, part: int) -> Float32:
        rows = self._made[part]
        if rows is None:
            rows = self._made[part] = self._parts[part][1]()
        return rows

    def _of(self, lanes: Any) -> LazyRows:
        parts = enumerate(self._parts)
        return LazyRows(*((count, partial(self._some, part, lanes)) for part, (count, _) in parts))

    def _some(self, part: int, lanes: Any) -> Float32:
        return columns(self._rows(part), lanes)


Uniforms: TypeAlias = Float32 | LazyRows
