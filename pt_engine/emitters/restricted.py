"""Emitters that do not shine on everyone: hidden from some rays, linked to some objects, for few bounces.

The choice among emitters does not know of it. A sample of one that does not reach the point has no weight,
and a ray that meets it by chance gathers nothing, so both strategies agree and their densities stay true.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.raykind import RayKind
from ..scene.snapshot import UNLIMITED, Visibility
from .base import Index, Lamp
from .faces import Faces

Int32 = NDArray[np.int32]
Emitters = NDArray[np.integer]
UInt8 = NDArray[np.uint8]
Bool = NDArray[np.bool_]
SCATTERED = Visibility.DIFFUSE | Visibility.GLOSSY | Visibility.TRANSMISSION


def _seen_as(kind: int) -> int:
    """`Visibility` bits that all must be given for a ray to see a lamp or the world, as in Cycles.

    One that came through a surface diffusely is both a diffuse and a transmitted one.
    """
    glossy = kind & RayKind.GLOSSY and kind & RayKind.REFLECTION
    bits = (
        (kind & RayKind.CAMERA, Visibility.CAMERA),
        (kind & RayKind.DIFFUSE, Visibility.DIFFUSE),
        (glossy, Visibility.GLOSSY),
        (kind & RayKind.TRANSMISSION, Visibility.TRANSMISSION),
    )
    return sum(bit for on, bit in bits if on)


SEEN_AS = np.array([_seen_as(kind) for kind in range(256)], np.uint8)


class Linking:
    """Which sets of emitters light which objects.

    Parameters
    ----------
    receives : (R, E) bool
        Whether receivers of each set get the light of emitters of each set.
    receiver : (I,) int32
        Each instance's set of receivers.
    """

    def __init__(self, receives: Bool, receiver: Int32) -> None:
        # instance −1, who has not scattered yet, is the camera: it sees all
        self._receives = np.concatenate([receives, np.ones((1, receives.shape[1]), np.bool_)])
        self._receiver = np.append(receiver, len(receives)).astype(np.int32)

    def lights(self, emitters: Int32, instance: Int32) -> Bool:
        """(n,) whether light of a set of `emitters` (n,) reaches an `instance` (n,)."""
        lit: Bool = self._receives[self._receiver.take(instance, mode="wrap"), emitters]
        return lit


class Shown(NamedTuple):
    """Who sees what shines, beside what lamps say themselves.

    Attributes
    ----------
    world : int
        `Visibility` bits.
    linking : Linking or None
    apart : (S,) bool or None
        By set of linked emitters: whether some objects cast no shadow in their light.
    world_group : int
        The world's light group.
    """

    world: int = Visibility.ALL
    linking: Linking | None = None
    apart: NDArray[np.bool_] | None = None
    world_group: int = 0


class Ways(NamedTuple):
    """How rays came: `RayKind` bits, the instance last scattered at (−1: none), bounces, (n,) each.

    `sampled` (n,) is whether an emitter sample stood for the same direction; it did not after Dirac bounces.
    """

    kind: Int32
    receiver: Int32
    depth: Int32
    sampled: Bool

    def take(self, lanes: Index) -> Ways:
        """Some of them."""
        return Ways._make(row.take(lanes) for row in self)


class Restrictions:
    """One row for each emitter, in the order of `Lights`.

    Attributes
    ----------
    hidden : (E,) uint8
        `Visibility` bits of the rays that do not see it.
    bounces : (E,) int32
        It lights no surface that has more bounces before it.
    group : (E,) int32
        Its set in `Linking`.
    apart : (E,) bool
        Some objects cast no shadow in its light: rays from surfaces meet it after Dirac bounces alone, for
        what stands in their way does not always stand in its.
    linking : Linking or None
    """

    def __init__(self, hidden: UInt8, bounces: Int32, group: Int32, apart: Bool, linking: Linking | None):
        self.hidden, self.bounces, self.group, self.apart = hidden, bounces, group, apart
        self.linking = linking
        self.hides = bool((hidden & SCATTERED).any())

    def sampled(self, emitter: int | Emitters, instance: Int32, depth: Int32) -> Bool:
        """(n,) whether a sample of `emitter` lights a surface of `instance` that `depth` bounces lead to."""
        lit: Bool = self.bounces[emitter] >= depth
        if self.linking is not None:
            group: Int32 = np.broadcast_to(self.group[emitter], instance.shape)
            lit = lit & self.linking.lights(group, instance)
        return lit

    def met(self, emitter: int | Emitters, ways: Ways) -> Bool:
        """(n,) whether rays that meet `emitter` gather its light."""
        lit = self.sampled(emitter, ways.receiver, ways.depth - 1)
        lit &= (self.hidden[emitter] & SEEN_AS.take(ways.kind)) == 0
        lit &= ~(self.apart[emitter] & ways.sampled)
        return lit


def of_all(count: int) -> Restrictions:
    """Of emitters that all shine on everyone."""
    none = np.zeros(count, np.int32)
    return Restrictions(none.astype(np.uint8), none + UNLIMITED, none, none.astype(np.bool_), None)


def restrictions(
    lamps: Sequence[Lamp], faces: Faces | None, world: int | None, linking: Linking | None, apart: Bool | None
) -> Restrictions | None:
    """Of all emitters; None where each shines on everyone.

    Parameters
    ----------
    lamps, faces :
        In this order, then the world.
    world : int or None
        `Visibility` bits of the world where it is an emitter.
    linking : Linking or None
    apart : (S,) bool or None
        By set of emitters: whether some objects cast no shadow in their light.
    """
    seen = [lamp.data.visibility for lamp in lamps]
    bounces = [min(lamp.data.max_bounces, UNLIMITED) for lamp in lamps]
    groups = [lamp.data.group for lamp in lamps]
    if faces is not None:
        whose = faces.whose()
        seen += (whose & 255).tolist()
        groups += (whose >> 8 & 0xFFFFFF).tolist()
        bounces += [UNLIMITED] * len(whose)
    if world is not None:
        seen, groups, bounces = [*seen, world], [*groups, 0], [*bounces, UNLIMITED]
    hidden = ~np.array(seen, np.uint8)
    group = np.array(groups, np.int32)
    limited = min(bounces, default=UNLIMITED) < UNLIMITED
    if not limited and linking is None and apart is None and not (hidden & SCATTERED).any():
        return None
    separate = np.zeros(len(group), np.bool_) if apart is None else apart[group]
    return Restrictions(hidden, np.array(bounces, np.int32), group, separate, linking)
