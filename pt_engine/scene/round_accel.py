"""Ray queries in scenes with curves or points: hulls found by Embree, what is in them met in closed form.

A ray that meets a hull's triangle, from outside or from inside, is tried on the piece within, and goes on
behind the triangle for what may be nearer; one that misses goes on as well. Each step's distance is larger
than the last one's, also where a hull is no thicker than the rounding of the ray, so it ends.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.clock import stage
from ..core.raykind import RayKind
from . import nearer
from .accel import MISS, Accel, Hits
from .geometry import BOUND, NORMAL, PLANE, Geometry
from .round_hits import NEVER, Met, meet
from .rounds import Rounds
from .sighted import Kinds, Sighted

if TYPE_CHECKING:
    from .nested import Nested

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Index = NDArray[np.intp]
Tree: TypeAlias = "Accel | nearer.Nearer | Nested | Sighted"

PASSED = 4096  # hull triangles that a ray goes through at most


def through_hulls(tree: Tree, geometry: Geometry) -> Tree | RoundAccel:
    """What rays are sent at where a tree holds hulls; else the tree itself."""
    return tree if geometry.rounds is None else RoundAccel(tree, geometry, geometry.rounds)


class RoundAccel:
    """The same queries as those of a tree, of triangles and of what is round.

    On hits of curves u is the way along the piece and v the place across a ribbon; `prim` is a triangle of
    the hull. A hull has no record that others share. As in Cycles rays do not meet the curve that they start
    on: of the number `strand` (N,), −1 for none.
    """

    empty = False

    def __init__(self, tree: Tree, geometry: Geometry, rounds: Rounds) -> None:
        self._tree, self._geometry, self._rounds = tree, geometry, rounds

    @stage("intersect", "curves and points")
    def intersect(
        self,
        origin: Float32,
        direction: Float32,
        tfar: Float32,
        kind: Kinds = 0,
        strand: Int32 | None = None,
    ) -> Hits:
        """Closest hits of (3, N) rays with t in [0, `tfar`]; a ray with `tfar` < 0 is skipped."""
        limit = tfar.copy()
        met = nearer.closest(self._tree, origin, direction, tfar.copy(), kind)
        lanes = np.flatnonzero(self._rounds.held(met.prim))
        if len(lanes) == 0:
            return met
        best, passed, prim = met, met.t[lanes], met.prim[lanes]
        best.t[lanes], best.prim[lanes] = limit[lanes], MISS
        for _ in range(PASSED):
            o, d = origin.take(lanes, axis=1), direction.take(lanes, axis=1)
            tried = self._tried(prim, o, d, passed, None if strand is None else strand.take(lanes))
            t = tried.t.astype(np.float32)
            closer = np.flatnonzero(tried.t < best.t[lanes])
            found = Hits(t, tried.s, tried.v, prim)
            put(best, lanes, found, closer)
            on = np.flatnonzero(passed < best.t[lanes])
            lanes, o, d = lanes[on], o.take(on, axis=1), d.take(on, axis=1)
            start, step = self._behind(prim[on], o, d, passed[on])
            met = nearer.closest(self._tree, start, d, best.t[lanes] - passed[on], of(kind, lanes))
            t = beyond(passed[on], np.maximum(met.t, step))
            hull = self._rounds.held(met.prim)
            put(best, lanes, met._replace(t=t), np.flatnonzero((met.prim != MISS) & ~hull))
            on = np.flatnonzero(hull)
            lanes, prim, passed = lanes[on], met.prim[on], t[on]
            if len(lanes) == 0:
                break
        return best

    @stage("shadow", "curves and points")
    def visible(
        self,
        origin: Float32,
        direction: Float32,
        tfar: Float32,
        kind: Kinds = RayKind.SHADOW,
        strand: Int32 | None = None,
    ) -> Int32:
        """Whether nothing lies in [0, `tfar`], as the bit mask −1 (clear) or 0 (blocked), as `Accel`."""
        clear = -(tfar >= 0).astype(np.int32)
        met = nearer.closest(self._tree, origin, direction, tfar.copy(), kind)
        clear[met.prim != MISS] = 0
        lanes = np.flatnonzero(self._rounds.held(met.prim))
        passed, prim = met.t[lanes], met.prim[lanes]
        for _ in range(PASSED):
            if len(lanes) == 0:
                break
            o, d = origin.take(lanes, axis=1), direction.take(lanes, axis=1)
            limit = tfar.take(lanes)
            own = None if strand is None else strand.take(lanes)
            on = np.flatnonzero(self._tried(prim, o, d, passed, own).t > limit)
            lanes, passed, limit = lanes[on], passed[on], limit[on]
            o, d = o.take(on, axis=1), d.take(on, axis=1)
            start, step = self._behind(prim[on], o, d, passed)
            met = nearer.closest(self._tree, start, d, limit - passed, of(kind, lanes))
            clear[lanes[met.prim == MISS]] = -1
            on = np.flatnonzero(self._rounds.held(met.prim))
            lanes, prim, passed = lanes[on], met.prim[on], beyond(passed, np.maximum(met.t, step))[on]
        return clear

    def _tried(self, prim: Int32, o: Float32, d: Float32, near: Float32, own: Int32 | None) -> Met:
        met = meet(self._rounds.rows_of(prim), self._rounds.kinds, o, d, near)
        if own is not None:
            met.t[(own >= 0) & (own == self._rounds.strand_of(prim))] = NEVER
        return met

    def _behind(self, prim: Int32, o: Float32, d: Float32, t: Float32) -> tuple[Float32, Float32]:
        """(3, N) where rays that have met triangles after t begin on their other side.

        Those that are there already stay on the ray: put back on one triangle's plane and on a neighbour's by
        turns, a ray from afar would never come past both. And (N,) by how much t is to grow at least: on an
        edge each triangle's other side may lie before its neighbour, and rays would go to and fro.
        """
        record = self._geometry.planes(prim)
        normal, bound = record[NORMAL], record[BOUND]
        side = np.copysign(np.float32(1), vectors.dot(normal, d))
        p = o + t * d
        left = bound - side * (vectors.dot(normal, p) - record[PLANE])
        p += normal * (side * np.maximum(left, 0))
        return p, bound


def beyond(passed: Float32, further: Float32) -> Float32:
    """(N,) distances `further` on; at least by what float32 can tell."""
    on: Float32 = np.maximum(passed + further, np.nextafter(passed, np.float32(np.inf)))
    return on


def put(best: Hits, lanes: Index, found: Hits, some: Index) -> None:
    """Make `some` of the hits found on `lanes` the best ones."""
    to = lanes[some]
    for column, values in zip(best[:4], found[:4], strict=True):
        column[to] = values[some]
    if best.instance is not None:
        best.instance[to] = MISS if found.instance is None else found.instance[some]


def of(kind: Kinds, lanes: Index) -> Kinds:
    """The kinds of some rays."""
    return kind.take(lanes) if isinstance(kind, np.ndarray) else kind
