"""Spots: point lamps (point.py) times a beam, a smooth step in the cosine of the lamp's own, scaled space.

    z = −ω_local.z / |ω_local|,  ω_local = M⁻¹ ω        ω from the lamp to the lit point, M the lamp's matrix
    beam = s²(3 − 2s),  s = clamp((z − cos ½size) / ((1 − cos ½size) · blend))

as Cycles does (kernel/light/spot.h). Scaling the lamp therefore makes the beam elliptic. A spot with size
has the beam's value in the direction of the ray at every point of its sphere; from inside the sphere it
shines everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core.vectors import dot
from .base import Draw, Float32, Float64, Hits, Index, Lamp, at, columns, of_met, rows_met, scalars
from .point import TWO_PI, DeltaPoints, DiskLamps, SphereLamps, around

NARROWEST = 1e-12  # 1 − cos of a beam: a closed one is drawn from, too, though it brings nothing


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
        x, y, z = dot(at(self._x, row), wo), dot(at(self._y, row), wo), dot(at(self._z, row), wo)
        z /= np.sqrt(np.maximum(x * x + y * y + z * z, 1e-30))
        s: Float32 = (z - at(self._cos_half, row)) * at(self._steepness, row)
        s = np.clip(s, 0.0, 1.0)
        return s * s * (3.0 - 2.0 * s)


class DeltaSpots(DeltaPoints):
    """Spots without size."""

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        super().__init__(lamps, chance)
        self._beam = Beam(lamps)

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """As the point lamp, dimmed."""
        draw = super().sample(row, p, u, v)
        return draw._replace(weight=draw.weight * self._beam(row, draw.wo))


class DiskSpots(DiskLamps):
    """Spots with soft falloff."""

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        super().__init__(lamps, chance)
        self._beam = Beam(lamps)

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """As the point lamp, dimmed."""
        draw = super().sample(row, p, u, v)
        return draw._replace(weight=draw.weight * self._beam(row, draw.wo))

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """As the point lamp, dimmed."""
        hits = super().hits(row, o, d, t)
        return hits._replace(
            radiance=hits.radiance * self._beam(rows_met(row, hits.lanes), d.take(hits.lanes, axis=1))
        )


def widest(lamp: Lamp) -> float:
    """1 − cos of the half angle of a round cone that holds the whole beam."""
    length = np.sqrt((lamp.linear**2).sum(axis=0))
    half = min(0.5 * lamp.data.spot_size, 0.5 * float(np.pi))
    slope = np.tan(half) * max(length[0], length[1]) / max(length[2], 1e-12)
    sin_half_angle = np.sin(0.5 * np.arctan(slope))
    return float(2.0 * sin_half_angle**2)


class SphereSpots(SphereLamps):
    """Spots that are spheres: drawn from the cone of the sphere or from the beam's, whichever is narrower."""

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        super().__init__(lamps, chance)
        self._beam = Beam(lamps)
        self._toward = columns([-lamp.direction for lamp in lamps])
        self._widest = scalars([max(widest(lamp), NARROWEST) for lamp in lamps])

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Uniform directions in the narrower cone; those of the beam's may miss the sphere."""
        to_centre, radius_squared = at(self._centre, row) - p, at(self._radius_squared, row)
        cone = self._cone(to_centre, radius_squared)
        narrow = (cone.one_minus_cos > at(self._widest, row)) & (cone.inside == 0.0)
        by_beam = narrow.astype(np.float32)
        axis = cone.axis + by_beam * (at(self._toward, row) - cone.axis)
        one_minus_max = (1.0 - by_beam) * cone.one_minus_cos + by_beam * at(self._widest, row)
        one_minus_cos = u * one_minus_max
        sin = np.sqrt(one_minus_cos * (2.0 - one_minus_cos))
        wo = around(axis, 1.0 - one_minus_cos, sin, v)

        along = dot(to_centre, wo)
        off = to_centre - along * wo
        discriminant = radius_squared - dot(off, off)
        met = ((discriminant >= 0.0) & (along > 0.0)) | ~narrow
        t = along + (2.0 * cone.inside - 1.0) * np.sqrt(np.maximum(discriminant, 0.0))
        solid: Float32 = TWO_PI * one_minus_max
        shine = solid * np.maximum(self._beam(row, wo), cone.inside) * met
        pdf = at(self._chance, row) / solid * met
        return Draw(wo, np.maximum(t, 0.0), at(self._weight, row) * shine, pdf)

    def hits(self, row: int | Index, o: Float32, d: Float32, t: Float32) -> Hits:
        """As a sphere, dimmed but from inside."""
        lanes, cone = self._meet(row, o, d, t)
        d = d.take(lanes, axis=1)
        beam = np.maximum(self._beam(rows_met(row, lanes), d), cone.inside)
        widest = of_met(self._widest, row, lanes)
        by_sphere = cone.one_minus_cos <= widest + 2.0 * cone.inside
        solid: Float32 = np.float32(TWO_PI) * np.minimum(cone.one_minus_cos, widest + 2.0 * cone.inside)
        off = d - of_met(self._toward, row, lanes)  # |d − w|² = 2(1 − cos) keeps its digits
        drawn = by_sphere | (dot(off, off) <= 2.0 * widest)
        radiance = of_met(self._strength, row, lanes) * beam
        return Hits(lanes, radiance, of_met(self._chance, row, lanes) / solid * drawn)
