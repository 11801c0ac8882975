"""What a snapshot's moving parts are like at any time while the shutter is open.

Instances that move come last (`moving_last`), so that all the rest of a scene can stay as it is. Matrices are
blended as in `matrix_path`, vertices, normals and the camera's framing and focus linearly between their
steps.
"""

from __future__ import annotations

import copy
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .matrix_path import MatrixPath, step
from .snapshot import CameraData, Instances, MeshData, Motion, Snapshot

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Rows = slice | NDArray[np.intp]


def moving_last(snapshot: Snapshot) -> Snapshot:
    """The snapshot with the instances that move behind those that don't, both in their order.

    Curves and points come last of those that stand still and first of those that move, so that all are
    neighbours.
    """
    motion, is_round = snapshot.motion, snapshot.instances.mesh >= len(snapshot.meshes)
    if motion is None and not is_round.any():
        return snapshot
    moving = np.zeros_like(is_round) if motion is None else moves(snapshot, motion)
    return reordered(snapshot, np.argsort(2 * moving + (is_round != moving), kind="stable"))


def reordered(snapshot: Snapshot, order: NDArray[np.intp]) -> Snapshot:
    """The snapshot with its instances in another order, and all that numbers them."""
    instances, motion = some_instances(snapshot.instances, order), snapshot.motion
    links = None if snapshot.linking is None else snapshot.linking.of(order)
    if motion is not None:
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        moved = tuple(replace(m, instance=place[m.instance].astype(np.int32)) for m in motion.instances)
        motion = replace(motion, instances=moved)
    return replace(snapshot, instances=instances, linking=links, motion=motion)


def moves(snapshot: Snapshot, motion: Motion) -> NDArray[np.bool_]:
    """(I,) which instances move or deform."""
    shapes = [*(m.mesh for m in motion.meshes), *(m.geometry for m in motion.rounds)]
    mask: NDArray[np.bool_] = np.isin(snapshot.instances.mesh, shapes)
    for rows in motion.instances:
        mask[rows.instance] = True
    return mask


def some_instances(instances: Instances, rows: Rows) -> Instances:
    """Some rows, in the order of `rows`."""
    return Instances(**{f.name: _some(getattr(instances, f.name), rows) for f in fields(instances)})


def _some(values: Any, rows: Rows) -> Any:
    if values is None:
        return None
    if isinstance(values, dict):
        return {name: _some(table, rows) for name, table in values.items()}
    if isinstance(values, tuple):
        return values[rows] if isinstance(rows, slice) else tuple(values[k] for k in rows)
    return values[rows]


class Movement:
    """The moving part of a snapshot that `moving_last` has sorted.

    Parameters
    ----------
    snapshot : Snapshot
        With `motion`.

    Attributes
    ----------
    first : int
        The first instance that moves; there may be none.
    deforming : frozenset of int
        Meshes that change their shape.
    bending : frozenset of int
        Curves and points that do, as `Instances.mesh` has them.
    """

    def __init__(self, snapshot: Snapshot, motion: Motion) -> None:
        self._snapshot, self._motion = snapshot, motion
        self.first = int((~moves(snapshot, motion)).sum())
        self.deforming = frozenset(m.mesh for m in motion.meshes)
        self.bending = frozenset(m.geometry for m in motion.rounds)
        self._paths = [(rows.instance - self.first, MatrixPath.of(rows.matrix)) for rows in motion.instances]
        self._look_through(snapshot.camera, motion.cameras)

    def _look_through(self, camera: CameraData, cameras: tuple[CameraData, ...]) -> None:
        self._camera, self._cameras = camera, cameras
        matrices = np.array([step.matrix for step in cameras], np.float64)
        self._camera_path = MatrixPath.of(matrices[None]) if cameras else None

    def seen_by(self, camera: CameraData, cameras: tuple[CameraData, ...]) -> Movement:
        """The same with another camera, which `cameras` move if there are any."""
        other = copy.copy(self)
        other._look_through(camera, cameras)
        return other

    @property
    def geometry(self) -> bool:
        """Whether any instance moves or deforms."""
        return self.first < len(self._snapshot.instances.mesh)

    def instances(self, time: float) -> Instances:
        """Those that move, where they are at a time in [0, 1]."""
        rows = some_instances(self._snapshot.instances, slice(self.first, None))
        matrix = rows.matrix.copy()
        for instance, path in self._paths:
            matrix[instance] = path.at(time)
        return replace(rows, matrix=matrix)

    def meshes(self, time: float) -> dict[int, MeshData]:
        """Those that deform, by number, in their shape at a time."""
        shaped = {}
        for motion in self._motion.meshes:
            mesh = self._snapshot.meshes[motion.mesh]
            first, part = step(time, len(motion.vertices))
            vertices, normals = between(motion.vertices, first, part), mesh.normals
            if motion.normals is not None:
                normals = between(motion.normals, first, part)
                length = np.sqrt((normals * normals).sum(axis=1, keepdims=True))
                normals /= length + (length == 0)
            shaped[motion.mesh] = replace(mesh, vertices=vertices, normals=normals)
        return shaped

    def rounds(self, time: float) -> dict[int, tuple[Float32, Float32]]:
        """Points (P, 3) and radii (P,) of curves and points that change, at a time."""
        bent = {}
        for motion in self._motion.rounds:
            where = step(time, len(motion.points))
            bent[motion.geometry] = between(motion.points, *where), between(motion.radius, *where)
        return bent

    def camera(self, time: float) -> CameraData | None:
        """The camera at a time; None where it stands still."""
        if self._camera_path is None:
            return None
        first, part = step(time, len(self._cameras))
        a, b = self._cameras[first], self._cameras[first + 1]

        def on_the_way(x: float, y: float) -> float:
            return (1 - part) * x + part * y

        left, right, bottom, top = (on_the_way(x, y) for x, y in zip(a.frame, b.frame, strict=True))
        return replace(
            self._camera,
            matrix=self._camera_path.at(time)[0],
            frame=(left, right, bottom, top),
            aperture_radius=on_the_way(a.aperture_radius, b.aperture_radius),
            focus_distance=on_the_way(a.focus_distance, b.focus_distance),
            fisheye_fov=on_the_way(a.fisheye_fov, b.fisheye_fov),
        )


def beside(cameras: tuple[CameraData, ...], middle: CameraData, other: CameraData) -> tuple[CameraData, ...]:
    """What another camera does that is fixed to a moving one, whose place in the middle is `middle`.

    Its image is shifted by as many image widths as it is then, whatever the lens does.
    """
    apart = np.linalg.inv(middle.matrix) @ other.matrix
    shift = (other.frame[0] - middle.frame[0]) / (middle.frame[1] - middle.frame[0])
    moved = []
    for camera in cameras:
        left, right, bottom, top = camera.frame
        across = shift * (right - left)
        frame = left + across, right + across, bottom, top
        moved.append(replace(camera, matrix=camera.matrix @ apart, frame=frame, stereo=other.stereo))
    return tuple(moved)


def between(steps: Float32, first: int, part: float) -> Float32:
    """(n, ...) what lies `part` of the way between two of some steps (K, n, ...)."""
    weight = np.float32(part)
    mixed: Float32 = steps[first] * (np.float32(1) - weight) + steps[first + 1] * weight
    return mixed
