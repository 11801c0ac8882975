"""A scene at single moments of the shutter: Embree knows no time, so what moves is built for each anew.

What stands still is prepared once and shared: its tree, its records, materials, textures, the world, and the
lamps, which shine from where they are in the middle of the shutter's time, as in Cycles. What moves has a
small tree of its own (`nearer.Nearer`); a moving camera alone needs nothing built. Light is sampled anew
where a mesh light moves. Uv maps, colours, Generated and tangents stay those of the middle, as in Cycles.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..cameras import make_camera
from ..emitters.lights import Lights
from ..emitters.triangle import TriangleEmitters
from .accel import Accel
from .attributes import Layer, appended, normal_layer, position_layer
from .catcher import catchers_of, catchers_tree, with_catchers_alone
from .displace import Layers, displaced
from .geometry import BOUND, FEW, PLANE, Geometry, Placed, mirrors, pack_planes, place
from .movement import Movement, some_instances
from .nearer import Nearer
from .own import looking_at_themselves
from .round_accel import through_hulls
from .shutter import Shutter
from .sighted import Sighted, sighted
from .snapshot import MeshData, Motion, PointsData, Snapshot

if TYPE_CHECKING:
    from ..nodes.compile import Materials
    from .hulls import Hulls
    from .nested import Nested
    from .scene import Scene
    from .strands import Samples

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
MakeLights = Callable[..., Lights]

PER_TRIANGLE = 130  # bytes of a slice: positions, records and Embree's own (docs/motion-blur.md)
SHAPED = {  # attribute tables that follow a mesh's shape, and whether they show it before displacement
    "normal": (normal_layer, False),
    "position": (position_layer, False),
    "rest": (position_layer, True),
    "rest_normal": (normal_layer, True),
}


EMPTY = MeshData("", np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32), np.zeros(0, np.int32))


@dataclass
class MovedGeometry(Geometry):
    """Geometry some of whose records, from triangle `first` on, are those of one moment."""

    first: int = 0
    moved: Float32 | None = None  # (M, 8)

    def planes(self, prim: Int32, instance: Int32 | None = None) -> Float32:
        record = super().planes(prim, instance)
        if self.moved is not None:
            lanes = np.flatnonzero((prim >= self.first) & (prim < self.first + len(self.moved)))
            record = record.copy()
            record[:, lanes] = self.moved.take(prim.take(lanes) - self.first, axis=0).T[: len(record)]
        return record


class Slices:
    """Scenes of single moments.

    Parameters
    ----------
    motion : Motion
    snapshot, rest : Snapshot
        Sorted by `movement.moving_last`; after and before displacement.
    materials : Materials
    layers : callable
        `prepare.shading_layers`, for displacement.
    hulls : Hulls

    Attributes
    ----------
    moving : range
        The instances that move or deform.
    triangles : int
        How many are placed anew for each moment.
    exposure : float
        `Motion.row_exposure`.
    """

    def __init__(
        self,
        motion: Motion,
        snapshot: Snapshot,
        rest: Snapshot,
        materials: Materials,
        layers: Layers,
        hulls: Hulls,
    ) -> None:
        self._snapshot, self._materials, self._layers, self._hulls = snapshot, materials, layers, hulls
        self._movement = Movement(rest, motion)
        self._shaped = self._movement.deforming | self._movement.bending
        self._shutter, self.exposure = Shutter(motion.shutter), motion.row_exposure
        self.moving = range(self._movement.first, len(snapshot.instances.mesh))
        links = snapshot.linking
        self._linking = None if links is None else links.of(slice(self._movement.first, None))
        self.triangles = sum(len(snapshot.meshes[snapshot.instances.mesh[k]].triangles) for k in self.moving)

    @property
    def bytes(self) -> int:
        """What the slices in use at a time take, about: one for some threads, the next for the others."""
        return 2 * PER_TRIANGLE * self.triangles

    def still(self, placed: Placed) -> tuple[Float32, Int32]:
        """Vertices and triangles that don't move, of those that are placed with records of their own."""
        self._first = len(placed.triangles) - self.triangles
        end = self._end(placed)
        return placed.vertices[:end], placed.triangles[: self._first]

    def tree(self, still: Accel | Nested | Sighted, placed: Placed) -> Accel | Nearer | Nested | Sighted:
        """What rays are sent at in the middle: the tree of what stands still, and one of what moves."""
        self._still_tree = still
        instances = self._snapshot.instances
        catchers = catchers_of(instances)
        if catchers.any():
            catchers[self.moving] = False
            self._still_catchers = catchers_tree(placed, instances, catchers)
        if not self._movement.geometry:
            return still
        end = self._end(placed)
        moving = Accel(placed.vertices[end:], placed.triangles[self._first :] - np.int32(end))
        return Nearer(still, moving, self._first)

    def _end(self, placed: Placed) -> int:
        """Where the moving vertices begin."""
        moving = placed.triangles[self._first :]
        return int(np.min(moving)) if len(moving) else len(placed.vertices)

    def start(self, scene: Scene, make_lights: MakeLights, emitters: TriangleEmitters | None) -> None:
        """Take over the prepared scene of the middle.

        `make_lights` makes its lights of other emissive triangles.
        """
        self._scene, self._make_lights, self._emitters = scene, make_lights, emitters
        self._shining = np.flatnonzero(scene.emissive_prim >= self._first)
        if not len(self._shining):
            del self._make_lights

    def through(self, scene: Scene, snapshot: Snapshot) -> Slices:
        """The slices of `scene` seen by the camera of `snapshot`, which may move."""
        assert snapshot.motion is not None
        other = self.of(scene)
        other._movement = self._movement.seen_by(snapshot.camera, snapshot.motion.cameras)
        return other

    def of(self, scene: Scene) -> Slices:
        """The slices of `scene`, a copy of the prepared one that shades or chooses its lights otherwise."""
        other = copy.copy(self)
        other._scene = scene
        return other

    def at(self, u: float, down: float = 0.5) -> Scene:
        """The scene at the moment that a uniform number in [0, 1) chooses; `Scene.time` says which.

        `down` is how far down the image the rows are that see it, from 0 to 1: where they are exposed one
        after the other for a share d of the time, it is d·shutter⁻¹(u) + (1 − d)·down, as in Cycles.
        """
        scene = copy.copy(self._scene)
        scene.time = time = self.exposure * self._shutter.time(u) + (1 - self.exposure) * down
        camera = self._movement.camera(time)
        if camera is not None:
            scene.camera = make_camera(camera, scene.geometry.origin)
        if self._movement.geometry:
            self._move(scene, time)
        return scene

    def _move(self, scene: Scene, time: float) -> None:
        """Put what moves where it is at a time."""
        still, geometry = self._scene, self._scene.geometry
        before, held = self._moved(time)
        moved = self._displaced(before)
        placed = place(moved, frame=(geometry.origin, geometry.radius))
        tree = sighted(placed, moved.instances, self._linking)
        scene.geometry = self._geometry(geometry, moved, placed)
        if geometry.rounds is not None:
            scene.geometry.rounds = geometry.rounds.at(moved.instances, held)
        scene.accel = through_hulls(Nearer(self._still_tree, tree, self._first), scene.geometry)
        scene.transforms = still.transforms.with_last(moved.instances.matrix, geometry.origin)
        if self._shaped:
            scene.use_layers(self._shaped_layers(moved, before))
        if still.own is not None:
            scene.own = still.own.with_last(placed, looking_at_themselves(moved, self._materials))
        if len(self._shining):
            scene.lights = self._lights(scene, placed)
        if scene.alone is not None:
            moving = catchers_tree(placed, moved.instances, catchers_of(moved.instances))
            scene.alone = with_catchers_alone(scene, Nearer(self._still_catchers, moving, self._first))

    def _moved(self, time: float) -> tuple[Snapshot, dict[int, Samples | PointsData]]:
        """The instances that move, deforming meshes before displacement; what is in hulls that change."""
        meshes, held = [*self._snapshot.meshes[: self._hulls.first], *self._hulls.meshes], {}
        for number, mesh in self._movement.meshes(time).items():
            meshes[number] = mesh
        for number, (points, radius) in self._movement.rounds(time).items():
            meshes[number], held[number] = self._hulls.bent(number, points, radius)
        instances = self._movement.instances(time)
        return replace(self._snapshot, meshes=tuple(meshes), instances=instances), held

    def _displaced(self, moved: Snapshot) -> Snapshot:
        """The same after displacement; what only moves keeps the shape that it has been given already."""
        rows = np.flatnonzero(np.isin(moved.instances.mesh, sorted(self._movement.deforming)))
        if not len(rows):
            return moved
        deforming = replace(moved, instances=some_instances(moved.instances, rows))
        return replace(moved, meshes=displaced(deforming, self._materials, self._layers).meshes)

    def _geometry(self, still: Geometry, moved: Snapshot, placed: Placed) -> Geometry:
        """Records of the moved triangles; materials and emitters' numbers are those of the middle."""
        few = len(still.records) <= FEW
        span = slice(self._first, self._first + self.triangles)
        records = (still.records if few else still.records[span]).copy()
        tail = records[span] if few else records
        pack_planes(placed.vertices, placed.triangles, tail[: self.triangles], flip=False)
        for k, matrix in enumerate(moved.instances.matrix):
            if mirrors(matrix):
                tail[placed.first_triangle[k] : placed.first_triangle[k + 1], : PLANE + 1] *= -1
        if few:
            return replace(still, records=records)
        parts = {name: getattr(still, name) for name in Geometry.__dataclass_fields__}
        return MovedGeometry(**parts, first=self._first, moved=tail)

    def _shaped_layers(self, moved: Snapshot, before: Snapshot) -> dict[tuple[str, str], Layer]:
        """The tables that follow the shape, deforming meshes' new ones behind the rest."""
        sources = {False: self._shapes(moved), True: self._shapes(before)}
        rows = np.isin(self._snapshot.instances.mesh, sorted(self._shaped))
        tables = {}
        for (kind, name), table in self._scene.layers.items():
            if kind in SHAPED:
                make, undisplaced = SHAPED[kind]
                last = make(sources[undisplaced], self._scene.geometry)
                tables[kind, name] = table if last is None else appended(table, last, rows)
        return tables

    def _shapes(self, source: Snapshot) -> Snapshot:
        """All instances, of empty meshes where they keep their shape."""
        meshes = tuple(mesh if m in self._shaped else EMPTY for m, mesh in enumerate(source.meshes))
        return replace(self._snapshot, meshes=meshes)

    def _lights(self, scene: Scene, placed: Placed) -> Lights:
        """The lights with the moving ones among the emissive triangles where they are now."""
        emitters, prim = self._emitters, self._scene.emissive_prim[self._shining] - self._first
        assert emitters is not None
        vertices, error = emitters.vertices.copy(), emitters.error.copy()
        vertices[self._shining] = placed.vertices[placed.triangles[prim]]
        error[self._shining] = scene.geometry.planes(self._scene.emissive_prim[self._shining])[BOUND]
        lights = self._make_lights(triangles=replace(emitters, vertices=vertices, error=error))
        lights.make_ready()
        return lights
