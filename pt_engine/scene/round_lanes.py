"""What shader programs see of curves and points: strands' directions and lengths, points' centres."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..nodes.hashes import hash_uints, to_unit
from .attributes import Layer, build_layer
from .geometry import Geometry
from .hulls import FACES
from .round_hits import KIND, P0, R0, RIBBON, SPHERE
from .rounds import along, triangle_meshes
from .snapshot import CurvesData, Snapshot
from .strands import Samples

if TYPE_CHECKING:
    from .lanes import Lanes

Float32 = NDArray[np.float32]


class OnRounds(NamedTuple):
    """Lanes on curves and on points.

    Attributes
    ----------
    curves : (C,) intp
        Lanes on curves.
    tangent : (3, C) float32
        Unit, in the world, toward the tip.
    ribbons : (R,) intp
        Those of them that are ribbons.
    points : (P,) intp
        Lanes on points.
    centre : (3, P) float32
        In the recentred world.
    radius : (P,) float32
        In the world.
    random : (P,) float32
        Of the point, in [0, 1].
    """

    curves: NDArray[np.intp]
    tangent: Float32
    ribbons: NDArray[np.intp]
    points: NDArray[np.intp]
    centre: Float32
    radius: Float32
    random: Float32

    def strand(self, lanes: Lanes) -> Float32:
        """See `Lanes.strand`."""
        si, out = lanes.si, np.zeros((4, lanes.n), np.float32)
        prim, instance = si.prim.take(self.curves), si.instance.take(self.curves)
        u, v = si.u.take(self.curves), si.v.take(self.curves)
        values = lanes.scene.layer("strand", "").at(prim, instance, u, v)
        rounds = lanes.scene.geometry.rounds
        values[3] *= 2 if rounds is None else 2 * rounds.scale.take(instance)
        out[:, self.curves] = values
        return out


def strand_normal(lanes: Lanes, along: Float32) -> Float32:
    """See `Lanes.strand_normal`. Curves without normals have what Cycles takes, about (1, 1, 1)."""
    si, rounds = lanes.si, lanes.rounds
    if rounds is None or ("strand normal", "") not in lanes.scene.layers:
        across = np.zeros_like(along)
    else:
        normal = lanes.scene.layer("strand normal", "").at(si.prim, si.instance, si.u, si.v)
        across = lanes.to_world_normal(normal).take(rounds.curves, axis=1)
    across = vectors.normalize(across - vectors.dot(across, along) * along)
    lost = np.flatnonzero(~(vectors.dot(across, across) > 0.5))
    if len(lost):
        axis = along.take(lost, axis=1)
        diagonal = np.ones((3, 1), np.float32)
        across[:, lost] = vectors.cross(axis, vectors.normalize(vectors.cross(diagonal, axis)))
    return across


def on_rounds(lanes: Lanes) -> OnRounds | None:
    """See `Lanes.rounds`."""
    geometry, si = lanes.scene.geometry, lanes.si
    if geometry.rounds is None:
        return None
    where = np.flatnonzero(geometry.rounds.held(si.prim))
    prim = si.prim.take(where)
    rows = geometry.rounds.rows_of(prim)
    sphere = rows[:, KIND] == SPHERE
    strands, points = np.flatnonzero(~sphere), np.flatnonzero(sphere)
    row = np.ascontiguousarray(rows[strands].T).astype(np.float64)
    tangent = along(row, si.u.take(where.take(strands))).astype(np.float32)
    at = where.take(points)
    instance = si.instance.take(at)
    number = (prim.take(points) - geometry.first_triangle.take(instance)) // len(FACES)
    centre = np.ascontiguousarray(rows[points, P0].T)
    ribbons = where[rows[:, KIND] == RIBBON]
    return OnRounds(where.take(strands), tangent, ribbons, at, centre, rows[points, R0], random_of(number))


def along_hair(lanes: Lanes, corner: int) -> Float32:
    """See `Lanes.along_hair`."""
    direction = vectors.normalize(lanes.edges()[corner - 1])
    if lanes.rounds is not None:
        direction[:, lanes.rounds.curves] = lanes.rounds.tangent
    return direction


def generated_on_rounds(lanes: Lanes, generated: Float32) -> Float32:
    """Generated coordinates, where curves and points have none those of the object, as in Cycles."""
    rounds = lanes.scene.geometry.rounds
    if rounds is None:
        return generated
    none = np.flatnonzero(rounds.by_position.take(lanes.si.instance))
    if len(none):
        generated[:, none] = lanes.object_position().take(none, axis=1)
    return generated


def strand_layer(snapshot: Snapshot, geometry: Geometry, samples: list[Samples]) -> Layer:
    """Where along its strand a sample is, the strand's length, random number and radius, in object space."""
    tables = [along_strands(curves, points) for curves, points in zip(snapshot.curves, samples, strict=True)]
    return layer_of(snapshot, geometry, samples, tables, (0.0, 0.0, 0.0, 0.0))


def across_layer(snapshot: Snapshot, geometry: Geometry, samples: list[Samples]) -> Layer:
    """Curves' normals at the samples, in object space; 0 where there are none."""
    tables = [
        points.by_point(np.zeros_like(curves.points) if curves.normals is None else curves.normals)
        for curves, points in zip(snapshot.curves, samples, strict=True)
    ]
    return layer_of(snapshot, geometry, samples, tables, (0.0, 0.0, 0.0))


def layer_of(
    snapshot: Snapshot,
    geometry: Geometry,
    samples: list[Samples],
    tables: list[Float32],
    default: tuple[float, ...],
) -> Layer:
    """What is known of all samples, for the hulls' triangles."""
    pick = {}
    meshes = triangle_meshes(snapshot)
    for number, (points, table) in enumerate(zip(samples, tables, strict=True)):
        each = len(snapshot.meshes[meshes + number].triangles) // max(len(points.start), 1)
        start = np.repeat(points.start, each)
        pick[meshes + number] = table, np.stack([start, start + 1, start], axis=1)
    return build_layer(snapshot, geometry, pick, default)


def along_strands(curves: CurvesData, samples: Samples) -> Float32:
    """(S, 4) of all samples; between points all is linear, as in Cycles, though the spline is not."""
    first, count = curves.first.astype(np.int64), len(curves.points)
    with np.errstate(invalid="ignore", over="ignore"):
        step = np.linalg.norm(np.diff(curves.points.astype(np.float64), axis=0), axis=1)
    before = np.concatenate([[0.0], np.cumsum(np.nan_to_num(step, nan=0.0, posinf=0.0))])[:count]
    of_curve = np.repeat(np.arange(len(first) - 1), np.diff(first))
    begin = before[first[of_curve]]
    length = before[first[of_curve + 1] - 1] - begin
    way = (before - begin) / (length + (length == 0))
    table = np.stack([way, length, random_of(of_curve), np.maximum(curves.radius, 0)], axis=1).astype(
        np.float32
    )
    return samples.by_point(table)


def random_of(number: NDArray[np.integer]) -> Float32:
    """(N,) the random number in [0, 1] that Cycles gives to a curve or a point of this number."""
    return to_unit(hash_uints(number.astype(np.uint32), np.zeros(1, np.uint32)))
