"""The geometry of the bench's scenes, as plain arrays: (V, 3) vertices and (T, 3) triangles.

S1  Mitsuba's Cornell box (`mitsuba.cornell_box()`): 36 diffuse triangles and a shade behind the lamp
S2  rough metal plates and a sphere under four sphere lights, after Veach's MIS scene
S4  half a million flat diffuse triangles under a sunny sky
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

Vector = tuple[float, float, float]

WHITE = (0.885809, 0.698859, 0.666422)
GREEN = (0.105421, 0.37798, 0.076425)
RED = (0.570068, 0.0430135, 0.0443706)
BLACK = (0.0, 0.0, 0.0)
LAMP = (18.387, 13.9873, 6.75357)


class Part(NamedTuple):
    """Triangles of one material.

    `roughness` None is diffuse, else a GGX mirror of that `colour` with alpha = roughness²; `emission`
    adds light.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    colour: Vector
    roughness: float | None = None
    emission: Vector | None = None


class Ball(NamedTuple):
    """A sphere that shines with `power` watts."""

    centre: Vector
    radius: float
    power: float


class View(NamedTuple):
    """A camera at `eye`: `fov` in radians across the width."""

    eye: Vector
    target: Vector
    up: Vector
    fov: float


class Model(NamedTuple):
    """A whole scene; `sky` is (height, width, 3) radiance, top row first, or None."""

    parts: Sequence[Part]
    balls: Sequence[Ball]
    view: View
    sky: np.ndarray | None = None


def quads(*corners: Sequence[Vector]) -> tuple[np.ndarray, np.ndarray]:
    """Quadrilaterals, counter-clockwise seen from where their normal points."""
    vertices = np.array(corners, np.float64).reshape(-1, 3)
    first = np.arange(0, len(vertices), 4)[:, None]
    return vertices, np.concatenate([first + [0, 1, 2], first + [0, 2, 3]]).astype(np.int32)


def box(centre: Vector, x: Vector, y: Vector, z: Vector) -> tuple[np.ndarray, np.ndarray]:
    """A box by its centre and its three half edges (a right-handed set)."""
    axes = np.array([x, y, z])
    v = [np.array(centre) + np.array([i, j, k]) @ axes for k in (-1, 1) for j in (-1, 1) for i in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return np.array(v), np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))], np.int32)


def merged(*pieces: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Several meshes as one."""
    first = np.cumsum([0, *(len(v) for v, _ in pieces[:-1])])
    return np.concatenate([v for v, _ in pieces]), np.concatenate(
        [t + k for (_, t), k in zip(pieces, first, strict=True)]
    )


def sphere(centre: Vector, radius: float, rings: int) -> tuple[np.ndarray, np.ndarray]:
    """A latitude-longitude sphere of about 4·rings² triangles."""
    theta, phi = np.meshgrid(
        np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1)[:-1], indexing="ij"
    )
    unit = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    m = 2 * rings
    i, j = (a.ravel() for a in np.meshgrid(np.arange(rings), np.arange(m), indexing="ij"))
    a, b, c, d = i * m + j, (i + 1) * m + j, (i + 1) * m + (j + 1) % m, i * m + (j + 1) % m
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    points = unit.reshape(-1, 3) * radius + np.array(centre)
    corner = points[triangles]
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return points, triangles[area > 1e-9 * radius**2].astype(np.int32)


def cornell() -> Model:
    """S1, with +Y up as in Mitsuba."""
    white = merged(
        quads(
            [(-1, -1, 1), (1, -1, 1), (1, -1, -1), (-1, -1, -1)],  # floor
            [(-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)],  # ceiling
            [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)],  # back
        ),
        box((0.335, -0.7, 0.38), (0.286891, 0, 0.087712), (0, 0.3, 0), (-0.087712, 0, 0.286891)),
        box((-0.33, -0.4, -0.28), (0.28491, 0, -0.093949), (0, 0.61, 0), (0.093949, 0, 0.28491)),
    )
    x, y, z0, z1 = 0.23, 0.99, -0.18, 0.20
    lamp = quads([(-x, y, z0), (x, y, z0), (x, y, z1), (-x, y, z1)])
    shade = quads([(-x, y + 1e-3, z1), (x, y + 1e-3, z1), (x, y + 1e-3, z0), (-x, y + 1e-3, z0)])
    parts = [
        Part(*white, WHITE),
        Part(*quads([(1, -1, -1), (1, -1, 1), (1, 1, 1), (1, 1, -1)]), GREEN),
        Part(*quads([(-1, -1, 1), (-1, -1, -1), (-1, 1, -1), (-1, 1, 1)]), RED),
        Part(*lamp, WHITE, emission=LAMP),
        Part(*shade, BLACK),  # Blender's emission is two-sided, Mitsuba's is not
    ]
    view = View((0, 0, 3.9), (0, 0, 0), (0, 1, 0), np.radians(39.3077))
    return Model(parts, (), view)


def plates() -> Model:
    """S2, with +Z up."""
    floor = quads([(-12, -6, 0), (12, -6, 0), (12, 8, 0), (-12, 8, 0)])
    parts = [Part(*floor, (0.5, 0.5, 0.5))]
    for k, roughness in enumerate((0.1, 0.22, 0.32, 0.5)):
        tilt = np.radians(58 - 14 * k)
        c, s = np.cos(tilt), np.sin(tilt)
        place = (0.0, 4.5 - 2.6 * k, 3.6 - 1.0 * k)
        plate = box(place, (4, 0, 0), (0, 0.9 * c, 0.9 * s), (0, -0.06 * s, 0.06 * c))
        parts.append(Part(*plate, (0.9, 0.85, 0.75), roughness))
    parts.append(Part(*sphere((6.5, 2.0, 1.5), 1.5, 50), (0.8, 0.6, 0.3), 0.3))
    balls = [Ball((-3.75 + 2.5 * k, 4.0, 7.5), r, 200.0) for k, r in enumerate((0.05, 0.2, 0.5, 0.9))]
    return Model(parts, balls, View((0, -15, 6.5), (0, 1, 2.2), (0, 0, 1), 0.7))


def hills(n: int = 501) -> Model:
    """S4, with +Z up: 2 · (n − 1)² triangles; 500,000 by default."""
    x, y = np.meshgrid(np.linspace(-10, 10, n), np.linspace(-10, 10, n))
    z = sum(
        np.sin(x * f + p) * np.cos(y * f * 1.13 + 2 * p) / f
        for f, p in ((0.5, 0.3), (1.1, 1.0), (2.3, 2.2), (4.9, 4.0), (11.0, 5.1))
    )
    vertices = np.stack([x, y, z], -1).reshape(-1, 3)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n - 1), np.arange(n - 1), indexing="ij"))
    a, b, c, d = i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).astype(np.int32)
    view = View((0, -14, 7.5), (0, 0, 0.8), (0, 0, 1), 0.9)
    return Model([Part(vertices, triangles, (0.6, 0.5, 0.4))], (), view, sky())


def sky(height: int = 512) -> np.ndarray:
    """(height, 2·height, 3) radiance, top row first: a gradient, brown ground, a sun of 1.5 degrees."""
    rows, columns = (np.arange(height) + 0.5) / height, (np.arange(2 * height) + 0.5) / (2 * height)
    v, u = np.meshgrid(rows, columns, indexing="ij")
    up, phi = np.cos(np.pi * v), 2 * np.pi * (0.5 - u)
    blue = np.array([0.25, 0.45, 0.9]) * (0.4 + 0.6 * np.clip(up, 0, 1)[..., None])
    image = np.where(up[..., None] > 0, blue, [0.15, 0.12, 0.1])
    d = np.stack([np.sin(np.pi * v) * np.cos(phi), np.sin(np.pi * v) * np.sin(phi), up], -1)
    sun = np.array([0.55, -0.35, 0.758])
    image[d @ (sun / np.linalg.norm(sun)) > np.cos(np.radians(0.75))] = (6000, 5400, 4500)
    return image.astype(np.float32)


class Frame(NamedTuple):
    """Image size, and the longest path in edges."""

    width: int
    height: int
    max_depth: int


FRAMES = {"S1": Frame(256, 256, 8), "S2": Frame(640, 360, 5), "S4": Frame(256, 256, 5)}
RR_DEPTH = 4  # the number of edges from which on roulette may end a path; Mitsuba counts one less
MODELS = {"S1": cornell, "S2": plates, "S4": hills}
TITLES = {"S1": "Cornell box", "S2": "GGX plates, 4 sphere lights", "S4": "500k triangles, sunny sky"}
