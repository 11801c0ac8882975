"""Ray queries in scenes with curves or points: hulls found by Embree, what is in them met in closed form.

A ray that meets a hull's triangle, from outside or from inside, is tried on the piece within, and goes on
behind the triangle for what may be nearer; one that misses goes on as well. Each step passes a triangle, so
it ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .accel import MISS, Accel, Hits
from .geometry import BOUND, NORMAL, PLANE, Geometry
from .round_hits import Met, meet
from .rounds import Rounds

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Index = NDArray[np.intp]

PASSED = 4096  # hull triangles that a ray goes through at most


class RoundAccel:
    """The same queries as `Accel`'s, of triangles and of what is round.

    On hits of curves u is the way along the piece and v the place across a ribbon; `prim` is a triangle of
    the hull.
    """

    empty = False

    def __init__(self, triangles: Accel, geometry: Geometry, rounds: Rounds) -> None:
        self._triangles, self._geometry, self._rounds = triangles, geometry, rounds

    def intersect(self, origin: Float32, direction: Float32, tfar: Float32) -> Hits:
        """Closest hits of (3, N) rays with t in [0, `tfar`]; a ray with `tfar` < 0 is skipped."""
        limit = tfar.copy()
        met = self._triangles.intersect(origin, direction, tfar.copy())
        lanes = np.flatnonzero(met.prim >= self._rounds.first)
        if len(lanes) == 0:
            return met
        best = Hits(met.t.copy(), met.u.copy(), met.v.copy(), met.prim.copy())
        best.t[lanes], best.prim[lanes] = limit[lanes], MISS
        passed, prim = met.t[lanes], met.prim[lanes]
        for _ in range(PASSED):
            o, d = origin.take(lanes, axis=1), direction.take(lanes, axis=1)
            tried = self._tried(prim, o, d, passed)
            t = tried.t.astype(np.float32)
            nearer = np.flatnonzero(tried.t < best.t[lanes])
            self._put(best, lanes[nearer], t[nearer], tried.s[nearer], tried.v[nearer], prim[nearer])
            on = np.flatnonzero(passed < best.t[lanes])
            lanes, o, d = lanes[on], o.take(on, axis=1), d.take(on, axis=1)
            start = self._behind(prim[on], o, d, passed[on])
            met = self._triangles.intersect(start, d, best.t[lanes] - passed[on])
            t = passed[on] + met.t
            flat = np.flatnonzero((met.prim != MISS) & (met.prim < self._rounds.first))
            self._put(best, lanes[flat], t[flat], met.u[flat], met.v[flat], met.prim[flat])
            on = np.flatnonzero(met.prim >= self._rounds.first)
            lanes, prim, passed = lanes[on], met.prim[on], t[on]
            if len(lanes) == 0:
                break
        return best

    def visible(self, origin: Float32, direction: Float32, tfar: Float32) -> Int32:
        """Whether nothing lies in [0, `tfar`], as the bit mask −1 (clear) or 0 (blocked), as `Accel`."""
        clear = -(tfar >= 0).astype(np.int32)
        met = self._triangles.intersect(origin, direction, tfar.copy())
        clear[met.prim != MISS] = 0
        lanes = np.flatnonzero(met.prim >= self._rounds.first)
        passed, prim = met.t[lanes], met.prim[lanes]
        for _ in range(PASSED):
            if len(lanes) == 0:
                break
            o, d = origin.take(lanes, axis=1), direction.take(lanes, axis=1)
            limit = tfar.take(lanes)
            on = np.flatnonzero(self._tried(prim, o, d, passed).t > limit)
            lanes, passed, limit = lanes[on], passed[on], limit[on]
            o, d = o.take(on, axis=1), d.take(on, axis=1)
            met = self._triangles.intersect(self._behind(prim[on], o, d, passed), d, limit - passed)
            clear[lanes[met.prim == MISS]] = -1
            on = np.flatnonzero(met.prim >= self._rounds.first)
            lanes, prim, passed = lanes[on], met.prim[on], passed[on] + met.t[on]
        return clear

    def _tried(self, prim: Int32, o: Float32, d: Float32, near: Float32) -> Met:
        return meet(self._rounds.rows_of(prim), self._rounds.kinds, o, d, near)

    def _behind(self, prim: Int32, o: Float32, d: Float32, t: Float32) -> Float32:
        """(3, N) where rays that have met triangles after t begin on their other side."""
        record = self._geometry.planes(prim)
        normal = record[NORMAL]
        p = o + t * d
        side = np.copysign(record[BOUND], vectors.dot(normal, d))
        p += normal * (record[PLANE] - vectors.dot(normal, p) + side)
        return p

    @staticmethod
    def _put(best: Hits, lanes: Index, t: Float32, u: Float32, v: Float32, prim: Int32) -> None:
        best.t[lanes], best.u[lanes], best.v[lanes], best.prim[lanes] = t, u, v, prim
