"""Which of many small numbers belong to a set of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.unsignedinteger] | NDArray[np.integer]
FEW = 4  # comparisons of bytes that take no longer than a look-up


class Subset:
    """A set of numbers below n.

    Parameters
    ----------
    member : (n,) bool
    """

    def __init__(self, member: NDArray[np.bool_]) -> None:
        self._member = member
        self._few = np.flatnonzero(member).tolist()
        self.empty = not self._few

    def has(self, numbers: Numbers) -> NDArray[np.bool_]:
        """(N,) whether each of `numbers` (N,) is in the set."""
        if self.empty or len(self._few) > FEW:
            return self._member.take(numbers, mode="clip")
        found: NDArray[np.bool_] = numbers == self._few[0]
        for number in self._few[1:]:
            found |= numbers == number
        return found
