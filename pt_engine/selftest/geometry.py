"""Geometry that is broken, degenerate or extreme: rendered as if the broken part were not there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..render.progressive import render
from ..render.settings import RenderSettings
from ..scene.prepare import prepare
from ..scene.snapshot import Graph, Link, MeshData, Node
from . import scenes as make
from .case import Group
from .scenes import Matrix

Float32 = NDArray[np.float32]

GEOMETRY = Group("Geometry")
UP = np.eye(4)
FLOOR = make.quad(9.0)
NORMALS = np.zeros((4, 3), np.float32)
CAMERA = make.orthographic((0.03, 0.02, 3), (0.03, 0.02, 0), 0.9)
FURNACE = 0.7  # albedo of what stands in a white sky: its radiance
NONE = float("nan")
NESTED = 70 << 20  # bytes: for four balls of 101,760 triangles, and thirteen only if nine share


def radiance(
    *meshes: MeshData,
    matrix: Matrix = UP,
    material: Graph | None = None,
    depth: int = 2,
    lifted: float = 0.0,
    **settings: Any,
) -> float:
    """Mean radiance of meshes seen from above under a white sky; NaN if a sample was dropped.

    `lifted` is the cosine below which shadow rays start above the triangles.
    """
    graph = make.diffuse(FURNACE) if material is None else material
    objects = [(mesh, matrix, graph) for mesh in meshes]
    how = {"samples": 64, "sampler": "sobol", "integrator": "path_active", "max_depth": depth, **settings}
    snapshot = make.scene(objects, CAMERA, sky=make.world(1.0))
    cutoff = np.full(len(objects), lifted, np.float32)
    snapshot = replace(snapshot, instances=replace(snapshot.instances, terminator=cutoff))
    result = make.rendered(snapshot, 8, **how)
    return NONE if result.progress.nonfinite_count else float(result.image()[..., :3].mean())


def smooth(normals: object, mesh: MeshData = FLOOR) -> MeshData:
    """The floor with custom normals."""
    table = np.broadcast_to(np.asarray(normals, np.float32), mesh.vertices.shape).copy()
    return replace(mesh, normals=table, normal_index=mesh.triangles)


def worst(values: list[float], expected: float) -> float:
    """The value farthest from `expected`; NaN wins."""
    return max(values, key=lambda value: abs(value - expected) if value == value else float("inf"))


NOISE = "noise of 64 Sobol samples in 64 pixels"


@GEOMETRY.case(
    "triangles without area beside good ones",
    "their normal is 0/0, and Embree may still report a hit on an edge",
    "radiance of an albedo 0.7 in a white sky",
    FURNACE,
    5e-3,
    NOISE,
)
def zero_area() -> float:
    point, edge = (0, 1, 1), (0, 0, 2)
    triangles = np.concatenate([FLOOR.triangles, np.array([point, edge, (0, 2, 0)], np.int32)])
    return radiance(replace(FLOOR, triangles=triangles, material_slot=np.zeros(len(triangles), np.int32)))


@GEOMETRY.case(
    "nothing but triangles without area",
    "bounds, power and choice of emitters are all 0",
    "radiance of the sky behind",
    1.0,
    0.0,
    "nothing is there to be hit",
)
def only_zero_area() -> float:
    line = make.mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 0, 0)], [(0, 1, 2), (0, 3, 3)])
    return worst([radiance(line), radiance(line, material=make.emission(1.0))], 1.0)


@GEOMETRY.case(
    "duplicate and coincident faces",
    "which of two is hit is chance; the next ray starts on both",
    "radiance of an albedo 0.7, the face there once, twice, and turned around",
    FURNACE,
    5e-3,
    NOISE,
)
def coincident() -> float:
    turned = replace(FLOOR, triangles=FLOOR.triangles[:, ::-1].copy())
    return worst([radiance(FLOOR, FLOOR), radiance(FLOOR, turned), radiance(FLOOR, FLOOR, turned)], FURNACE)


@GEOMETRY.case(
    "coplanar materials overlap",
    "two albedos in one plane: any mixture is right, darkness and light from nowhere are not",
    "distance of the radiance from the interval of both albedos",
    0.0,
    5e-3,
    NOISE,
)
def coplanar() -> float:
    turned = np.diag([1.0, 1.0, 1.0, 1.0])
    turned[:2, :2] = [[0.6, -0.8], [0.8, 0.6]]
    objects = [(FLOOR, UP, make.diffuse(0.2, "dark")), (FLOOR, turned, make.diffuse(0.6, "light"))]
    result = make.rendered(make.scene(objects, CAMERA, sky=make.world(1.0)), 8, samples=64, max_depth=2)
    mean = float(result.image()[..., :3].mean())
    return max(0.2 - mean, mean - 0.6, 0.0)


@GEOMETRY.case(
    "inside out, mirrored, three faces on an edge",
    "a normal on the wrong side, or two of them, must not darken what scatters on both sides",
    "radiance of an albedo 0.7",
    FURNACE,
    5e-3,
    NOISE,
)
def inside_out() -> float:
    turned = replace(FLOOR, triangles=FLOOR.triangles[:, ::-1].copy())
    fin = np.concatenate([FLOOR.triangles, np.array([(0, 2, 4)], np.int32)])
    under = make.mesh(np.concatenate([FLOOR.vertices, [(0, 0, -1)]]), fin)
    values = [radiance(turned), radiance(FLOOR, matrix=np.diag([-1.0, 1, 1, 1])), radiance(under)]
    return worst(values, FURNACE)


@GEOMETRY.case(
    "NaN, infinite and huge vertices",
    "one of them in Embree's tree spoils every ray",
    "radiance of the floor beside the broken mesh",
    FURNACE,
    5e-3,
    NOISE,
)
def broken_vertices() -> float:
    values = []
    for bad in (np.nan, np.inf, -np.inf, 3e38):
        vertices = FLOOR.vertices.copy()
        vertices[0] = bad
        values.append(radiance(FLOOR, replace(FLOOR, vertices=vertices)))
    return worst(values, FURNACE)


@GEOMETRY.case(
    "zero, singular, NaN and infinite matrices",
    "the inverse that takes normals and points to object space does not exist",
    "radiance of a white sky around balls that have collapsed",
    1.0,
    0.0,
    "nothing is left to be hit",
)
def matrices() -> float:
    ball = make.sphere(1.0, 8)
    singular = [np.zeros((4, 4)), np.full((4, 4), np.nan), np.full((4, 4), np.inf), np.diag([0.0, 0, 1, 1])]
    singular.append(np.array([[0.0, 1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]))
    return worst([radiance(ball, matrix=m) for m in singular], 1.0)


@GEOMETRY.case(
    "a ball flattened to a disc",
    "its matrix has no inverse, but its normals have a direction: that of the axis",
    "radiance of an albedo 0.7",
    FURNACE,
    2e-2,
    "noise, and its smooth normals where the back of the ball shows through",
)
def flattened() -> float:
    return radiance(make.sphere(3.0, 16), matrix=np.diag([1.0, 1, 0, 1]))


@GEOMETRY.case(
    "empty meshes",
    "no vertex, no triangle, or vertices without triangles",
    "radiance of the floor among them",
    FURNACE,
    5e-3,
    NOISE,
)
def empty() -> float:
    return radiance(make.mesh(np.zeros((0, 3)), []), FLOOR, make.mesh(np.ones((3, 3)), []))


@GEOMETRY.case(
    "custom normals of no length, NaN, infinite, tiny and huge",
    "normalised they are 0/0, ∞/∞, or under- and overflow: then the face's own has to do",
    "radiance of an albedo 0.7",
    FURNACE,
    5e-3,
    NOISE,
    naive=lambda: plain_normalised((0.0, 0.0, 1e-30)),
)
def broken_normals() -> float:
    z = [0.0, np.nan, np.inf, 1e-30, 1e30]
    return worst([radiance(smooth((0, 0, value))) for value in z], FURNACE)


def plain_normalised(normal: tuple[float, float, float]) -> float:
    """n / √(n·n) in float32, whose squares under- and overflow."""
    n = np.array(normal, np.float32)
    return FURNACE * float((n / np.sqrt((n * n).sum()))[2])


@GEOMETRY.case(
    "normals that turn away from the viewer",
    "at a terminator the shading normal looks below the surface, and shadow rays may start above it",
    "excess of the radiance over that of a white floor",
    0.0,
    0.0,
    "energy may be lost there, never gained",
)
def terminator() -> float:
    tilted = [(np.sin(a), 0, np.cos(a)) for a in (1.2, 1.5, 1.57, 1.6, 2.0, np.pi)]
    white = make.diffuse(1.0)
    glossy = make.shader("BsdfGlossy", "gloss", Color=make.WHITE, Roughness=0.2)
    values = [
        radiance(smooth(n), material=m, lifted=c) for n in tilted for m in (white, glossy) for c in (0.0, 0.3)
    ]
    return NONE if np.isnan(values).any() else max(0.0, max(values) - 1.002)


@GEOMETRY.case(
    "missing and degenerate UV maps",
    "a tangent along u that has no direction: the frame falls back on the normal alone",
    "radiance of anisotropic metal in a white sky over that with a good map",
    1.0,
    0.02,
    "seen from above the tangent only turns the lobe; noise",
)
def uv() -> float:
    inputs: dict[str, Any] = {"Color": make.WHITE, "Roughness": 0.5, "Anisotropy": 0.9, "Rotation": 0.0}
    nodes = (
        Node("Tangent", "along", {}, {"direction_type": "UV_MAP", "uv_map": "UVMap", "axis": "Z"}),
        Node("BsdfAnisotropic", "metal", {**inputs, "Tangent": Link(0, "Tangent")}),
    )
    metal = Graph("metal", nodes, {"Surface": Link(1, "BSDF")})
    good, point = (mapped(FLOOR.vertices[FLOOR.triangles.ravel(), :2] * scale) for scale in (1, 0))
    expected = radiance(good, material=metal)
    return worst([radiance(mesh, material=metal) / expected for mesh in (FLOOR, point)], 1.0)


def mapped(uv: Float32) -> MeshData:
    """The floor with a uv map (6, 2)."""
    corners = np.arange(6, dtype=np.int32).reshape(2, 3)
    return replace(FLOOR, corner_index=corners, uvs={"UVMap": uv.astype(np.float32)}, active_uv="UVMap")


@GEOMETRY.case(
    "one triangle",
    "the smallest tree",
    "radiance of an albedo 0.7",
    FURNACE,
    5e-3,
    NOISE,
)
def one_triangle() -> float:
    return radiance(make.mesh([(-9, -9, 0), (9, -9, 0), (0, 18, 0)], [(0, 1, 2)]))


@GEOMETRY.case(
    "instances that are not placed, beside broken ones",
    "rays are taken through each one's inverse, which a tiny one has in 1e6 and a broken one has not",
    "radiance of an albedo 0.7, of a ball among others of the same mesh",
    FURNACE,
    5e-3,
    NOISE,
)
def nested() -> float:
    ball = make.sphere(0.7, 160)  # a hundred thousand triangles; half a million are worth sharing
    places = [make.translation(x, 900.0, -900.0) for x in range(-600, 600, 200)]
    broken = [np.zeros((4, 4)), np.diag([1.0, 0, 0, 1]), *(np.full((4, 4), bad) for bad in (np.nan, np.inf))]
    tiny, mirrored = (places[0] @ np.diag([a, b, b, 1.0]) for a, b in ((1e-5, 1e-5), (-1.0, 1.0)))
    every = [UP, tiny, mirrored, *places, *broken]
    snapshot = make.scene([(ball, m, make.diffuse(FURNACE)) for m in every], CAMERA, sky=make.world(1.0))
    alike = np.zeros(len(every), np.int32)
    snapshot = replace(snapshot, meshes=(ball,), instances=replace(snapshot.instances, mesh=alike))
    how = RenderSettings(8, 8, samples=64, max_depth=2, threads=1, pixel_filter="BOX", filter_width=1.0)
    result = render(prepare(snapshot, memory=NESTED), how)
    return NONE if result.progress.nonfinite_count else float(result.image()[..., :3].mean())


@GEOMETRY.case(
    "five million triangles",
    "indices, gathers and Embree's tree beyond 2^22",
    "radiance of an albedo 0.7",
    FURNACE,
    5e-3,
    NOISE,
    quick=False,
)
def millions() -> float:
    n = 1600
    line = np.linspace(-4.5, 4.5, n, dtype=np.float32)
    x, y = np.meshgrid(line, line)
    a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    quads = np.stack([a, a + 1, a + n + 1, a, a + n + 1, a + n], axis=1)
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(n * n, np.float32)], axis=1)
    return radiance(make.mesh(vertices, quads.reshape(-1, 3)))
