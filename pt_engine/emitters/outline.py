"""What a light tree has to know of every emitter: where it is, how bright, and to which side it shines.

After Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting": a box,
a cone that holds the emitter's axes (half angle θo), and how far from them it still shines (θe). Here
intensity takes the place of their power, so that lamps, spots and faces compare by what they send somewhere:

    I = Φ / 4π for points and spots      Φ / π for one-sided areas      Φ / 2π for faces, both sides
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from . import area
from .base import Float64, Lamp

PI = float(np.pi)
NARROW = 0.3  # rad; a narrower half spread does not make a lamp any brighter here


class Outlines(NamedTuple):
    """Of M emitters or groups of them.

    Attributes
    ----------
    low, high : (M, 3) float64
        Box around them.
    intensity : (M,) float64
        W/sr, mean of the colour channels, along the axis.
    axis : (M, 3) float64
        Unit.
    spread : (M,) float64
        θo; π where there is no axis to speak of.
    reach : (M,) float64
        θe, of emission around an axis; it falls with the cosine.
    twofold : (M,) bool
        They shine along −axis as well.
    """

    low: Float64
    high: Float64
    intensity: Float64
    axis: Float64
    spread: Float64
    reach: Float64
    twofold: NDArray[np.bool_]

    def take(self, rows: NDArray[np.integer]) -> Self:
        """Those at `rows`."""
        return type(self)(*(column[rows] for column in self))


def of_lamps(lamps: Sequence[Lamp], power: Float64) -> Outlines:
    """Lamps that are somewhere: no suns."""
    centre = np.array([lamp.centre for lamp in lamps]).reshape(-1, 3)
    half = np.array([half_extent(lamp) for lamp in lamps]).reshape(-1, 3)
    axis = np.array([lamp.direction for lamp in lamps]).reshape(-1, 3)
    is_area = np.array([lamp.data.kind == "AREA" for lamp in lamps], np.bool_)
    spread = np.array([0.0 if lamp.data.kind == "AREA" else beam(lamp) for lamp in lamps])
    reach = np.array([area.half_spread(lamp) if lamp.data.kind == "AREA" else 0.0 for lamp in lamps])
    intensity = power / np.where(is_area, PI, 4.0 * PI)
    alpha = np.maximum(reach, NARROW)  # toward the axis a spread gathers what it takes from the sides
    narrow = is_area & (alpha < 0.5 * PI)
    tan = np.tan(np.where(narrow, alpha, 1.0))
    intensity = intensity * np.where(narrow, tan / (tan - np.where(narrow, alpha, 1.0)), 1.0)
    return Outlines(
        centre - half, centre + half, intensity, axis, spread, reach, np.zeros(len(lamps), np.bool_)
    )


def half_extent(lamp: Lamp) -> Float64:
    """(3,) half the size of the lamp's box."""
    if lamp.data.kind != "AREA":
        return np.full(3, max(lamp.data.radius, 0.0))
    x, y = lamp.data.size
    y = x if lamp.data.shape in ("SQUARE", "DISK") else y
    return 0.5 * (np.abs(lamp.linear[:, 0]) * abs(x) + np.abs(lamp.linear[:, 1]) * abs(y))


def beam(lamp: Lamp) -> float:
    """Half the angle that a point or spot shines into."""
    if lamp.data.kind != "SPOT":
        return PI
    length = np.sqrt((lamp.linear**2).sum(axis=0))
    half = 0.5 * lamp.data.spot_size
    if half >= 0.5 * PI:
        return PI
    return float(np.arctan(np.tan(half) * max(length[0], length[1]) / max(length[2], 1e-12)))


def of_faces(corners: Float64, power: Float64) -> Outlines:
    """Faces by their corners (F, C, 3), the first three not in a line but for faces without an area."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.sqrt((normal**2).sum(axis=1, keepdims=True))
    axis = np.where(length > 0.0, normal / np.maximum(length, 1e-300), (0.0, 0.0, 1.0))
    count = len(corners)
    spread, reach = np.zeros(count), np.full(count, 0.5 * PI)
    low, high = corners.min(axis=1), corners.max(axis=1)
    return Outlines(low, high, power / (2.0 * PI), axis, spread, reach, np.ones(count, np.bool_))


def joined(*parts: Outlines) -> Outlines:
    """All of them, one after the other."""
    return Outlines(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def merged(a: Outlines, b: Outlines) -> Outlines:
    """Boxes and cones around a[k] and b[k]; one that gives no light does not count."""
    alone_a, alone_b = b.intensity <= 0.0, a.intensity <= 0.0
    axis_b = b.axis * np.where(a.twofold & ((a.axis * b.axis).sum(axis=1) < 0.0), -1.0, 1.0)[:, None]
    cos = (a.axis * axis_b).sum(axis=1)
    between = np.arccos(np.clip(cos, -1.0, 1.0))
    wide_a = np.minimum(between + b.spread, PI) <= a.spread
    wide_b = np.minimum(between + a.spread, PI) <= b.spread
    spread = 0.5 * (a.spread + between + b.spread)
    turn = spread - a.spread
    side = axis_b - cos[:, None] * a.axis
    side /= np.maximum(np.sqrt((side**2).sum(axis=1, keepdims=True)), 1e-12)
    axis = np.cos(turn)[:, None] * a.axis + np.sin(turn)[:, None] * side
    spread = np.where((a.twofold != b.twofold) | (spread > PI), PI, spread)
    cone = Outlines(
        np.minimum(a.low, b.low),
        np.maximum(a.high, b.high),
        a.intensity + b.intensity,
        axis,
        spread,
        np.maximum(a.reach, b.reach),
        a.twofold & b.twofold,
    )
    same = a.twofold == b.twofold
    for chosen, other in (((wide_a & same), a), ((wide_b & same & ~wide_a), b)):
        cone = cone._replace(
            axis=np.where(chosen[:, None], other.axis, cone.axis),
            spread=np.where(chosen, other.spread, cone.spread),
        )
    for chosen, other in ((alone_b, b), (alone_a, a)):
        wide = chosen[:, None]
        cone = Outlines(
            *(np.where(wide if x.ndim == 2 else chosen, x, y) for x, y in zip(other, cone, strict=True))
        )
    return cone
