"""What a wavefront is made of: rays, what they hit, what they found, and who is shaded together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .accel import Hits

if TYPE_CHECKING:
    from .light_groups import GroupLight, Groups

Float32 = NDArray[np.float32]


class Rays(NamedTuple):
    """N rays. `tfar` < 0 switches one off.

    Attributes
    ----------
    o, d : (3, N) float32
        Origin (recentred world) and unit direction.
    tfar : (N,) float32
    kind : (N,) int32 or int
        `RayKind` bits: objects may be hidden from some rays. 0 sees all there is.
    strand : (N,) int32 or None
        Number of the curve that each ray starts on (`Surface.strand`), which it does not meet.
    """

    o: Float32
    d: Float32
    tfar: Float32
    kind: NDArray[np.int32] | int = 0
    strand: NDArray[np.int32] | None = None

    def take(self, lanes: NDArray[np.intp]) -> Rays:
        """Some of the rays, in that order."""
        o, d, tfar = (row.take(lanes, axis=-1, mode="wrap") for row in (self.o, self.d, self.tfar))
        kind = self.kind if isinstance(self.kind, int) else self.kind.take(lanes)
        return Rays(o, d, tfar, kind, None if self.strand is None else self.strand.take(lanes))

    def part(self, span: slice) -> Rays:
        """A view of consecutive rays."""
        kind = self.kind if isinstance(self.kind, int) else self.kind[span]
        strand = None if self.strand is None else self.strand[span]
        return Rays(self.o[:, span], self.d[:, span], self.tfar[span], kind, strand)


def rays_joined(parts: Sequence[Rays]) -> Rays:
    """All rays of some parts, which are of one making."""
    o, d, tfar, kinds, strands = zip(*parts, strict=True)
    kind = kinds[0] if isinstance(kinds[0], int) else np.concatenate(kinds)
    strand = None if strands[0] is None else np.concatenate(strands)
    return Rays(np.concatenate(o, axis=1), np.concatenate(d, axis=1), np.concatenate(tfar), kind, strand)


class Found(NamedTuple):
    """Lanes whose ray found an emitter.

    Attributes
    ----------
    lanes : (K,) intp
    radiance : (3, K) float32
    pdf : (K,) float32
        Density per solid angle with which emitter sampling would have chosen this direction.
    group : int or (K,) int
        The emitters' light groups.
    source : str
        "sky", "surface" or "lamp".
    by_group : GroupLight or None
        What keeps the light by group, where there are any.
    """

    lanes: NDArray[np.intp]
    radiance: Float32
    pdf: Float32
    group: Groups = 0
    source: str = "lamp"
    by_group: GroupLight | None = None


class Intersection(NamedTuple):
    """What N rays have hit: `accel.Hits`, and the surface number (the sky's for a miss).

    Attributes
    ----------
    hits : Hits
    surface : (N,) unsigned int
    """

    hits: Hits
    surface: NDArray[np.integer]

    def take(self, lanes: NDArray[np.intp]) -> Intersection:
        """Those of some of the rays, in that order."""
        t, u, v, prim, instance = self.hits
        copies = None if instance is None else instance.take(lanes)
        hits = Hits(t.take(lanes), u.take(lanes), v.take(lanes), prim.take(lanes), copies)
        return Intersection(hits, self.surface.take(lanes))

    def part(self, span: slice) -> Intersection:
        """A view of those of consecutive rays."""
        t, u, v, prim, instance = self.hits
        copies = None if instance is None else instance[span]
        return Intersection(Hits(t[span], u[span], v[span], prim[span], copies), self.surface[span])


def intersections_joined(parts: Sequence[Intersection]) -> Intersection:
    """All of some parts, which are of one making."""
    t, u, v, prim, instances = zip(*(part.hits for part in parts), strict=True)
    copies = None if instances[0] is None else np.concatenate(instances)
    hits = Hits(np.concatenate(t), np.concatenate(u), np.concatenate(v), np.concatenate(prim), copies)
    return Intersection(hits, np.concatenate([part.surface for part in parts]))


class Group(NamedTuple):
    """Lanes that are shaded together: a batch of materials, on flat or on smooth geometry."""

    batch: int
    smooth: bool
