"""Objects that only some rays see: rays ask trees that hold no others.

Embree has no ray masks here, and going on behind an unseen surface would miss what lies in its plane. In
small scenes each kind of ray has a tree of all that it sees, one for those that see the same. In large ones
each triangle is stored once: objects are parted by who sees them, and rays ask the tree of the many, then, no
further than the hit, the usually small trees of the others.

Of 65,536 incoherent rays among 500,000 triangles, two of which the camera does not see, the trees apart cost
nothing beyond Embree, the parted ones 15 % of a closest hit; going on behind what is not seen 8 %.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.raykind import RayKind
from .accel import MISS, Accel, Hits
from .geometry import Placed
from .snapshot import Instances, Linking, Snapshot, Visibility

if TYPE_CHECKING:
    from .nested import Nested

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Bool = NDArray[np.bool_]
Kinds = Int32 | int

ANY, SHADOW = 0, 5  # rows of `Sighted.sees`; between them, the four kinds of rays that paths walk along
SETS = 8  # bits of a ray's kind above which the set of its light stands: a row of shadow rays each
BITS = (Visibility.CAMERA, Visibility.DIFFUSE, Visibility.GLOSSY, Visibility.TRANSMISSION)
SEEING = Visibility.SHADOW | sum(BITS)
SPARE = 1 << 20  # triangles that may be stored more than once, 113 bytes each


def _row_of(kind: int) -> int:
    """The row of a ray's `RayKind` bits: as in Cycles, one that came through a surface is only that."""
    if kind & RayKind.CAMERA:
        return 1
    if kind & RayKind.SHADOW:
        return SHADOW
    if kind & RayKind.TRANSMISSION:
        return 4
    return 2 if kind & RayKind.DIFFUSE else 3 if kind & RayKind.GLOSSY else ANY


ROW = np.array([_row_of(kind) for kind in range(1 << SETS)], np.int32)


class Tree(NamedTuple):
    """Some objects: which rows of rays ask it, and the scene's number of each triangle, then of none.

    `number` None: the tree's own numbers are the scene's.
    """

    asked: Bool
    accel: Accel | Nested
    number: Int32 | None


class Sighted:
    """Stands in for `Accel` where not every ray sees every object; `trees` from `trees_of`."""

    empty = False

    def __init__(self, trees: list[Tree]) -> None:
        self._trees = trees

    def intersect(self, origin: Float32, direction: Float32, tfar: Float32, kind: Kinds = ANY) -> Hits:
        """Closest hits among what rays of each `kind`, `RayKind` bits, see; else as `Accel.intersect`."""
        nearest: Hits | None = None
        row = _rows(kind)
        for tree in self._trees:
            asks = tree.asked.take(row)
            if not asks.any():
                continue
            limit = np.copy(tfar if nearest is None else nearest.t)  # Embree overwrites it
            blind = np.flatnonzero(~asks) if asks.ndim else np.zeros(0, np.intp)
            limit[blind] = -1
            hits = tree.accel.intersect(origin, direction, limit)
            if tree.number is not None:
                hits = hits._replace(prim=tree.number.take(hits.prim, mode="wrap"))
            if nearest is None:
                hits.t[blind] = tfar[blind]
                nearest = hits
                continue
            met = np.flatnonzero(hits.prim != MISS)
            for best, found in zip(nearest[:4], hits[:4], strict=True):
                best[met] = found.take(met)
            if nearest.instance is not None:
                nearest.instance[met] = MISS
        if nearest is None:
            zero = np.zeros_like(tfar)
            return Hits(tfar, zero, zero, np.full(tfar.shape, MISS, np.int32))
        return nearest

    def visible(
        self, origin: Float32, direction: Float32, tfar: Float32, kind: Kinds = RayKind.SHADOW
    ) -> Int32:
        """Whether nothing that rays of a `kind` see lies in [0, `tfar`]; as `Accel.visible`."""
        row = _rows(kind)
        clear: Int32 = -(tfar >= 0).astype(np.int32)
        for tree in self._trees:
            asks = tree.asked.take(row)
            if not asks.any():
                continue
            if asks.all():
                clear &= tree.accel.visible(origin, direction, tfar)
            else:
                limit = np.where(asks, tfar, np.float32(-1))
                clear &= tree.accel.visible(origin, direction, limit) | -(~asks).astype(np.int32)
        return clear


def _rows(kind: Kinds) -> NDArray[np.integer]:
    kinds = np.asarray(kind)
    return np.asarray(ROW.take(kinds & ((1 << SETS) - 1)) + (kinds >> SETS))


def trees_of(
    placed: Placed,
    kind: NDArray[np.integer],
    sees: Bool,
    spare: int = SPARE,
    base: Accel | Nested | None = None,
) -> list[Tree]:
    """Trees of all triangles.

    Parameters
    ----------
    placed : Placed
    kind : (I,) int
        Of each instance; those of one kind are seen by the same rays.
    sees : (K, C) bool
        Which rays see kind c: any, the camera's, diffuse, glossy, transmitted, then shadow rays of the
        lights of each set.
    spare : int
        So many triangles may be stored more than once.
    base : Accel or Nested, optional
        A tree of all that is seen by all rays, which then is not built here.
    """
    of_triangle = np.repeat(kind, np.diff(placed.first_triangle))
    size = np.bincount(of_triangle, minlength=sees.shape[1])
    held, which = np.unique(sees, axis=0, return_inverse=True)
    asked = np.arange(len(held)) == which.reshape(-1, 1)
    if base is not None or int((held @ size).sum()) > int(size.sum()) + spare:
        held, asked = np.eye(sees.shape[1], dtype=np.bool_), sees
    order = np.argsort(-(held @ size), kind="stable")
    if base is None:
        return [_tree(placed, np.flatnonzero(held[k].take(of_triangle)), asked[:, k]) for k in order]
    others = [k for k in order if not sees[:, k].all()]
    trees = [_tree(placed, np.flatnonzero(held[k].take(of_triangle)), asked[:, k]) for k in others]
    return [Tree(np.ones(len(sees), np.bool_), base, None), *trees]


def _tree(placed: Placed, prim: NDArray[np.intp], asked: Bool) -> Tree:
    triangles = placed.triangles
    number = np.append(prim, MISS).astype(np.int32)
    corners = triangles[prim]
    if 2 * prim.size > len(triangles):
        return Tree(asked, Accel(placed.vertices, corners), number)
    used, compact = np.unique(corners, return_inverse=True)
    own = np.asarray(compact, np.int32).reshape(-1, 3)
    return Tree(asked, Accel(placed.vertices[used], own), number)


def kinds_of(instances: Instances, linking: Linking | None) -> tuple[NDArray[np.integer], Bool]:
    """`kind` and `sees` of `trees_of`."""
    bits = (instances.visibility & SEEING).astype(np.int64)
    blocks = np.ones((1, 1), np.bool_)
    if linking is not None:
        bits += linking.blocker.astype(np.int64) << SETS
        blocks = linking.blocks.astype(np.bool_)
    classes, kind = np.unique(bits, return_inverse=True)
    rows = [np.ones(len(classes), np.bool_)]
    rows += [(classes & bit) != 0 for bit in BITS]
    shades = (classes & Visibility.SHADOW) != 0
    rows += [shades & of_set[classes >> SETS] for of_set in blocks.T]
    return kind, np.stack(rows)


def sighted(placed: Placed, instances: Instances, linking: Linking | None = None) -> Accel | Sighted:
    """The acceleration structure of placed instances: a plain one where every ray sees every object."""
    kind, sees = kinds_of(instances, linking)
    if sees.all():
        return Accel(placed.vertices, placed.triangles)
    return Sighted(trees_of(placed, kind, sees))


def sees_apart(instances: Instances) -> bool:
    """Whether there are any that some rays do not see."""
    return bool((instances.visibility & SEEING != SEEING).any())


def among(base: Accel | Nested, placed: Placed, snapshot: Snapshot, out: Bool) -> Sighted:
    """A tree of what all rays see, and trees of the instances `out` (I,) that some do not."""
    kind, sees = kinds_of(snapshot.instances, snapshot.linking)
    plain = np.append(sees, np.ones((len(sees), 1), np.bool_), axis=1)
    return Sighted(trees_of(placed, np.where(out, kind, sees.shape[1]), plain, base=base))


def standing_out(snapshot: Snapshot) -> Bool:
    """(I,) the instances that some rays do not see."""
    kind, sees = kinds_of(snapshot.instances, snapshot.linking)
    return np.asarray(~sees.all(axis=0)[kind])


def without(placed: Placed, out: Bool) -> Placed:
    """The same with the triangles of the instances `out` (I,) shrunk to nothing: no ray hits them."""
    if not out.any():
        return placed
    triangles = placed.triangles.copy()
    gone = np.repeat(out, np.diff(placed.first_triangle))
    triangles[gone] = triangles[gone, :1]
    return placed._replace(triangles=triangles)
