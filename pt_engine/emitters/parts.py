"""The sorts of emitters that a scene has, each with one way to be sampled: what `Lights` chooses among."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Protocol

import numpy as np

from ..scene.snapshot import Visibility
from . import area, sun
from .base import FAR, Draw, Float32, Float64, Hits, Index, Kind, Lamp
from .ellipse import Ellipses
from .environment import Environment
from .point import DeltaPoints, DiskLamps, SphereLamps, has_size
from .rectangle import Rectangles
from .spot import DeltaSpots, DiskSpots, SphereSpots

POINTS: tuple[type[Kind], ...] = (DeltaPoints, DiskLamps, SphereLamps)
SPOTS: tuple[type[Kind], ...] = (DeltaSpots, DiskSpots, SphereSpots)


class Part(Protocol):
    """Emitters of one sort: `count` of them, found by no ray (`delta`) or by some."""

    @property
    def count(self) -> int: ...
    @property
    def delta(self) -> bool: ...
    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw: ...


def sort_of(lamp: Lamp) -> type[Kind]:
    """The class that samples this lamp."""
    data = lamp.data
    if data.kind == "SUN":
        return sun.DiscSuns if sun.half_angle(lamp) > 0.0 else sun.DeltaSuns
    if data.kind == "AREA":
        if area.is_parallel(lamp):
            return area.RoundBeams if area.is_ellipse(lamp) else area.Beams
        return Ellipses if area.is_ellipse(lamp) else Rectangles
    if data.kind not in ("POINT", "SPOT"):
        raise ValueError(f"lamp {data.name!r} is of unknown kind {data.kind!r}")
    size = 0 if not has_size(lamp) else 1 if data.soft_falloff else 2
    return POINTS[size] if data.kind == "POINT" else SPOTS[size]


def traits(lamp: Lamp) -> tuple[str, str, bool, bool, bool, bool]:
    """Lamps with equal traits are sampled together."""
    data = lamp.data
    spread = data.kind == "AREA" and area.has_spread(lamp)
    return data.kind, sort_of(lamp).__name__, spread, data.use_mis, data.cast_shadow, lamp.shader is not None


class LampPart:
    """Lamps of equal traits.

    Where the user has switched multiple importance sampling or shadows off, rays do not meet the lamp:
    then sampling is alone (`delta`), and without shadows its shadow rays have length −1.
    """

    def __init__(self, lamps: Sequence[Lamp], chance: Float64) -> None:
        data = lamps[0].data
        kind = sort_of(lamps[0])
        self.kind: Kind = kind(lamps, chance)
        self.count = len(lamps)
        self.sized = not kind.delta
        self.delta = kind.delta or not data.use_mis or not data.cast_shadow
        self.camera = tuple(self.sized and bool(x.data.visibility & Visibility.CAMERA) for x in lamps)
        self._shadowless = not data.cast_shadow
        self._shaders = [lamp.shader for lamp in lamps if lamp.shader is not None]  # of all, or of none
        self.boxed = self.sized and data.kind != "SUN" and not self._shaders  # `crowd` may look for them

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Draw from lamp `row[lane]`, or from the only one."""
        draw = self.kind.sample(row, p, u, v)
        for number, shader in enumerate(self._shaders):
            lanes = np.arange(u.size) if row is None else np.flatnonzero(row == number)
            if lanes.size:
                draw.weight[:, lanes] *= shader.factor(p.take(lanes, axis=1), draw.wo.take(lanes, axis=1))
        return draw._replace(distance=np.full(u.shape, -1.0, np.float32)) if self._shadowless else draw

    def hits(self, o: Float32, d: Float32, t: Float32, of_camera: bool) -> Iterator[Hits]:
        """What camera rays, or all others, meet of each lamp."""
        for row in self.rows(of_camera):
            hits = self.kind.hits(row, o, d, t)
            if self._shaders and hits.lanes.size:
                met = o.take(hits.lanes, axis=1), d.take(hits.lanes, axis=1)
                hits = hits._replace(radiance=hits.radiance * self._shaders[row].factor(*met))
            yield hits

    def rows(self, of_camera: bool) -> list[int]:
        """The lamps that camera rays, or all others, may meet."""
        return [row for row in range(self.count) if (self.camera[row] if of_camera else not self.delta)]


def lamp_parts(lamps: Sequence[Lamp], chance: Float64) -> list[LampPart]:
    """Parts of lamps that are sorted by `traits`, in their order."""
    parts, first = [], 0
    for _, group in groupby(lamps, traits):
        members = list(group)
        parts.append(LampPart(members, chance[first : first + len(members)]))
        first += len(members)
    return parts


class EnvironmentPart:
    """The world, chosen with probability `chance`."""

    count = 1
    delta = False

    def __init__(self, environment: Environment, chance: float) -> None:
        self.environment = environment
        self.chance = chance

    def sample(self, row: Index | None, p: Float32, u: Float32, v: Float32) -> Draw:
        """Draw from the world."""
        wo, pdf = self.environment.sample(u, v)
        pdf *= self.chance
        weight = self.environment.radiance(wo) / pdf
        return Draw(wo, np.full(u.shape, FAR, np.float32), weight, pdf)

    def pdf(self, d: Float32) -> Float32:
        """(n,) density of `sample`, the choice included."""
        return self.environment.pdf(d) * self.chance
