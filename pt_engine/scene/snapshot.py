"""The snapshot: everything a render needs, as plain arrays.

It is the seam of the house. Left of it only `blender/` knows bpy; right of it nothing does. It serves
worker processes, bug reports and tests without Blender. All lengths are Blender units (metres), world
space is Blender's (right-handed, +Z up), colours are scene-linear Rec.709 unless a name says otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .linking import UNLIMITED as UNLIMITED
from .linking import Linking as Linking
from .linking import Visibility as Visibility
from .snapshot_camera import CameraData as CameraData
from .snapshot_camera import InstanceMotion as InstanceMotion
from .snapshot_camera import MeshMotion as MeshMotion
from .snapshot_camera import Motion as Motion
from .snapshot_camera import RoundMotion as RoundMotion
from .snapshot_camera import Stereo as Stereo

Float32: TypeAlias = NDArray[np.float32]
Float64: TypeAlias = NDArray[np.float64]
Int32: TypeAlias = NDArray[np.int32]

PixelArray: TypeAlias = NDArray[np.float32] | NDArray[np.uint8]

Value: TypeAlias = "float | tuple[float, ...] | str | bool | int | None"


class Link(NamedTuple):
    """An input fed by output `socket` of node number `node` of the same graph."""

    node: int
    socket: str


@dataclass(frozen=True)
class Node:
    """One shader node; groups, reroutes and mutes are already resolved.

    Attributes
    ----------
    kind : str
        Blender's bl_idname without the prefix ``ShaderNode``: ``BsdfPrincipled``, ``TexImage`` ...
    name : str
        Where it is, for messages: ``Group/Noise Texture``.
    inputs : dict[str, Value | Link]
        By socket identifier; unlinked sockets hold their value (a tuple for colours and vectors,
        None where the socket hides its value and the node has a default of its own).
    props : dict
        The node's own settings (enums as str, numbers, tuples; curves and ramps as nested tuples;
        ``image`` as an index into `Snapshot.images`; see `blender/export/node_props.py`).
    """

    kind: str
    name: str
    inputs: dict[str, Value | Link] = field(default_factory=dict)
    props: dict[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class Graph:
    """A shader graph, flat: each node comes after what feeds it.

    `outputs` maps ``Surface``, ``Volume``, ``Displacement`` to what feeds it (only where something does);
    `displacement_method` is BUMP, DISPLACEMENT or BOTH; `pass_index` is the material's.
    """

    name: str
    nodes: tuple[Node, ...] = ()
    outputs: dict[str, Link] = field(default_factory=dict)
    notes: tuple[tuple[str, str], ...] = ()  # (node name, what the exporter had to leave out)
    displacement_method: str = "BUMP"
    pass_index: int = 0
    sampled: bool = True  # whether what emits is sampled as a light; else only rays find it


@dataclass(frozen=True)
class ImageData:
    """An image texture: an encoded file (`encoded`), decoded pixels, bottom row first, or UDIM tiles.

    `pixels` is (height, width, 4), float32 or uint8; `encoded` the file's bytes as uint8 with `suffix` naming
    the format; `tiles` pairs of a tile's number (1001 ...) and the index of its image in `Snapshot.images`.
    Exactly one of them is set, or none where the file is missing (`problem` says why).
    """

    name: str
    colorspace: str = "sRGB"
    alpha_mode: str = "STRAIGHT"  # STRAIGHT, PREMUL, CHANNEL_PACKED, NONE
    encoded: NDArray[np.uint8] | None = None
    suffix: str = ""
    pixels: PixelArray | None = None
    problem: str = ""
    tiles: tuple[tuple[int, int], ...] = ()
    as_rgba: bool = False  # a packed file: Blender makes RGBA of grey before alpha is associated


@dataclass(frozen=True)
class MeshData:
    """One evaluated mesh in object space.

    Attributes
    ----------
    vertices : (V, 3) float32
    triangles : (T, 3) int32
    material_slot : (T,) int32
    normals : (K, 3) float32 or None
        Unit shading normals; None where every face is flat.
    normal_index : (T, 3) int32 or None
        Row of `normals` at each corner; may be `triangles` itself where normals are per vertex.
    flat : (T,) uint8 or None
        1 on faces without smooth shading, where the normals are per corner and a material moves vertices
        or looks at uv maps.
    corner_index : (T, 3) int32 or None
        Row of the corner-domain layers (`uvs`, corner `colors`) at each corner.
    uvs : dict[str, (L, 2) float32]
    colors : dict[str, (L, 4) or (V, 4) float32]
        Linear; indexed by `corner_index` where the layer is long enough for it, as in all that Blender's
        export makes, else by `triangles`. Other attributes that a graph names are here too: a number x as
        (x, x, x, 1), a vector as (x, y, z, 1).
    active_uv, active_color : str
        Names of the layers a node means when it names none ("" if there is none).
    texture_space : (2, 3) float32
        Location and half-size of the box that Generated coordinates map to [0, 1].
    orco : (V, 3) float32 or None
        Undeformed positions for Generated where they differ from `vertices`.
    """

    name: str
    vertices: Float32
    triangles: Int32
    material_slot: Int32
    normals: Float32 | None = None
    normal_index: Int32 | None = None
    flat: NDArray[np.uint8] | None = None
    corner_index: Int32 | None = None
    uvs: dict[str, Float32] = field(default_factory=dict)
    colors: dict[str, Float32] = field(default_factory=dict)
    active_uv: str = ""
    active_color: str = ""
    texture_space: Float32 = field(default_factory=lambda: np.array([[0, 0, 0], [1, 1, 1]], np.float32))
    orco: Float32 | None = None


@dataclass(frozen=True)
class CurvesData:
    """Hair: strands through points, in object space.

    Attributes
    ----------
    points : (P, 3) float32
        Of all curves, one after the other.
    radius : (P,) float32
    first : (C + 1,) int32
        Where each curve's points begin, and the number of points.
    material_slot : (C,) int32
    shape : str
        RIBBON (flat, turned to each ray, shaded as if round), THICK (round, open at its ends), both along
        Catmull-Rom splines; LINEAR (straight cones that spheres join).
    subdivisions : int
        A ribbon's segment has one straight piece more than that, where it is bent.
    uvs : dict[str, (C, 2) float32]
    colors : dict[str, (P, 4) or (C, 4) float32]
        As in `MeshData`, by point or by curve.
    active_uv, active_color : str
    generated : (C, 3) float32 or None
        Generated coordinates; None for those of the object.
    normals : (P, 3) float32 or None
        Along the longer axis of flat hair; None where nothing asks for them, or nobody knows.
    """

    name: str
    points: Float32
    radius: Float32
    first: Int32
    material_slot: Int32
    shape: str = "RIBBON"
    subdivisions: int = 2
    uvs: dict[str, Float32] = field(default_factory=dict)
    colors: dict[str, Float32] = field(default_factory=dict)
    active_uv: str = ""
    active_color: str = ""
    generated: Float32 | None = None
    normals: Float32 | None = None


@dataclass(frozen=True)
class PointsData:
    """A point cloud: spheres, in object space.

    Attributes
    ----------
    points : (P, 3) float32
    radius : (P,) float32
    uvs : dict[str, (P, 2) float32]
    colors : dict[str, (P, 4) float32]
        As in `MeshData`.
    """

    name: str
    points: Float32
    radius: Float32
    uvs: dict[str, Float32] = field(default_factory=dict)
    colors: dict[str, Float32] = field(default_factory=dict)


@dataclass(frozen=True)
class Instances:
    """All placed meshes, one row each (struct of arrays: a scene may have 10,000 of them).

    Attributes
    ----------
    mesh : (I,) int32
        Index into `Snapshot.meshes`; beyond them into `Snapshot.curves`, then into `Snapshot.points`.
    matrix : (I, 4, 4) float64
        Object to world.
    materials : (I, S) int32
        Material of each slot (index into `Snapshot.materials`), padded with the last; slot numbers
        past the end use the last, as Blender does.
    random : (I,) float32
        Object Info's Random.
    color : (I, 4) float32
        Object colour.
    pass_index : (I,) int32
    visibility : (I,) uint8
        Bits of `Visibility`: which rays see it.
    names : tuple[str, ...]
        The object's name, for messages.
    attributes : dict[str, (I, 4) float32]
        What graphs ask of single objects: ``object:NAME`` and ``instancer:NAME`` are properties (RGBA),
        ``instancer generated``, ``instancer uv`` where on its instancer an object stands; ``particle``,
        ``particle location`` ... are the particle that it was made from.
    terminator : (I,) float32 or None
        Cosine up to which shadow rays of smooth meshes start above their triangles (`terminator`); 0 where
        they never do, None for all where they also end at the triangles' horizon.
    shading_offset : (I,) float32 or None
        How much sooner light on it fades toward grazing angles (`terminator_shading`), from 0 to 1.
    light_group : (I,) int32 or None
        Number of its light group, from 1 on; 0, or None for all, in none.
    """

    mesh: Int32
    matrix: Float64
    materials: Int32
    random: Float32
    color: Float32
    pass_index: Int32
    visibility: NDArray[np.uint8]
    names: tuple[str, ...]
    attributes: dict[str, Float32] = field(default_factory=dict)
    terminator: Float32 | None = None
    shading_offset: Float32 | None = None
    light_group: Int32 | None = None


@dataclass(frozen=True)
class LightData:
    """A lamp, in Blender's units and conventions.

    Attributes
    ----------
    kind : str
        POINT, SPOT, SUN or AREA.
    matrix : (4, 4) float64
        To world; the lamp shines along its local -Z.
    power : float
        Watts (sun: irradiance, W·m⁻²), exposure already multiplied in, as in the panel.
    color : tuple of 3
        Linear, temperature already multiplied in.
    radius : float
        Point and spot.
    soft_falloff : bool
    spot_size, spot_blend : float
        Full cone angle in radians; blend in [0, 1].
    angle : float
        Sun's angular diameter in radians.
    shape : str
        SQUARE, RECTANGLE, DISK, ELLIPSE.
    size : tuple of 2
        Full edge lengths or diameters, before the matrix's scale.
    spread : float
        Radians, pi for none.
    normalize : bool
        Whether `power` is total power (True) or radiance-like strength.
    max_bounces : int
        It lights no surface that more bounces lead to.
    group : int
        Its set of emitters in `Linking`.
    real : bool
        Whether it also shines where shadow catchers are alone.
    light_group : int
        As in `Instances`.
    graph : Graph or None
        Its node tree, where it has one.
    object_color, pass_index, random
        What that learns as Object Info; an instance has its instancer's colour.
    """

    kind: str
    name: str
    matrix: Float64
    power: float
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    radius: float = 0.0
    soft_falloff: bool = False
    spot_size: float = 0.785398
    spot_blend: float = 0.15
    angle: float = 0.0
    shape: str = "SQUARE"
    size: tuple[float, float] = (1.0, 1.0)
    spread: float = float(np.pi)
    normalize: bool = True
    cast_shadow: bool = True
    use_mis: bool = True
    visibility: int = Visibility.ALL & ~Visibility.CAMERA
    max_bounces: int = UNLIMITED
    group: int = 0
    real: bool = True
    light_group: int = 0
    graph: Graph | None = None
    object_color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    pass_index: int = 0
    random: float = 0.0


@dataclass(frozen=True)
class Snapshot:
    """A whole frame of a scene.

    `unsupported` lists what the exporter met and cannot give to the engine: (where, what, effect).
    `materials[0]` is always the stand-in for an empty slot (Blender's default grey diffuse 0.8).
    `world_visibility` says which rays see the world, as `Visibility` bits.
    `clear_glass` is the roughness up to which a transparent film shows through glass, below 0 for none.
    `ocio_config` names the OpenColorIO config of the file's Blender, "" for OpenImageIO's own.
    `motion` is None where nothing moves, or nothing is to be blurred.
    `light_groups` names groups 1, 2, …, whose light is kept apart; `world_light_group` is the world's.
    """

    meshes: tuple[MeshData, ...]
    instances: Instances
    materials: tuple[Graph, ...]
    images: tuple[ImageData, ...]
    lights: tuple[LightData, ...]
    world: Graph | None
    camera: CameraData
    frame: int = 1
    exposure: float = 1.0
    unsupported: tuple[tuple[str, str, str], ...] = ()
    ocio_config: str = ""
    curves: tuple[CurvesData, ...] = ()
    points: tuple[PointsData, ...] = ()
    world_visibility: int = Visibility.ALL
    linking: Linking | None = None
    clear_glass: float = -1.0
    motion: Motion | None = None
    light_groups: tuple[str, ...] = ()
    world_light_group: int = 0
