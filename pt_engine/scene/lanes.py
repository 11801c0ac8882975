"""What a shader program sees of the points it shades.

`Lanes` is the view of one slice of a wavefront's `Surface` that programs get, computing only what they ask
for. Everything faces the viewer: `ng` and `ns` are on `wi`'s side.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.view import View
from ..nodes.ir import REST
from .arrivals import Arrival
from .attributes import between
from .bevel import bevelled
from .faces import Faces
from .moved import moved, steps
from .raised_normal import raised_normal
from .raycast import Met, raycast
from .rest import at_rest, rest_steps
from .round_lanes import OnRounds, along_hair, generated_on_rounds, on_rounds, strand_normal
from .surface import Surface
from .tracing import open_share

if TYPE_CHECKING:
    from .scene import Scene

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]


class Lanes:
    """A slice of lanes on surfaces of one batch, for shader programs.

    Parameters
    ----------
    scene : Scene
    si : Surface
        The slice's hits.
    path : Arrival
        How the lanes' rays came here.
    smooth : bool
        Whether the slice lies on geometry with shading normals.
    """

    _raised: tuple[Float32, Float32] | None = None  # the last normal that was, and to what
    displaced: Lanes | None = None  # where these lanes are those before displacement: those after it

    def __init__(self, scene: Scene, si: Surface, path: Arrival, smooth: bool) -> None:
        self.scene, self.si, self.smooth, self._path = scene, si, smooth, path
        self.n = si.size
        self.p, self.wi, self.ng = si.p, si.wi, si.ng
        self.faces = Faces(scene, si)
        self._steps: dict[float, tuple[Float32, Float32]] = {}

    @property
    def batch(self) -> int:
        """Number of the lanes' batch of materials."""
        material = self.scene.geometry.surface_material[self.si.surface[0]]
        return int(self.scene.materials.batch_of[material])

    @property
    def view(self) -> View:
        """The camera's space and image."""
        return self.scene.view

    @property
    def ray_kind(self) -> Int32:
        """(n,) `RayKind` bits of the ray that arrived."""
        return self._path.kind

    @property
    def depth(self) -> Int32:
        """(n,) bounces so far, without the transparent ones."""
        return self._path.depth

    @property
    def transparent_depth(self) -> Int32:
        """(n,) transparent surfaces passed so far."""
        return self._path.passed

    def depth_of(self, kind: str) -> Int32:
        """(n,) bounces of one kind so far: "diffuse", "glossy", "transmission" or "portal"."""
        return getattr(self._path, f"{kind}_depth")  # type: ignore[no-any-return]

    @cached_property
    def backfacing(self) -> Float32:
        """(n,) 1 where the viewer is behind the face, else 0."""
        return self.si.back

    @cached_property
    def ray_length(self) -> Float32:
        """(n,) length of the ray that arrived, from the last real bounce."""
        return self.si.t + self._path.travelled

    @property
    def sharpness(self) -> Float32 | None:
        """(n,) smallest density among the path's directions so far; None where it is not tracked."""
        return self._path.sharpness

    @property
    def noise(self) -> NDArray[np.uint32] | None:
        """(2, n) what `core.keyed` makes random numbers of; None where there are none."""
        return self._path.noise

    def open_share(self, normal: Float32, distance: Float32, samples: int, local: bool, key: int) -> Float32:
        """(n,) see `tracing.open_share`."""
        return open_share(self, normal, distance, samples, local, key)

    def bevelled(self, radius: Float32, samples: int, key: int, surface: Float32) -> Float32:
        """(3, n) see `bevel.bevelled`."""
        return bevelled(self, radius, samples, key, surface)

    def raycast(
        self, position: Float32, direction: Float32, reach: Float32, local: bool, names: tuple[str, ...]
    ) -> Met | None:
        """See `raycast.raycast`."""
        return raycast(self, position, direction, reach, local, names)

    @cached_property
    def footprint(self) -> Float32:
        """(n,) width of the ray that arrived, where it arrived."""
        radius, spread = self._path.radius, self._path.spread
        if radius is None or spread is None:
            return np.float32(self.scene.pixel_angle) * self.ray_length
        return radius + spread * self.si.t

    @property
    def position(self) -> Float32:
        """(3, n) true world position."""
        return self.si.p + self.scene.origin32

    @cached_property
    def material(self) -> Int32:
        """(n,) index into `Snapshot.materials`."""
        return self.scene.geometry.surface_material.take(self.si.surface, mode="clip")

    @cached_property
    def ns(self) -> Float32:
        """(3, n) shading normal, on the viewer's side of the face."""
        if not self.smooth or self.scene.normals is None:
            return self.ng
        n = self.to_world_normal(self.object_normal())
        n *= 1 - 2 * self.backfacing
        n = vectors.normalize(n)
        lost = np.flatnonzero(~(vectors.dot(n, n) > 0.5))  # corners that cancel, or say nothing: as in Cycles
        if len(lost):
            n[:, lost] = self.ng.take(lost, axis=1)
        return n

    @cached_property
    def horizon(self) -> Float32:
        """(3, n) normal of the horizon below which no emitter shines: `ns` where shadow rays follow it."""
        return self.ns if self.smooth and self.scene.terminator is not None else self.ng

    def raised(self, normal: Float32 | None) -> Float32:
        """(3, n) a normal (None: `ns`) as glossy closures use it: see `raised_normal`."""
        if normal is None:
            return self._raised_ns
        known = self._raised
        if known is None or known[0] is not normal:  # the gain of a gloss asks for what its closure will
            known = self._raised = normal, raised_normal(self.ng, self.wi, normal)
        return known[1]

    @cached_property
    def _raised_ns(self) -> Float32:
        return raised_normal(self.ng, self.wi, self.ns)

    def object_normal(self) -> Float32:
        """(3, n) interpolated shading normal in object space (unnormalised); needs `smooth`."""
        si, normals = self.si, self.scene.normals
        if normals is None:
            return self.to_object_normal(self.ng * (1 - 2 * self.backfacing))
        return normals.at(si.prim, si.instance, si.u, si.v)

    def frame_normal(self) -> Float32:
        """(3, n) unit object-space normal, blended of units also where `ns` blends in the world."""
        si, normals = self.si, self.scene.normals
        if normals is None:
            return vectors.normalize(self.object_normal())
        a, b, c = (vectors.normalize(n) for n in normals.corners(si.prim, si.instance))
        return vectors.normalize(between((a, b - a, c - a), si.u, si.v))

    def to_world_normal(self, n: Float32) -> Float32:
        """Object to world through the instances' inverse transposes (unnormalised)."""
        return self.scene.transforms.normal_to_world(n, self.si.instance)

    def to_object_normal(self, n: Float32) -> Float32:
        """World to object space (unnormalised)."""
        return self.scene.transforms.normal_to_object(n, self.si.instance)

    def to_object_vector(self, w: Float32) -> Float32:
        """A direction in object space (unnormalised)."""
        return self.scene.transforms.vector_to_object(w, self.si.instance)

    def to_world_vector(self, w: Float32) -> Float32:
        """A direction from object to world space (unnormalised)."""
        return self.scene.transforms.vector_to_world(w, self.si.instance)

    def object_position(self) -> Float32:
        """(3, n) position in object space."""
        return self.scene.transforms.point_to_object(self.si.p, self.si.instance)

    def uv(self, name: str) -> Float32:
        """(2, n) of a uv map ("" for the active one)."""
        return self.faces.at(self.si, "uv", name)

    def color(self, name: str) -> Float32:
        """(4, n) of a colour attribute ("" for the active one)."""
        return self.faces.at(self.si, "color", name)

    def attribute(self, name: str) -> Float32:
        """(5, n) of an attribute: x, y, z, alpha, and what it is as a number."""
        return self.faces.at(self.si, "attribute", name)

    def generated(self) -> Float32:
        """(3, n) Generated coordinates."""
        return generated_on_rounds(self, self.faces.at(self.si, "generated"))

    @cached_property
    def rounds(self) -> OnRounds | None:
        """Which lanes are on curves and points, and what that is like; None where there are none."""
        return on_rounds(self)

    def along_hair(self, corner: int) -> Float32:
        """(3, n) unit direction of a strand toward its tip; of a triangle, from corner 0 to 1 or 2."""
        return along_hair(self, corner)

    def strand(self) -> Float32:
        """(4, n) where along its strand, the strand's length, random number and thickness; else 0."""
        return np.zeros((4, self.n), np.float32) if self.rounds is None else self.rounds.strand(self)

    def strand_normal(self, along: Float32) -> Float32:
        """(3, C) unit normal of the lanes on curves, across their direction `along`."""
        return strand_normal(self, along)

    def object_tangent(self, uv_name: str) -> tuple[Float32, Float32]:
        """Object-space direction of growing u (unnormalised), sign of the bitangent; 0 without the map."""
        values = self.faces.at(self.si, "tangent", uv_name)
        return values[:3], values[3]

    def edges(self) -> tuple[Float32, Float32]:
        """(3, n) world-space edges from a triangle's corner 0 to 1 and 2, turned round from behind."""
        side = 1 - 2 * self.backfacing
        first, second = (self.to_world_vector(e) * side for e in self.faces.spans("position")[1:])
        return first, second

    def barycentric(self) -> Float32:
        """(2, n) weights of the triangle's corners 1 and 2."""
        return np.stack([self.si.u, self.si.v])

    def sides(self) -> list[tuple[Float32, Float32]]:
        """The triangle's three edges and the way to the point from where each begins, (3, n) in the world."""
        si = self.si
        a, b, c = self.scene.layer("position", "").corners(si.prim, si.instance)
        p = a + si.u * (b - a) + si.v * (c - a)
        pairs = ((b - a, p - a), (c - b, p - b), (a - c, p - c))
        return [(self.to_world_vector(edge), self.to_world_vector(toward)) for edge, toward in pairs]

    def bump_steps(self, width: float) -> tuple[Float32, Float32]:
        """Two small steps (3, n) along the faces, `width` of a pixel long, for Bump."""
        if self.displaced is not None:
            return rest_steps(self, self.displaced, width)
        if width not in self._steps:
            self._steps[width] = steps(self, width)
        return self._steps[width]

    def shifted(self, axis: int, width: float) -> Lanes:
        """The lanes one such step along; `axis` 1 or 2. Needs the "position" layer.

        4, 5 and 6 are the lanes before displacement, and one step along there.
        """
        if axis & REST:
            return at_rest(self, axis & 3, width)
        return moved(self, self.bump_steps(width)[axis - 1])

    def object_random(self) -> Float32:
        """(n,) Object Info's Random."""
        return self.scene.instances.random.take(self.si.instance)

    def object_color(self) -> Float32:
        """(4, n) Object Info's Color."""
        return np.ascontiguousarray(self.scene.instances.color.take(self.si.instance, axis=0).T)

    def object_index(self) -> Float32:
        """(n,) Object Info's Object Index."""
        return self.scene.instances.pass_index.take(self.si.instance).astype(np.float32)

    def object_location(self) -> Float32:
        """(3, n) Object Info's Location."""
        return self.scene.transforms.location(self.si.instance)

    def per_object(self, name: str) -> Float32:
        """(4, n) a row of `Instances.attributes`; 0 where the snapshot has none."""
        table = self.scene.instances.attributes.get(name)
        if table is None:
            return np.zeros((4, self.n), np.float32)
        return np.ascontiguousarray(table.take(self.si.instance, axis=0).T)
