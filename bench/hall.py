"""A hall with many lights, as a snapshot: 40 × 40 m with pillars, the same watts whatever the count."""

from __future__ import annotations

import numpy as np

from pt_engine.scene.snapshot import (
    CameraData,
    Graph,
    Instances,
    LightData,
    Link,
    MeshData,
    Node,
    Snapshot,
    Visibility,
)

SIDE, HEIGHT, POWER = 40.0, 4.0, 20_000.0
PILLARS = range(-15, 16, 6)
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def hall(kind: str, count: int) -> Snapshot:
    """`count` points, spheres or quads; a tenth of them give half of the light."""
    rng = np.random.default_rng(count)
    span = 0.48 * SIDE
    place = rng.uniform((-span, -span, 1.5), (span, span, 3.5), (count, 3))
    bright = np.arange(count) % 10 == 0
    watts = POWER * 0.5 * (bright / bright.sum() + ~bright / (~bright).sum())
    half = 0.04 * SIDE / np.sqrt(count)  # half the size of a lamp
    boxes = [box((-SIDE / 2, -SIDE / 2, 0), (SIDE / 2, SIDE / 2, HEIGHT))]
    boxes += [box((x - 0.4, y - 0.4, 0), (x + 0.4, y + 0.4, HEIGHT)) for x in PILLARS for y in PILLARS]
    walls = np.concatenate(boxes)
    meshes, materials = [mesh("hall", walls)], [graph("BsdfDiffuse", (0.7,) * 3, "BSDF", Roughness=0.0)]
    lamps: tuple[LightData, ...] = ()
    if kind == "quads":
        for part in (True, False):
            some = np.flatnonzero(bright == part)
            meshes.append(mesh(f"quads {part}", quads(place[some], half, rng)))
            radiance = float(watts[some[0]]) / (2 * np.pi * 4 * half**2)
            materials.append(graph("Emission", (1.0,) * 3, "Emission", Strength=radiance))
    else:
        radius = half if kind == "spheres" else 0.0
        lamps = tuple(lamp(p, float(w), radius) for p, w in zip(place, watts, strict=True))
    return Snapshot(
        tuple(meshes),
        placed(len(meshes)),
        tuple(materials),
        (),
        lamps,
        None,
        camera((-17, -18, 1.4), (-15, -14, -3)),
    )


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> np.ndarray:
    """(6, 4, 3) its faces."""
    corners = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    return (np.asarray(low) + corners * (np.asarray(high) - low))[FACES]


def quads(centre: np.ndarray, half: float, rng: np.random.Generator) -> np.ndarray:
    """(K, 4, 3) squares turned every way."""
    x, y = rng.normal(size=(2, len(centre), 3))
    x /= np.sqrt((x**2).sum(axis=1, keepdims=True))
    y = np.cross(x, y)
    y /= np.sqrt((y**2).sum(axis=1, keepdims=True))
    return np.stack(
        [centre + half * (a * x + b * y) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))], axis=1
    )


def mesh(name: str, faces: np.ndarray) -> MeshData:
    """A mesh of quads (K, 4, 3)."""
    first = 4 * np.arange(len(faces))[:, None]
    triangles = np.stack([first + (0, 1, 2), first + (0, 2, 3)], axis=1).reshape(-1, 3).astype(np.int32)
    return MeshData(
        name, faces.reshape(-1, 3).astype(np.float32), triangles, np.zeros(len(triangles), np.int32)
    )


def graph(kind: str, colour: tuple[float, float, float], output: str, **inputs: float) -> Graph:
    """A material of one node."""
    return Graph(
        kind, (Node(kind, kind, {"Color": (*colour, 1.0), **inputs}, {}),), {"Surface": Link(0, output)}
    )


def lamp(place: np.ndarray, watts: float, radius: float) -> LightData:
    """A point lamp."""
    matrix = np.eye(4)
    matrix[:3, 3] = place
    return LightData("POINT", "lamp", matrix, watts, radius=radius)


def placed(count: int) -> Instances:
    """Mesh k with material k, where it is."""
    number = np.arange(count, dtype=np.int32)
    return Instances(
        mesh=number,
        matrix=np.repeat(np.eye(4)[None], count, axis=0),
        materials=number[:, None],
        random=np.zeros(count, np.float32),
        color=np.ones((count, 4), np.float32),
        pass_index=np.zeros(count, np.int32),
        visibility=np.full(count, Visibility.ALL, np.uint8),
        names=tuple(f"mesh {k}" for k in number),
    )


def camera(eye: tuple[float, float, float], target: tuple[float, float, float]) -> CameraData:
    """A pinhole, 3:2."""
    z = np.subtract(eye, target)
    z = z / np.sqrt((z**2).sum())
    x = np.cross((0, 0, 1), z)
    x /= np.sqrt((x**2).sum())
    matrix = np.eye(4)
    matrix[:3] = np.stack([x, np.cross(z, x), z, eye], axis=1)
    return CameraData("PERSP", matrix, (-0.75, 0.75, -0.5, 0.5), clip=(1e-4, 1e6))
