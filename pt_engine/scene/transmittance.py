"""Shadow rays through transparent surfaces: what is left of the light after each of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.clock import stage
from ..core.raykind import RayKind
from ..core.rows import scatter
from .arrivals import Arrival, Arrivals
from .geometry import SKY
from .lanes import Lanes
from .surface import Surface

if TYPE_CHECKING:
    from .scene import Scene

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


@stage("shadow", "shadows of transparent surfaces")
def transmittance(
    scene: Scene,
    o: Float32,
    d: Float32,
    tfar: Float32,
    limit: int,
    path: Arrival | None = None,
    kind: Int32 | int = RayKind.SHADOW,
    strand: Int32 | None = None,
) -> Float32:
    """(3, N) product of the transparencies met in (0, `tfar`); 0 behind anything opaque.

    Parameters
    ----------
    o, d : (3, N) float32
    tfar : (N,) float32
        < 0 skips a ray (its result is 0).
    limit : int
        A ray that would have to pass more surfaces than this is blocked.
    path : Arrival, optional
        The paths that the rays belong to, which some programs ask for; None: from the camera.
    kind : (N,) int32 or int
        Of the rays.
    strand : (N,) int32 or None
        The curves that they start on.
    """
    from .wave import Rays

    result = np.zeros(o.shape, np.float32)
    lanes = np.flatnonzero(tfar > 0)
    light = np.ones((3, len(lanes)), np.float32)
    own = None if strand is None else strand.take(lanes)
    rays = Rays(o.take(lanes, axis=1), d.take(lanes, axis=1), tfar.take(lanes), of_some(kind, lanes), own)
    came = Arrivals.by(RayKind.SHADOW, len(lanes))
    if path is not None and scene.tracks_history:
        came = Arrivals.of(path, lanes)._replace(kind=came.kind, travelled=came.travelled)
    for _ in range(limit + 1):
        left = rays.tfar.copy()  # Embree overwrites tfar with the hit's distance
        found = scene.intersect(rays, "shadow")
        clear = np.flatnonzero(found.surface == SKY)
        scatter(result, lanes.take(clear), light.take(clear, axis=1))
        hit = np.flatnonzero(scene.passes.take(scene.batch(found)))
        si = scene.surface(rays, found, hit)
        came = came.take(hit)
        dimmed = light.take(hit, axis=1) * _transparency(scene, si, scene.batch(found).take(hit), came)
        on = np.flatnonzero(vectors.max3(dimmed) > 0)
        if len(on) == 0:
            break
        kept = hit.take(on)
        lanes, light, si = lanes.take(kept), dimmed.take(on, axis=1), si.take(on)
        came = came.take(on)
        came = came._replace(passed=came.passed + 1, travelled=came.travelled + si.t)
        start = si.p - si.ng * si.bound  # on the far side: d runs against ng
        own = None if own is None else own.take(kept)
        rays = Rays(start, -si.wi, left.take(kept) - si.t, of_some(rays.kind, kept), own)
    return result


def of_some(kind: Int32 | int, lanes: NDArray[np.intp]) -> Int32 | int:
    """The kinds of some rays."""
    return kind if isinstance(kind, int) else kind.take(lanes)


def _transparency(scene: Scene, si: Surface, group: NDArray[np.integer], came: Arrivals) -> Float32:
    """(3, N) what each hit surface lets through."""
    through = np.zeros((3, si.size), np.float32)
    for number in np.flatnonzero(scene.passes):
        index = np.flatnonzero(group == number)
        if len(index) == 0:
            continue
        batch, smooth = scene.groups[number]
        here = Lanes(scene, si.take(index), came.take(index), smooth)
        value = scene.materials.batches[batch].transparency(here)
        if value is not None:
            through[:, index] = value
    return through
