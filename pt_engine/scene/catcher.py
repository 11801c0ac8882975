"""Shadow catchers: what camera rays have found before they meet one, and the scene with catchers alone.

As in Cycles a camera ray's first meeting with a catcher parts its light in two: what it has gathered so far
shows in the picture, all that follows only counts as a ratio, of the light that leaves the catcher in the
whole scene over that with catchers alone (and lamps that are "real"), which darkens what lies behind.
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.rows import scatter, scatter_add
from ..emitters.lights import Lights
from ..emitters.restricted import Restrictions, of_all
from .arrivals import Arrivals
from .geometry import SKY, Placed
from .round_accel import through_hulls
from .sighted import BITS, Sighted, trees_of
from .sky_lanes import SkyLanes
from .snapshot import Instances, Visibility

if TYPE_CHECKING:
    from ..render.path_state import PathState
    from .nearer import Nearer
    from .scene import Scene
    from .wave import Found, Intersection, Rays

Float32 = NDArray[np.float32]
Bool = NDArray[np.bool_]


class Caught:
    """Of N camera rays: whether they have met a catcher, and what was with each then.

    Attributes
    ----------
    hit : (N,) bool
    beta, light : (3, N) float32
        Throughput, and radiance gathered so far.
    alpha : (N,) float32
        Coverage without what follows.
    sky : (3, N) float32
        The sky that camera rays see, also behind catchers.
    """

    def __init__(self, n: int) -> None:
        self.hit = np.zeros(n, np.bool_)
        self.beta, self.light, self.sky = (np.zeros((3, n), np.float32) for _ in range(3))
        self.alpha = np.ones(n, np.float32)


def catch(scene: Scene, caught: Caught, rays: Rays, found: Intersection, path: PathState) -> None:
    """Note the camera rays that meet a catcher for the first time."""
    lanes = np.flatnonzero((found.surface != SKY) & (path.clear != 0))
    lanes = lanes[scene.catchers.take(scene.geometry.instance_of(found.hits, lanes))]
    lanes = lanes[~caught.hit.take(path.slot.take(lanes))]
    if len(lanes) == 0:
        return
    slot, beta = path.slot.take(lanes), path.beta.take(lanes, axis=1)
    caught.hit[slot] = True
    scatter(caught.beta, slot, beta)
    scatter(caught.light, slot, path.L.take(lanes, axis=1))
    if scene.alpha is not None:
        caught.alpha[slot] = scene.alpha.take(slot) - vectors.mean3(beta)
    if scene.world.emits and not scene.film_transparent:
        sky = SkyLanes(rays.d.take(lanes, axis=1), Arrivals.of(path, lanes), scene.view)
        scatter_add(caught.sky, slot, beta * scene.world.emission(sky))


def note_sky(caught: Caught, found: Found, path: PathState) -> None:
    """Note the sky that camera rays have reached without meeting a catcher."""
    seen = np.flatnonzero(path.clear.take(found.lanes) != 0)
    lanes = found.lanes.take(seen)
    slot = path.slot.take(lanes)
    light = path.beta.take(lanes, axis=1) * found.radiance.take(seen, axis=1)
    scatter_add(caught.sky, slot, light * ~caught.hit.take(slot))


def catchers_of(instances: Instances) -> Bool:
    """(I,) which are shadow catchers; a holdout is none."""
    bits = instances.visibility
    return np.asarray(((bits & Visibility.CATCHER) != 0) & ((bits & Visibility.HOLDOUT) == 0))


def catchers_tree(placed: Placed, instances: Instances, shown: Bool) -> Sighted:
    """What rays are sent at that see of the placed `instances` those `shown` (I,) alone."""
    bits = np.where(shown, instances.visibility.astype(np.int64), 0)
    classes, kind = np.unique(bits, return_inverse=True)
    rows = [classes != 0] + [(classes & bit) != 0 for bit in (*BITS, Visibility.SHADOW)]
    return Sighted(trees_of(placed, kind, np.stack(rows)))


def with_catchers_alone(scene: Scene, tree: Sighted | Nearer) -> Scene:
    """The scene as rays see it that see catchers alone (`tree`), lit by what is real and the world."""
    alone = copy.copy(scene)
    alone.accel, alone.seen_apart = through_hulls(tree, scene.geometry), True
    alone.lights, alone.light_groups, alone.alone = scene.lights.changed(_only_real), (), None
    return alone


def _only_real(lights: Lights) -> None:
    """Leave the real lamps, faces of catchers, the world."""
    limits = lights.restrictions or of_all(len(lights.power))
    bounces = limits.bounces.copy()
    shines = np.ones(len(bounces), np.bool_)
    shines[: lights.lamps] = lights.real
    faces = lights.whose_faces()
    shines[lights.lamps : lights.lamps + len(faces)] = (faces & Visibility.CATCHER) != 0
    bounces[~shines] = -1
    lights.restrictions = Restrictions(limits.hidden, bounces, limits.group, limits.apart, limits.linking)
