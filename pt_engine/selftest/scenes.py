"""Small snapshots whose answers are known: meshes, materials and lamps by hand, without Blender."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..render import integrators  # noqa: F401  (fills the registry)
from ..render.progressive import RenderResult, render
from ..render.settings import RenderSettings
from ..scene.prepare import prepare
from ..scene.snapshot import (
    CameraData,
    CurvesData,
    Graph,
    Instances,
    LightData,
    Link,
    MeshData,
    Node,
    PointsData,
    Snapshot,
    Visibility,
)

Matrix = NDArray[np.float64]
WHITE = (1.0, 1.0, 1.0, 1.0)


def shader(kind: str, name: str = "material", props: dict[str, Any] | None = None, **inputs: Any) -> Graph:
    """A material of one shader node; underscores in input names stand for spaces."""
    node = Node(kind, kind, {k.replace("_", " "): v for k, v in inputs.items()}, props or {})
    return Graph(name, (node,), {"Surface": Link(0, output_of(kind))})


def output_of(kind: str) -> str:
    """The shader output's identifier of a node kind."""
    return {"Emission": "Emission", "Background": "Background"}.get(kind, "BSDF")


def diffuse(albedo: float | Sequence[float] = 0.8, name: str = "diffuse") -> Graph:
    """Lambertian reflection."""
    return shader("BsdfDiffuse", name, Color=rgba(albedo), Roughness=0.0)


def emission(radiance: float | Sequence[float], name: str = "emission") -> Graph:
    """A surface that only shines, on both sides."""
    return shader("Emission", name, Color=rgba(radiance), Strength=1.0)


def shining_diffuse(albedo: float | Sequence[float], radiance: float | Sequence[float]) -> Graph:
    """Lambertian reflection plus emission."""
    nodes = (
        Node("BsdfDiffuse", "diffuse", {"Color": rgba(albedo), "Roughness": 0.0}),
        Node("Emission", "emission", {"Color": rgba(radiance), "Strength": 1.0}),
        Node("AddShader", "add", {"Shader": Link(0, "BSDF"), "Shader_001": Link(1, "Emission")}),
    )
    return Graph("shining", nodes, {"Surface": Link(2, "Shader")})


def world(radiance: float | Sequence[float]) -> Graph:
    """The same radiance from all directions."""
    return shader("Background", "world", Color=rgba(radiance), Strength=1.0)


def rgba(value: float | Sequence[float]) -> tuple[float, float, float, float]:
    """A colour socket's value."""
    r, g, b = (value,) * 3 if isinstance(value, int | float) else value
    return (float(r), float(g), float(b), 1.0)


def mesh(vertices: Any, triangles: Any, normals: Any = None, name: str = "mesh") -> MeshData:
    """A mesh; `normals` (V, 3) makes it smooth."""
    t = np.asarray(triangles, np.int32).reshape(-1, 3)
    n = None if normals is None else np.asarray(normals, np.float32)
    return MeshData(
        name,
        np.asarray(vertices, np.float32).reshape(-1, 3),
        t,
        np.zeros(len(t), np.int32),
        normals=n,
        normal_index=None if n is None else t,
    )


def quad(size: float = 1.0) -> MeshData:
    """A square of edge `size` in the XY plane, normal +Z."""
    h = size / 2
    return mesh([(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)], [(0, 1, 2), (0, 2, 3)], name="quad")


def box(size: float = 2.0, inward: bool = False) -> MeshData:
    """A closed cube of edge `size` around the origin."""
    h = size / 2
    v = [(x, y, z) for z in (-h, h) for y in (-h, h) for x in (-h, h)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    t = [tri for a, b, c, d in faces for tri in ((a, b, c), (a, c, d))]
    return mesh(v, [tri[::-1] for tri in t] if inward else t, name="box")


def sphere(radius: float = 1.0, rings: int = 64, smooth: bool = True) -> MeshData:
    """A latitude-longitude sphere, vertices on the sphere, normals outward."""
    theta = np.linspace(0, np.pi, rings + 1)[:, None]
    phi = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)[None, :]
    p = np.stack(
        np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1
    )
    m = 2 * rings
    i, j = (a.ravel() for a in np.meshgrid(np.arange(rings), np.arange(m), indexing="ij"))
    a, b, c, d = i * m + j, (i + 1) * m + j, (i + 1) * m + (j + 1) % m, i * m + (j + 1) % m
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    unit = p.reshape(-1, 3)
    corner = unit[triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return mesh(unit * radius, triangles[area > 1e-12], unit if smooth else None, name="sphere")


def translation(x: float, y: float, z: float) -> Matrix:
    """A 4×4 matrix."""
    m = np.eye(4)
    m[:3, 3] = x, y, z
    return m


def looking(eye: Sequence[float], target: Sequence[float], up: Sequence[float] = (0, 0, 1)) -> Matrix:
    """Camera (or lamp) to world: −Z toward the target."""
    position = np.asarray(eye, np.float64)
    z = position - np.asarray(target, np.float64)
    z /= np.linalg.norm(z)
    x = np.cross(np.asarray(up, float), z)
    x = np.cross((0, 1, 0), z) if np.linalg.norm(x) < 1e-9 else x
    x /= np.linalg.norm(x)
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = x, np.cross(z, x), z, position
    return m


def perspective(
    eye: Sequence[float], target: Sequence[float], tangent: float = 0.5, aspect: float = 1.0, **more: Any
) -> CameraData:
    """A pinhole; `tangent` is that of half the vertical angle of view."""
    t = tangent
    return CameraData(
        "PERSP", looking(eye, target), (-t * aspect, t * aspect, -t, t), clip=(1e-4, 1e6), **more
    )


def orthographic(eye: Sequence[float], target: Sequence[float], size: float) -> CameraData:
    """A square parallel projection of edge `size`."""
    h = size / 2
    return CameraData("ORTHO", looking(eye, target), (-h, h, -h, h), clip=(1e-4, 1e6))


def scene(
    objects: Sequence[tuple[MeshData, Matrix, Graph]],
    camera: CameraData,
    lights: Sequence[LightData] = (),
    sky: Graph | None = None,
) -> Snapshot:
    """A snapshot of placed meshes, each with one material."""
    materials = [diffuse(0.8, "default")]
    rows = []
    for _, _, graph in objects:
        if graph not in materials:
            materials.append(graph)
        rows.append([materials.index(graph)])
    n = len(objects)
    instances = Instances(
        mesh=np.arange(n, dtype=np.int32),
        matrix=np.array([m for _, m, _ in objects], np.float64).reshape(n, 4, 4),
        materials=np.array(rows, np.int32).reshape(n, 1),
        random=np.zeros(n, np.float32),
        color=np.ones((n, 4), np.float32),
        pass_index=np.zeros(n, np.int32),
        visibility=np.full(n, Visibility.ALL, np.uint8),
        names=tuple(f"object {k}" for k in range(n)),
    )
    return Snapshot(
        tuple(m for m, _, _ in objects), instances, tuple(materials), (), tuple(lights), sky, camera
    )


def among(
    base: Snapshot,
    curves: Sequence[CurvesData] = (),
    points: Sequence[PointsData] = (),
    matrices: Sequence[Matrix] | None = None,
) -> Snapshot:
    """Curves and points of the first object's material, ahead of all that a scene has."""
    rows, count, others = base.instances, len(curves) + len(points), len(base.meshes)
    own = np.stack([np.eye(4)] * count) if matrices is None else np.asarray(matrices, np.float64)
    every = count + len(rows.mesh)
    instances = Instances(
        mesh=np.concatenate([np.arange(others, others + count, dtype=np.int32), rows.mesh]),
        matrix=np.concatenate([own, rows.matrix]),
        materials=np.concatenate([np.repeat(rows.materials[:1], count, axis=0), rows.materials]),
        random=np.zeros(every, np.float32),
        color=np.ones((every, 4), np.float32),
        pass_index=np.zeros(every, np.int32),
        visibility=np.concatenate([np.full(count, 63, np.uint8), rows.visibility]),
        names=(*(f"round {k}" for k in range(count)), *rows.names),
    )
    return replace(base, instances=instances, curves=tuple(curves), points=tuple(points))


def rendered(snapshot: Snapshot, size: int | tuple[int, int] = 16, **settings: Any) -> RenderResult:
    """Render it; box filter and the independent sampler unless told otherwise."""
    width, height = (size, size) if isinstance(size, int) else size
    defaults: dict[str, Any] = {
        "pixel_filter": "BOX",
        "filter_width": 1.0,
        "sampler": "independent",
        "threads": 1,
    }
    chosen = RenderSettings(width, height, **{**defaults, **settings})
    return render(prepare(snapshot, chosen.film_transparent), chosen)
