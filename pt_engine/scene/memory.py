"""What a scene will take in memory, before it is built; and so which instances are placed.

Measured with Embree 4.4: while it builds, a triangle takes 101 bytes besides its indices, of which 57 stay
(tests/scene/test_memory.py holds the sum to 15 %).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .geometry import Int32
from .instancing import PLAIN, Sharing
from .snapshot import CurvesData, MeshData, PointsData, Snapshot

CORNERS, POSITION = 12, 12  # of a triangle's indices and of a vertex, in our arrays
EMBREES_POSITION = 16  # of a vertex, as embreex hands it over
TREE, BUILDING = 57, 101  # of a triangle in Embree: afterwards, and while it builds
RECORD = 34  # eight floats and a surface number
INSTANCE = 1200  # of an instance: matrices, boxes, Embree's own
CHANNELS = {"uv": 2, "color": 4, "attribute": 5, "tangent": 12, "position": 3, "generated": 3, "rest": 6}


class TooLarge(MemoryError):
    """The scene does not fit in the memory that there is; the message says what of it takes how much."""


class Need(NamedTuple):
    """Bytes of a scene.

    Attributes
    ----------
    building : int
        At the peak of the build, beyond the snapshot.
    kept : int
        While it renders, beyond the snapshot.
    """

    building: int
    kept: int

    @property
    def peak(self) -> int:
        return max(self)


class Counts(NamedTuple):
    """Triangles and vertices of meshes."""

    triangles: int
    vertices: int


def need(snapshot: Snapshot, sharing: Sharing | None, attributes: frozenset[str] = frozenset()) -> Need:
    """What placing the instances like this takes; `attributes` are what programs read (`Materials.needs`)."""
    every = snapshot.instances.mesh
    none = every[:0]
    plain = every if sharing is None else every[sharing.prototype == PLAIN]
    copied = none if sharing is None else every[sharing.placed()]
    samples = none if sharing is None else every[sharing.sample]
    nested = none if sharing is None else samples[sharing.nested]
    own, shared, apart = (count(snapshot, meshes) for meshes in (plain, samples, nested))
    placed = count(snapshot, np.concatenate([plain, copied, nested]))
    ours = CORNERS * own.triangles + POSITION * own.vertices
    embrees = CORNERS * placed.triangles + EMBREES_POSITION * placed.vertices
    records = RECORD * (own.triangles + shared.triangles)
    per_instance = INSTANCE * len(every)
    # nested meshes are built one by one, each for itself
    building = BUILDING * (placed.triangles - apart.triangles) + TREE * apart.triangles
    tree = TREE * placed.triangles
    return Need(
        per_instance + ours + embrees + max(building, tree + records),
        per_instance + embrees + tree + records + layers(snapshot.meshes, attributes),
    )


def count(snapshot: Snapshot, meshes: Int32) -> Counts:
    """Of some meshes, those that occur twice counted twice."""
    sizes = np.array([(len(m.triangles), len(m.vertices)) for m in snapshot.meshes], np.int64).reshape(-1, 2)
    return Counts(*sizes[meshes].sum(axis=0).tolist())


def snapshot_bytes(snapshot: Snapshot) -> int:
    """Of the arrays that an export has made."""
    made: tuple[MeshData | CurvesData | PointsData, ...]
    made = (*snapshot.meshes, *snapshot.curves, *snapshot.points)
    arrays = [a for mesh in made for a in (*vars(mesh).values(), *mesh.uvs.values(), *mesh.colors.values())]
    arrays += [a for image in snapshot.images for a in (image.encoded, image.pixels)]
    if snapshot.motion is not None:
        arrays += [rows.matrix for rows in snapshot.motion.instances]
        arrays += [a for mesh in snapshot.motion.meshes for a in (mesh.vertices, mesh.normals)]
    return sum({id(a): a.nbytes for a in arrays if isinstance(a, np.ndarray)}.values())


def layers(meshes: tuple[MeshData, ...], attributes: frozenset[str]) -> int:
    """Of the tables of shading attributes."""
    total = sum(m.normals.nbytes + CORNERS * len(m.triangles) for m in meshes if m.normals is not None)
    for attribute in attributes:
        channels = CHANNELS.get(attribute.partition(":")[0], 0)
        for mesh in meshes if channels else ():
            rows = len(mesh.vertices) if mesh.corner_index is None else 3 * len(mesh.triangles)
            total += CORNERS * len(mesh.triangles) + 4 * channels * rows
    return total


def sharing_that_fits(
    snapshot: Snapshot, sharing: Sharing | None, attributes: frozenset[str], room: int | None, hulls: int = 0
) -> Sharing | None:
    """The sharing with as many prototypes nested as it takes to fit in `room` bytes, the largest first.

    `hulls` are the bytes of meshes that are yet to be made.

    Raises
    ------
    TooLarge
        Nothing helps.
    """

    def peak() -> int:
        return need(snapshot, sharing, attributes).peak + hulls

    if room is None or peak() <= room:
        return sharing
    if sharing is not None:
        times = np.bincount(sharing.prototype[sharing.prototype != PLAIN], minlength=len(sharing.sample))
        size = np.array([len(snapshot.meshes[m].triangles) for m in snapshot.instances.mesh[sharing.sample]])
        for number in np.argsort(-size * (times - 1), kind="stable"):
            sharing.nested[number] = True
            if peak() <= room:
                return sharing
    raise TooLarge(refusal(snapshot, peak(), room))


def refusal(snapshot: Snapshot, needed: int, room: int) -> str:
    """Why a scene is not built."""
    triangles = count(snapshot, snapshot.instances.mesh).triangles
    once = sum(len(mesh.triangles) for mesh in snapshot.meshes)
    return (
        f"the scene needs about {gigabytes(needed)} of memory, and {gigabytes(max(room, 0))} are left: "
        f"{triangles:,} triangles in {len(snapshot.instances.mesh):,} objects ({once:,} without repetition)"
    )


def gigabytes(size: float) -> str:
    """For a person."""
    return f"{size / 1e9:.2f} GB" if size >= 1e7 else f"{size / 1e6:.2f} MB"
