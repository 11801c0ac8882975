"""Random numbers as functions take them: an array, or rows that are made only when somebody asks.

A surface with one closure chooses no lobe, a scene with one lamp no lamp: such numbers are never made.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, overload

import numpy as np
from numpy.typing import NDArray

Float32 = NDArray[np.float32]


class LazyRows:
    """(count, N) float32 whose rows are made when first read, and kept.

    Reads like the array: `u[0]` is a row, `u[:, lanes]` all rows of some lanes, `_, v, w = u` unpacks.

    Parameters
    ----------
    make : callable
        Number of a row → its (N,) values.
    count : int
    """

    def __init__(self, make: Callable[[int], Float32], count: int) -> None:
        self._make = make
        self._rows: list[Float32 | None] = [None] * count

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, key: int) -> Float32: ...
    @overload
    def __getitem__(self, key: tuple[slice, Any]) -> LazyRows: ...
    def __getitem__(self, key: int | tuple[slice, Any]) -> Float32 | LazyRows:
        if isinstance(key, tuple):
            lanes = key[1]
            return LazyRows(lambda k: self[k][lanes], len(self))
        row = self._rows[key]
        if row is None:
            row = self._rows[key] = self._make(key)
        return row


Uniforms: TypeAlias = Float32 | LazyRows
