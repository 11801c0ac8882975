"""Holdouts: where a ray that sees the film meets one, that has a hole, with or without a transparent sky."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import transparent
from ..core import vectors
from ..core.clock import stage
from .arrivals import Arrivals
from .evaluated import evaluated
from .geometry import SKY

if TYPE_CHECKING:
    from ..nodes.batch import Closure
    from ..render.path_state import PathState
    from .scene import Scene
    from .wave import Intersection, Rays

Bool = NDArray[np.bool_]
Int32 = NDArray[np.int32]


@stage("emission", "holdouts")
def cut_holes(scene: Scene, rays: Rays, found: Intersection, path: PathState) -> None:
    """Take what holdouts hide of the throughput of rays that see the film off its coverage.

    As in Cycles a ray ends where a surface is all holdout, whatever else is added to it; where it is partly
    one the rest of its closures are as they are, but of an object that is one only the transparent ones. To
    other rays a holdout is black, and such an object as any other.
    """
    lanes = np.flatnonzero((found.surface != SKY) & (path.clear != 0))
    objects = np.zeros(len(lanes), np.bool_)
    if scene.held is not None:
        objects = scene.held.take(scene.geometry.instance_of(found.hits, lanes))
    for own, what in ((objects, "transparency"), (~objects, "holdout")):
        some = lanes[own]
        if what == "holdout":
            some = some[scene.surface_holds_out.take(found.surface.take(some))]
        if len(some) == 0 or scene.alpha is None:
            continue
        hit = scene.surface(rays, found, some)
        material = scene.geometry.surface_material.take(hit.surface)
        share = evaluated(scene, hit, Arrivals.of(path, some), material, what)
        if what == "transparency":
            share = 1 - share
        scene.alpha[path.slot.take(some)] -= vectors.mean3(share * path.beta.take(some, axis=1))
        found.surface[some[(share == 1).all(axis=0)]] = SKY  # nothing is there any more


def held(objects: Bool, clear: NDArray[np.integer | np.bool_], instance: Int32) -> Bool:
    """(K,) whether rays, those that see the film `clear`, have met one of the holdout `objects` (I,)."""
    out: Bool = objects.take(instance) & (clear != 0)
    return out


def only_transparent(closures: Sequence[Closure], where: Bool) -> list[Closure]:
    """Closures that are dark on some lanes unless they are transparent."""
    return [c if c.bsdf is transparent else c._replace(weight=c.weight * ~where) for c in closures]
