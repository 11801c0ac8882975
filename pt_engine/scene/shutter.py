"""The shutter: uniform numbers become times, in proportion to how far it is open.

With the openness s(t) piecewise linear, F(t) = ∫₀ᵗ s / ∫₀¹ s is quadratic in each piece and inverted exactly:
from a knot with s = a, where s grows by g over a width h, the area A is reached after

    x = 2A / (a + √(a² + 2Ag/h))        (the root's form that does not cancel, and holds at g = 0)
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


class Shutter:
    """Times between opening (0) and closing (1).

    Parameters
    ----------
    openness : (n,) float
        At n ≥ 2 even times, linear between. What is negative or not finite is closed; a shutter that is
        closed all the time is taken as open.
    """

    def __init__(self, openness: NDArray[np.floating]) -> None:
        s = np.nan_to_num(np.asarray(openness, np.float64), nan=0.0, posinf=0.0, neginf=0.0)
        s = np.maximum(s, 0.0)
        if not s.any():
            s = np.ones(2)
        self._s, self._width = s, 1.0 / (len(s) - 1)
        self._area = np.concatenate([[0.0], np.cumsum((s[1:] + s[:-1]) * (self._width / 2))])

    def time(self, u: float) -> float:
        """The t with F(t) = u, for u in [0, 1]."""
        wanted = u * float(self._area[-1])
        k = int(np.searchsorted(self._area, wanted, side="right")) - 1
        k = min(max(k, 0), len(self._s) - 2)
        area = max(wanted - float(self._area[k]), 0.0)
        a, growth = float(self._s[k]), float(self._s[k + 1] - self._s[k])
        root = math.sqrt(max(a * a + 2 * area * growth / self._width, 0.0))
        x = 2 * area / (a + root) if a + root > 0 else 0.0
        return min(k * self._width + min(x, self._width), 1.0)
