"""The whole pipeline in float64: the same code, told that `np.float32` is float64.

Everything that the package computes in float32 is then computed in float64: camera, hit points, normals,
frames, scattering, emitters, weights, throughput. Three things are as they were: random numbers (multiples
of 2⁻²⁴, exact in both) and the tables that emitters are chosen from; the vertices of the meshes, which are
read from the same snapshot; and Embree, which finds triangles in float32 only: distance and place on the
triangle it has found are computed anew. Integers that share a buffer with floats become int64.

`enter()` has to be called before anything of the package is imported, in a process that ends with it.
"""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

SINGLE, INTEGER = np.float32, np.int32
AS_BEFORE = (
    "core.hashing",
    "core.sobol",
    "core.samplers",
    "core.distributions",
    "render.dimensions",
    "scene.accel",
)


class Single(ModuleType):
    """numpy as it was."""

    float32, int32 = SINGLE, INTEGER

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)


class State(np.ndarray):
    """Bits of a sampler that shares a buffer with floats: seen as another number type, they are converted."""

    def view(self, *kind: Any) -> Any:
        numbers = bool(kind) and kind[0] in (np.int64, np.uint32) and kind[0] != self.dtype
        return self.astype(kind[0]) if numbers else super().view(*kind)


def enter() -> None:
    """From here on float32 is float64."""
    np.float32, np.int32 = np.float64, np.int64  # type: ignore[misc,assignment]
    import importlib

    for name in AS_BEFORE:
        importlib.import_module(f"pt_engine.{name}").np = Single("numpy")
    from pt_engine.core.rows import Rows
    from pt_engine.render.dimensions import LaneSampler
    from pt_engine.scene.accel import Accel

    make_rows, make_sampler = Rows.__init__, LaneSampler.__init__

    def rows(self: Any, data: Any) -> None:
        make_rows(self, data)
        self.integers = self.integers.view(State)

    def sampler(self: Any, kind: Any, state: Any) -> None:
        make_sampler(self, kind, state.view(State))

    Rows.__init__, LaneSampler.__init__ = rows, sampler  # type: ignore[method-assign,assignment]
    refine(Accel)


def refine(accel: Any) -> None:
    """Embree is asked in float32, and what it has hit is met again in float64."""
    make, intersect, visible = accel.__init__, accel.intersect, accel.visible

    def build(self: Any, vertices: Any, triangles: Any, copies: Any = ()) -> None:
        self.corners = (
            np.asarray(vertices, np.float64)[triangles].transpose(1, 2, 0) if len(triangles) else None
        )
        make(self, vertices.astype(SINGLE), triangles.astype(INTEGER), copies)

    def closest(self: Any, o: Any, d: Any, tfar: Any) -> Any:
        hits = intersect(self, o.astype(SINGLE), d.astype(SINGLE), tfar.astype(SINGLE))
        t, u, v = (np.array(x, np.float64) for x in (hits.t, hits.u, hits.v))
        met = np.flatnonzero(hits.prim >= 0)
        if len(met):
            a, b, c = self.corners[:, :, hits.prim[met]]
            t[met], u[met], v[met] = crossing(o[:, met], d[:, met], a, b - a, c - a)
        return hits._replace(t=t, u=u, v=v, prim=hits.prim.astype(np.int64))

    def clear(self: Any, o: Any, d: Any, tfar: Any) -> Any:
        return visible(self, o.astype(SINGLE), d.astype(SINGLE), tfar.astype(SINGLE)).astype(np.int64)

    accel.__init__, accel.intersect, accel.visible = build, closest, clear


def crossing(o: Any, d: Any, a: Any, e1: Any, e2: Any) -> tuple[Any, Any, Any]:
    """t, u, v of rays on the planes of triangles (Möller and Trumbore 1997)."""
    p, s = np.cross(d, e2, axis=0), o - a
    q = np.cross(s, e1, axis=0)
    scale = 1 / (p * e1).sum(axis=0)
    return scale * (q * e2).sum(axis=0), scale * (p * s).sum(axis=0), scale * (q * d).sum(axis=0)
