"""The beam of a spot: a smooth step in the cosine of the lamp's own, possibly scaled, space.

    z = −ω_local.z / |ω_local|,  ω_local = M⁻¹ ω        ω from the lamp to the lit point, M the lamp's matrix
    beam = s²(3 − 2s),  s = clamp((z − cos ½size) / ((1 − cos ½size) · blend))

as Cycles does (`kernel/light/spot.h`). Scaling the lamp therefore makes the beam elliptic. The light's
size itself, its radiance and its sampling are those of a point lamp (point.py).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .base import Float32, Index, Lamp, at, columns, scalars


class Beam:
    """The beams of K spots."""

    def __init__(self, lamps: Sequence[Lamp]) -> None:
        inverse = [np.linalg.pinv(lamp.linear) for lamp in lamps]
        self._x, self._y, self._z = (columns([m[axis] for m in inverse]) for axis in range(3))
        cos_half = np.cos([0.5 * lamp.data.spot_size for lamp in lamps])
        blend = np.array([max(lamp.data.spot_blend, 0.0) for lamp in lamps])
        self._cos_half = scalars(cos_half)
        self._steepness = scalars(1.0 / np.maximum((1.0 - cos_half) * blend, 1e-9))

    def __call__(self, row: Index | None, wo: Float32) -> Float32:
        """(N,) attenuation in [0, 1] toward −wo; `wo` (3, N) points from the lit point to the lamp."""
        mx, my, mz = at(self._x, row), at(self._y, row), at(self._z, row)
        x = mx[0] * wo[0] + mx[1] * wo[1] + mx[2] * wo[2]
        y = my[0] * wo[0] + my[1] * wo[1] + my[2] * wo[2]
        z = mz[0] * wo[0] + mz[1] * wo[1] + mz[2] * wo[2]
        z /= np.sqrt(np.maximum(x * x + y * y + z * z, 1e-30))
        s = (z - at(self._cos_half, row)) * at(self._steepness, row)
        s = np.clip(s, 0.0, 1.0)
        return s * s * (3.0 - 2.0 * s)
