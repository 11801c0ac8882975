"""What a shader's own ray meets, for the Raycast node."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from .wave import Intersection, Rays

if TYPE_CHECKING:
    from .lanes import Lanes

Float32 = NDArray[np.float32]


class Met(NamedTuple):
    """What rays have met.

    Attributes
    ----------
    hit, own : (n,) float32
        1 where there is something within reach, and where it is of the lane's own object.
    distance : (n,) float32
        In units of the direction; the reach where nothing is met.
    place, normal : (3, n) float32
        In the world; the shading normal, on the ray's side. 0 where nothing is met.
    attributes : list of (3, n) float32
        Of the surface met.
    """

    hit: Float32
    own: Float32
    distance: Float32
    place: Float32
    normal: Float32
    attributes: list[Float32]


def raycast(
    lanes: Lanes, position: Float32, direction: Float32, reach: Float32, local: bool, names: tuple[str, ...]
) -> Met | None:
    """Rays from world positions (3, n) along directions of any length, up to `reach` (n,) times those.

    A ray that starts where the lane is leaves its own face out. `local` sees only the lanes' own objects.
    None where the path has no random numbers left, as for shadow rays and sampled emitters: Cycles does not
    look around there either.
    """
    scene = lanes.scene
    if lanes.noise is None or (local and scene.own is None):
        return None
    here = (position == lanes.position).all(axis=0)
    clear = lanes.ng * np.copysign(lanes.si.bound, vectors.dot(lanes.ng, direction))
    o = np.where(here, lanes.p + clear, position - scene.origin32)
    rays = Rays(o, direction, np.where(reach > 0, reach, np.float32(-1)))
    if local and scene.own is not None:
        scene.rays["shading"] += int(np.count_nonzero(rays.tfar > 0))
        hits = scene.own.intersect(lanes.si.instance, o, direction, rays.tfar.copy())
        found = Intersection(hits, scene.geometry.surface.take(hits.prim, mode="wrap"))
    else:
        found = scene.intersect(rays._replace(tfar=rays.tfar.copy()), "shading")
    index = np.flatnonzero(found.hits.prim >= 0)
    met = scene.surface(rays, found, index)
    hit, own, distance = np.zeros(lanes.n, np.float32), np.zeros(lanes.n, np.float32), reach.copy()
    hit[index] = 1
    own[index] = met.instance == lanes.si.instance.take(index)
    distance[index] = met.t
    place = (position + direction * distance) * hit
    sampled = []
    for name in names:
        values = np.zeros((3, lanes.n), np.float32)
        values[:, index] = scene.layer("attribute", name).at(met.prim, met.instance, met.u, met.v)[:3]
        sampled.append(values)
    return Met(hit, own, distance, place, scene.shading_normal(rays, found), sampled)
