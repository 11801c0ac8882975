"""Hit points of a wavefront. Everything faces the viewer: `ng` and `ns` are on `wi`'s side."""

from __future__ import annotations

import copy

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .accel import Hits
from .geometry import BOUND, EMITTER, INSTANCE, NORMAL, PLANE, Geometry

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
SAME_PLACE = 1e-9  # squared distance up to which a portal leads nowhere else, as in Cycles


class Surface:
    """Hit points of a set of lanes, one column each. What few programs read is gathered when asked for.

    On a curve or a point (`rounds`) that is what is round itself, not the hull that Embree has found: `ng`
    is the tube's or the sphere's normal, that of a ribbon as if it were round (n = v b + √(1 − v²) b × T
    with the tangent T, b = T × wi / |T × wi| and v from −1 to 1 across it, so that Principled Hair's h =
    −n·b is −v), `u` the way along the piece, `v` as above; on tubes and spheres 0.

    Attributes
    ----------
    p, ng, wi : (3, N) float32
        Position (recentred world), geometric normal on the viewer's side, direction to the viewer.
    bound : (N,) float32
        How far along `ng` a new ray must start to be clear of rounding.
    ns : (3, N) float32
        Shading normal on the viewer's side; `ng` unless `Scene.shade` has noted it.
    facing : (N,) float32
        Cosine between the face's own normal and `wi`; negative where the viewer is behind the face.
    """

    def __init__(
        self,
        geometry: Geometry,
        hits: Hits,
        lanes: NDArray[np.intp],
        o: Float32,
        d: Float32,
        surface: NDArray[np.integer] | None = None,
    ) -> None:
        self._geometry, self._hits, self._lanes, self._surface = geometry, hits, lanes, surface
        self.size = len(lanes)
        self.prim = hits.prim.take(lanes, mode="wrap")
        self._instance = None if hits.instance is None else hits.instance.take(lanes)
        record = geometry.planes(self.prim, self._instance)
        self.wi = -d
        self.ng, self.bound = record[NORMAL], record[BOUND]
        self.facing = vectors.dot(self.ng, self.wi)
        # the hit, put back onto the triangle's plane from where rounding has left it
        p = d
        p *= self.t
        p += o
        height = vectors.dot(self.ng, p)
        height -= record[PLANE]
        p -= self.ng * height
        self.p: Float32 = p
        vectors.flipped(self.ng, self.facing)
        if geometry.rounds is not None:
            geometry.rounds.settle(self, o)
        self.ns = self.ng

    def part(self, span: slice) -> Surface:
        """A view of consecutive lanes."""
        if span == slice(0, self.size):
            return self
        part = copy.copy(self)
        part._above = None
        part._lanes, part.prim = self._lanes[span], self.prim[span]
        part.p, part.ng, part.wi = self.p[:, span], self.ng[:, span], self.wi[:, span]
        part.ns = part.ng if self.ns is self.ng else self.ns[:, span]
        part.bound, part.facing = self.bound[span], self.facing[span]
        part._instance = None if self._instance is None else self._instance[span]
        part.size = len(part.prim)
        return part

    def take(self, index: NDArray[np.intp]) -> Surface:
        """Some of the lanes."""
        part = copy.copy(self)
        part._above = None
        part._lanes, part.prim = self._lanes.take(index), self.prim.take(index)
        part.p, part.ng, part.wi = (a.take(index, axis=1) for a in (self.p, self.ng, self.wi))
        part.ns = part.ng if self.ns is self.ng else self.ns.take(index, axis=1)
        part.bound, part.facing = self.bound.take(index), self.facing.take(index)
        part._instance = None if self._instance is None else self._instance.take(index)
        part.size = len(index)
        return part

    def relocate(self, index: NDArray[np.intp], p: Float32) -> None:
        """Let rays from some lanes start exactly at p (3, K), unless that is where they are.

        Parts of this surface, and what it is a part of, see it too.
        """
        away = p - self.p.take(index, axis=1)
        far = np.flatnonzero(vectors.dot(away, away) > SAME_PLACE)
        self.p[:, index[far]] = p.take(far, axis=1)
        self.bound[index[far]] = 0

    @property
    def above(self) -> Float32:
        """(3, N) where rays start that leave on the viewer's side; not to be changed."""
        if self._above is None:
            self._above = self.bound * self.ng
            self._above += self.p
        return self._above

    def start(self, wo: Float32) -> Float32:
        """(3, N) where rays toward `wo` start: off the surface by the hit's error bound, on their side."""
        start: Float32 = np.copysign(self.bound, vectors.dot(self.ng, wo)) * self.ng
        start += self.p
        return start

    @property
    def t(self) -> Float32:
        """(N,) ray length."""
        return self._hits.t.take(self._lanes, mode="wrap")

    _above: Float32 | None = None
    moved_uv: tuple[Float32, Float32] | None = None  # set where the points were moved along their faces

    @property
    def u(self) -> Float32:
        """(N,) weight of the triangle's corner 1."""
        return self._hits.u.take(self._lanes) if self.moved_uv is None else self.moved_uv[0]

    @property
    def v(self) -> Float32:
        """(N,) weight of the triangle's corner 2."""
        return self._hits.v.take(self._lanes) if self.moved_uv is None else self.moved_uv[1]

    @property
    def surface(self) -> NDArray[np.integer]:
        """(N,) `Geometry.surface_material` row."""
        if self._surface is None:
            return self._geometry.surface.take(self.prim)
        return self._surface.take(self._lanes, mode="wrap")

    @property
    def instance(self) -> Int32:
        """(N,) which placed mesh."""
        own = self._geometry.integer(INSTANCE, self.prim)
        return own if self._instance is None else np.where(self._instance < 0, own, self._instance)

    @property
    def on_shared(self) -> NDArray[np.bool_]:
        """(N,) whether the triangle's record is shared by instances."""
        return np.zeros(self.size, np.bool_) if self._instance is None else self._instance >= 0

    @property
    def strand(self) -> Int32 | None:
        """(N,) number of the curve, −1 for none; None where there is none at all."""
        rounds = self._geometry.rounds
        return None if rounds is None else rounds.strand_of(self.prim)

    @property
    def emitter(self) -> Int32:
        """(N,) number among the emissive triangles, −1 for none."""
        return self._geometry.integer(EMITTER, self.prim)

    @property
    def back(self) -> Float32:
        """(N,) 1 where the viewer is behind the face, else 0."""
        return (self.facing < 0).astype(np.float32)
