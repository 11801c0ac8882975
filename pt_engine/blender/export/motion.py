"""What moves while the shutter is open, read at several times of it.

Instances are known again at another time by their object, their instancer and their persistent id. What is
missing at a time is then where it is in the middle; missing at the end, it goes the rest of its way in all of
the time; a particle that is missing is not rendered at all. All of that is as in Cycles. A mesh whose corners
change keeps the shape of the middle.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ...scene.snapshot import (
    CameraData,
    InstanceMotion,
    Instances,
    MeshData,
    MeshMotion,
    Motion,
    RoundMotion,
)
from .bending import Bend, by_velocity, has_velocity, velocity
from .camera import export_camera
from .meshes import read, shading_normals
from .shutter import Shutter, deforms, steps_of


class Mover(NamedTuple):
    """What is exported of an instance, how often to look at it, and its mesh if that may deform."""

    rows: tuple[int, ...]  # in `Instances`: several where it shows strands beside its mesh
    steps: int
    mesh: int  # -1 where another one shows the same mesh, or its shape is not to be blurred
    particle: bool


@dataclass
class Shape:
    """A mesh at the times looked at so far, while its corners stay the same."""

    name: str
    corners: tuple[int, ...]
    middle: MeshData
    steps: int
    velocity: np.ndarray | None = None
    vertices: dict = field(default_factory=dict)
    normals: dict = field(default_factory=dict)
    problem: str = ""


class MotionReader:
    """Reads motion around the middle of the shutter's time, where the scene is now.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
    shutter : Shutter
    rows : (I,) int
        Which of the depsgraph's instances are those of the snapshot.
    instances : Instances
    meshes : sequence of MeshData
    rounds : sequence of CurvesData, then of PointsData
    """

    def __init__(self, depsgraph, shutter: Shutter, rows, instances: Instances, meshes, rounds) -> None:
        self.depsgraph, self.shutter = depsgraph, shutter
        self.instances, self.meshes, self.rounds = instances, meshes, rounds
        self.movers: dict[tuple, Mover] = {}
        self.shapes: dict[int, Shape] = {}
        self.bends: dict[int, Bend] = {}
        self.strands: dict[tuple, int] = {}  # by which object to look at each of the bends
        self.matrices: dict[tuple, dict[int, np.ndarray]] = {}
        self.unsupported: list[tuple[str, str, str]] = []
        exported: dict[int, tuple[int, ...]] = {}
        for k, row in enumerate(rows):
            exported[int(row)] = (*exported.get(int(row), ()), k)
        self.find_movers(exported)

    def find_movers(self, exported: dict[int, tuple[int, ...]]) -> None:
        """Who is to be looked at, and the shapes of the middle."""
        seen: set[int] = set()
        for row, instance in enumerate(self.depsgraph.object_instances):
            own = exported.get(row, ())
            owner, parent = instance.object, instance.parent if instance.is_instance else None
            steps = steps_of(owner, parent)
            if not own or not steps:
                continue
            mesh = int(self.instances.mesh[own[0]])
            first = mesh not in seen
            seen.add(mesh)
            bends = first and deforms(owner, parent) and may_deform(owner)
            if bends and mesh < len(self.meshes):
                self.shapes[mesh] = self.shape_of(owner, self.meshes[mesh], steps)
            else:
                mesh = -1
            number = int(self.instances.mesh[own[-1]])
            if bends and number >= len(self.meshes):
                self.strands[identity(instance)] = number
                middle = self.rounds[number - len(self.meshes)]
                speed = None if owner.type == "MESH" else velocity(owner.data)
                self.bends[number] = Bend(owner.name, middle, steps, speed)
            particle = instance.is_instance and instance.particle_system is not None
            self.movers[identity(instance)] = Mover(own, steps, mesh, particle)

    @staticmethod
    def shape_of(owner, middle: MeshData, steps: int) -> Shape:
        """A shape to be looked at, as it is in the middle."""
        data = owner.to_mesh()
        try:
            shape = Shape(owner.name, corners_of(data), middle, steps, velocity(data))
        finally:
            owner.to_mesh_clear()
        if shape.corners[0] != len(middle.vertices):
            shape.problem = "adaptive subdivision: sharp where it deforms"
        return shape

    def read(self, camera, middle: CameraData, render, size) -> tuple[Motion | None, np.ndarray]:
        """The motion, and the rows of the instances that stay: all but particles that come or go.

        `camera` is the evaluated camera, `middle` what it is now; `render` and `size` are for its framing.
        """
        of_camera = steps_of(camera, None)
        finest = max([mover.steps for mover in self.movers.values()] + [of_camera])
        if not finest:
            return None, np.arange(len(self.instances.mesh))
        cameras: dict[int, CameraData] = {}
        original = camera.original
        for time in range(finest):
            if 2 * time == finest - 1:
                cameras[time] = middle
                continue
            self.shutter.go(2 * time / (finest - 1) - 1)
            self.look(time, finest)
            if of_camera and falls_on(time, finest, of_camera):
                there = original.evaluated_get(self.depsgraph)
                cameras[time] = export_camera(there, render, size=size, unsupported=[])
        self.shutter.go(0.0)
        kept, moved = self.moved(finest)
        shapes = (self.deformed(number, shape, finest) for number, shape in self.shapes.items())
        meshes = tuple(shape for shape in shapes if shape is not None)
        bent = (self.bent(number, bend, finest) for number, bend in self.bends.items())
        rounds = tuple(bend for bend in bent if bend is not None)
        path = tuple(cameras[time] for time in sorted(cameras))
        path = path if any(not same(middle, other) for other in path) else ()
        if not (moved or meshes or path or rounds):
            return None, kept
        exposure = self.shutter.row_exposure
        return Motion(self.shutter.openness, moved, meshes, path, exposure, rounds), kept

    def look(self, time: int, finest: int) -> None:
        """Where everything is now, which is one of the times that are looked at."""
        every = self.depsgraph.object_instances
        matrix = np.empty(len(every) * 16, np.float32)
        every.foreach_get("matrix_world", matrix)
        matrix = matrix.reshape(-1, 4, 4).transpose(0, 2, 1)
        for row, instance in enumerate(every):
            key = identity(instance)
            mover = self.movers.get(key)
            if mover is None or not falls_on(time, finest, mover.steps):
                continue
            if key in self.strands and not self.bends[self.strands[key]].problem:
                self.bends[self.strands[key]].look(instance.object, self.depsgraph, time)
            self.matrices.setdefault(key, {})[time] = matrix[row].astype(np.float64)
            if mover.mesh >= 0 and not self.shapes[mover.mesh].problem:
                self.look_at_shape(self.shapes[mover.mesh], instance.object, time)

    @staticmethod
    def look_at_shape(shape: Shape, owner, time: int) -> None:
        """A mesh as it is now, which does not matter where an attribute says how it moves."""
        if shape.velocity is not None:
            return
        data = owner.to_mesh()
        try:
            if data is None or corners_of(data) != shape.corners:
                shape.problem = "its faces change while the shutter is open: sharp where it deforms"
                return
            vertices = read(data.attributes["position"].data, "vector", np.float32, 3)
            if np.array_equal(vertices, shape.middle.vertices):
                return
            normals, _ = shading_normals(data, None, None)
            if np.shape(normals) != np.shape(shape.middle.normals):
                shape.problem = "its shading changes kind while the shutter is open: sharp where it deforms"
                return
            shape.vertices[time], shape.normals[time] = vertices, normals
        finally:
            owner.to_mesh_clear()

    def moved(self, finest: int) -> tuple[np.ndarray, tuple[InstanceMotion, ...]]:
        """Rows of instances that are rendered, and the paths of those that move, by their number of steps."""
        paths: dict[int, list[tuple[int, np.ndarray]]] = {}
        gone = []
        for key, mover in self.movers.items():
            found, middle = self.matrices.get(key, {}), self.instances.matrix[mover.rows[0]]
            times = range(0, finest, (finest - 1) // (mover.steps - 1))
            absent = [time for time in times if time not in found and 2 * time != finest - 1]
            if absent and mover.particle:
                gone += mover.rows
                continue
            path = np.array([found.get(time, middle) for time in times])
            if absent:
                self.note_absent(mover.rows[0])
            if absent and absent[-1] == times[-1] and (path != middle).any():
                path = path[:-1]
            if (path != middle).any():
                paths.setdefault(len(path), []).extend((row, path) for row in mover.rows)
        kept = np.setdiff1d(np.arange(len(self.instances.mesh)), gone)
        place = np.zeros(len(self.instances.mesh), np.int32)
        place[kept] = np.arange(len(kept))
        motions = tuple(
            InstanceMotion(place[[row for row, _ in rows]], np.array([path for _, path in rows]))
            for rows in paths.values()
        )
        return kept, motions

    def note_absent(self, row: int) -> None:
        """Say what becomes of an instance that is not there all the time."""
        where, what = f"Object {self.instances.names[row]}", "appears or vanishes while the shutter is open"
        self.unsupported.append((where, what, "is there all the time, on a path made of what is known"))

    def deformed(self, number: int, shape: Shape, finest: int) -> MeshMotion | None:
        """The shapes of a mesh; None where it has but one."""
        if shape.problem:
            self.unsupported.append((f"Object {shape.name}", "motion blur", shape.problem))
        if shape.problem:
            return None
        if shape.velocity is not None and shape.velocity.any():
            vertices = by_velocity(shape.middle.vertices, shape.velocity, self.shutter.seconds)
            normals = shape.middle.normals
            return MeshMotion(number, vertices, None if normals is None else np.array([normals] * 2))
        if not shape.vertices:
            return None
        times = range(0, finest, (finest - 1) // (shape.steps - 1))
        middle = shape.middle
        vertices = np.array([shape.vertices.get(time, middle.vertices) for time in times])
        normals = middle.normals
        if normals is not None:
            normals = np.array([shape.normals.get(time, middle.normals) for time in times])
        return MeshMotion(number, vertices, normals)

    def bent(self, number: int, bend: Bend, finest: int) -> RoundMotion | None:
        """The shapes of curves or points; None where they have but one."""
        if bend.problem:
            self.unsupported.append((f"Object {bend.name}", "motion blur", bend.problem))
        return bend.motion(number, finest, self.shutter.seconds)


def identity(instance) -> tuple:
    """What an instance is known again by at another time."""
    owner = instance.object.original.as_pointer()
    if not instance.is_instance:
        return (owner,)
    return owner, instance.parent.original.as_pointer(), *instance.persistent_id


def may_deform(owner) -> bool:
    """Whether an evaluated object has anything that could change its shape."""
    data = owner.original.data
    keys = getattr(data, "shape_keys", None)
    animated = getattr(data, "animation_data", None) is not None
    moving = keys or animated or has_velocity(data)
    return bool(len(owner.modifiers) or moving or owner.original.type != "MESH")


def corners_of(data) -> tuple[int, ...]:
    """Number of vertices, and checksums of the vertices at all corners and of the faces' sizes."""
    corners = read(data.attributes[".corner_vert"].data, "value", np.int32)
    sizes = read(data.polygons, "loop_total", np.int32)
    return len(data.vertices), zlib.crc32(corners), zlib.crc32(sizes)


def falls_on(time: int, finest: int, steps: int) -> bool:
    """Whether one of `steps` even times is the given one of the `finest`."""
    return time % ((finest - 1) // (steps - 1)) == 0


def same(a: CameraData, b: CameraData) -> bool:
    """Whether two cameras are one."""
    return np.array_equal(a.matrix, b.matrix) and replace(a, matrix=None) == replace(b, matrix=None)
