"""Clamping: what one sample may bring at most, as Cycles does it (off unless asked for: it is biased).

    contribution · min(1, 3 limit / Σ|channels|)        direct light: one bounce at most; indirect: more

Each contribution to a path's radiance is clamped by itself, with its throughput and what the way to the light
lets through. Bright samples (fireflies) lose energy, always in the same direction: no number of samples
brings it back.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .settings import RenderSettings

Float32 = NDArray[np.float32]


class Clamp(NamedTuple):
    """Largest mean of the channels of a contribution, W·m⁻²·sr⁻¹; ∞ where it is not clamped."""

    direct: float
    indirect: float

    def applied(self, radiance: Float32, bounces: NDArray[np.integer]) -> Float32:
        """Contributions (3, N) of light after so many bounces (N,), clamped."""
        limit = np.where(bounces > 1, np.float32(3 * self.indirect), np.float32(3 * self.direct))
        total = np.abs(radiance).sum(axis=0)
        over = total > limit  # an infinite limit has no quotient
        one = np.float32(1)
        scaled: Float32 = radiance * np.where(over, limit, one)
        scaled /= np.where(over, total, one)
        return scaled


def clamp_of(settings: RenderSettings) -> Clamp | None:
    """None where nothing is clamped: then nothing is paid."""
    if not settings.clamp_direct and not settings.clamp_indirect:
        return None
    return Clamp(settings.clamp_direct or np.inf, settings.clamp_indirect or np.inf)
