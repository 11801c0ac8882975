"""Whom light reaches: what the world's visibility, light linking and lamps' own limits leave of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.raykind import RayKind
from ..emitters.lights import LightSample
from ..emitters.restricted import SEEN_AS, Linking, Shown, Ways
from .sighted import SETS
from .snapshot import Snapshot, Visibility

if TYPE_CHECKING:
    from ..render.path_state import PathState
    from .scene import Scene
    from .surface import Surface

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Bool = NDArray[np.bool_]
Index = NDArray[np.intp]


class Reach(NamedTuple):
    """What of a scene does not shine on everyone.

    Attributes
    ----------
    hidden : int
        `Visibility` bits of rays that do not see the world.
    linking : Linking or None
    group : (I,) int32 or None
        Each instance's set of emitters.
    apart : (S,) bool or None
        By set: whether some objects cast no shadow in its light.
    world_group : int
        The world's light group.
    """

    hidden: int
    linking: Linking | None
    group: Int32 | None
    apart: Bool | None
    world_group: int = 0

    def shown(self) -> Shown:
        """The same for `Lights`."""
        return Shown(~self.hidden & 255, self.linking, self.apart, self.world_group)


def reach_of(snapshot: Snapshot) -> Reach:
    """Of a snapshot's world and links."""
    hidden = Visibility.ALL & ~snapshot.world_visibility
    links = snapshot.linking
    if links is None:
        return Reach(hidden, None, None, None, snapshot.world_light_group)
    receives = links.receives.astype(np.bool_)
    linking = None if receives.all() else Linking(receives, links.receiver)
    apart = ~links.blocks.astype(np.bool_).all(axis=0)
    apart_or_none = apart if apart.any() else None
    return Reach(hidden, linking, links.emitter, apart_or_none, snapshot.world_light_group)


def ways(scene: Scene, path: PathState, lanes: Index | slice) -> Ways | None:
    """How the rays of some lanes came; None where no emitter asks."""
    if scene.lights.restrictions is None:
        return None
    return Ways(path.kind[lanes], path.receiver[lanes], path.depth[lanes], np.isfinite(path.pdf[lanes]))


def sees_world(scene: Scene, path: PathState, lanes: Index) -> Bool:
    """(K,) whether rays see the world."""
    seen: Bool = (SEEN_AS.take(path.kind.take(lanes)) & scene.reach.hidden) == 0
    return seen


def lit_by_surfaces(scene: Scene, hit: Surface, path: PathState, lanes: Index) -> Bool:
    """(K,) whether the emission of surfaces that rays have met counts for them."""
    reach = scene.reach
    lit = np.ones(len(lanes), np.bool_)
    if reach.group is not None:
        group = reach.group.take(hit.instance)
        if reach.linking is not None:
            lit &= reach.linking.lights(group, path.receiver.take(lanes))
        if reach.apart is not None:
            left = reach.apart.take(group) & (
                hit.emitter >= 0
            )  # to shadow rays; what is not sampled has none
            lit &= ~(left & np.isfinite(path.pdf.take(lanes)))
    return lit


def restricted(scene: Scene, light: LightSample, si: Surface, path: PathState) -> LightSample:
    """Emitter samples without those that do not reach their points, and who sees the others."""
    limits = scene.lights.restrictions
    if limits is None:
        return light
    weight = light.weight * limits.sampled(light.emitter, si.instance, path.depth[: si.size])
    of_each = np.broadcast_to(light.emitter, si.size)
    hidden = limits.hidden.take(of_each, mode="clip") if limits.hides else None
    delta = light.delta
    if limits.apart.any():  # rays leave these alone, but for Dirac bounces
        delta = delta | limits.apart.take(of_each, mode="clip")
    return light._replace(weight=weight, hidden=hidden, delta=delta)


def shadow_kind(scene: Scene, light: LightSample) -> Int32 | int:
    """The kind of shadow rays to emitter samples, in which the emitters' sets stand."""
    limits = scene.lights.restrictions
    if limits is None or not limits.apart.any():
        return RayKind.SHADOW
    group = limits.group.take(np.broadcast_to(light.emitter, light.distance.shape), mode="clip")
    return np.int32(RayKind.SHADOW) + (group << np.int32(SETS))
