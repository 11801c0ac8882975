"""Rays that shading itself traces: how open a place is, and what else of the object is near."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import frames, keyed, vectors, warps
from ..core.clock import stage

if TYPE_CHECKING:
    from .lanes import Lanes
    from .scene import Scene
    from .surface import Surface

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Index = NDArray[np.intp]

PASSED = 32  # surfaces of one object that a ray goes through at most


@stage("", "rays from shading")
def open_share(
    lanes: Lanes, normal: Float32, distance: Float32, samples: int, local: bool, key: int
) -> Float32:
    """(n,) share of `samples` rays, cosine-distributed about `normal`, that meet nothing within `distance`.

    `local` counts only the lanes' own objects. 1 where the path has no random numbers left, as for shadow
    rays and sampled emitters: Cycles does not look around there either.
    """
    noise = lanes.noise
    if noise is None or samples < 1:
        return np.ones(lanes.n, np.float32)
    reach = np.broadcast_to(distance, lanes.n).astype(np.float32)
    shift = keyed.bits(noise, key)
    s, t = frames.frame(normal)
    count = np.zeros(lanes.n, np.float32)
    for number in range(samples):
        local_d = warps.square_to_cosine_hemisphere(*keyed.uniforms(shift, number))
        d = np.ascontiguousarray(frames.to_world(s, t, normal, local_d))
        o = lanes.p + lanes.ng * np.copysign(lanes.si.bound, vectors.dot(lanes.ng, d))
        tfar = np.where(reach > 0, reach, np.float32(-1))
        count += _clear_of_own(lanes, o, d, tfar) if local else _clear(lanes.scene, o, d, tfar)
    open_: Float32 = count * np.float32(1 / samples)
    open_[~(reach > 0)] = 1
    return open_


def _clear(scene: Scene, o: Float32, d: Float32, tfar: Float32) -> Float32:
    scene.rays["shading"] += int(np.count_nonzero(tfar > 0))
    clear: Float32 = (scene.accel.visible(o, d, tfar) != 0).astype(np.float32)
    return clear


def _clear_of_own(lanes: Lanes, o: Float32, d: Float32, tfar: Float32) -> Float32:
    clear = np.ones(lanes.n, np.float32)
    for hit, _ in own_hits(lanes, o, d, tfar, first=True):
        clear[hit] = 0
    return clear


def own_hits(
    lanes: Lanes, o: Float32, d: Float32, tfar: Float32, first: bool = False
) -> Iterator[tuple[Index, Surface]]:
    """Where rays meet the lanes' own objects: lanes, and what is there; `first`, once each at most."""
    from .wave import Intersection, Rays

    scene = lanes.scene
    index = np.flatnonzero(tfar > 0)
    o, d, left = o.take(index, axis=1), d.take(index, axis=1), tfar.take(index)
    own = lanes.si.instance.take(index)
    for _ in range(1 if first else PASSED):
        if scene.own is None or len(index) == 0:
            return
        scene.rays["shading"] += len(index)
        hits = scene.own.intersect(own, o, d, left.copy())  # Embree overwrites tfar with the hit's distance
        hit = np.flatnonzero(hits.prim >= 0)
        surface = scene.geometry.surface.take(hits.prim, mode="wrap")
        si = scene.surface(Rays(o, d, left), Intersection(hits, surface), hit)
        index, own, left = index.take(hit), own.take(hit), left.take(hit) - si.t
        if len(index):
            yield index, si
        on = np.flatnonzero(left > 0)
        index, own, left, si = index.take(on), own.take(on), left.take(on), si.take(on)
        o, d = si.p - si.ng * si.bound, -si.wi  # on the far side: the ray runs against ng
