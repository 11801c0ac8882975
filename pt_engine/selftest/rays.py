"""Rays that leave surfaces: do they meet what they must not meet, or slip out where they can't?"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.frames import frame, to_world
from ..core.warps import square_to_cosine_hemisphere, square_to_sphere
from ..scene.accel import FAR, MISS
from ..scene.prepare import prepare
from ..scene.scene import Scene
from ..scene.snapshot import MeshData
from ..scene.surface import Surface
from ..scene.wave import Intersection, Rays
from . import scenes as make

Float32 = NDArray[np.float32]
Int32 = NDArray[np.int32]
Offset = Callable[[Scene, Surface], Float32]  # how far along the normal a new ray starts, (N,)
COUNT = 50_000
TILT = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


class Shell(NamedTuple):
    """A closed convex mesh of radius 1, `size` times as large, `away` from the origin of float32."""

    mesh: MeshData
    size: float = 1.0
    away: float = 0.0


def disc(count: int) -> MeshData:
    """`count` needles from the middle to the rim."""
    phi = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rim = np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1)
    k = np.arange(count)
    return make.mesh(
        np.concatenate([[(0, 0, 0)], rim]), np.stack([0 * k, 1 + k, 1 + (k + 1) % count], axis=1)
    )


BALL, BOX = make.sphere(1.0, 48, smooth=False), make.box(1.2)
SHELLS = {
    "ball": Shell(BALL),
    "small ball": Shell(BALL, 1e-3),
    "large ball": Shell(BALL, 1e4),
    "moved": Shell(BALL, 1e-2, 100.0),
    "box": Shell(BOX),
    "small box": Shell(BOX, 1e-3),
    "large box": Shell(BOX, 1e4),
}


@cache
def prepared(shell: str) -> Scene:
    """The shell alone; a speck on the other side of the origin keeps the recentring from helping."""
    mesh, size, away = SHELLS[shell]
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = TILT * size, away
    speck = (make.quad(1e-6), make.translation(-away, -away, -away), make.diffuse())
    objects = [(mesh, matrix, make.diffuse()), *([speck] if away else [])]
    return prepare(make.scene(objects, make.orthographic((0, 0, 3), (0, 0, 0), 1.0)))


def bound(scene: Scene, si: Surface) -> Float32:
    """What the engine does: each triangle's own error bound."""
    exact: Float32 = si.bound
    return exact


def naive_fixed(distance: float) -> Offset:
    """The same distance everywhere."""
    return lambda scene, si: np.full(si.size, distance, np.float32)


def first_hits(scene: Scene, shell: Shell, inside: bool, seed: int) -> Surface:
    """Where rays from the middle, or from all around, meet the shell."""
    rng = np.random.default_rng(seed)
    d = square_to_sphere(*rng.random((2, COUNT), np.float32))
    middle = np.full((3, 1), shell.away, np.float32)
    if inside:
        o = np.repeat(middle, COUNT, axis=1)
    else:
        o = (middle - np.float32(3 * shell.size) * d).astype(np.float32)
    return hits(scene, o, d)


def hits(scene: Scene, o: Float32, d: Float32) -> Surface:
    """The surfaces that rays meet."""
    found = trace(scene, o, d)
    return scene.surface(Rays(o, d, found.hits.t), found, np.flatnonzero(found.hits.prim != MISS))


def trace(scene: Scene, o: Float32, d: Float32, strand: Int32 | None = None) -> Intersection:
    """Closest hits of endless rays, that start on curves where `strand` says so."""
    return scene.intersect(Rays(o, d, np.full(o.shape[1], FAR, np.float32), 0, strand))


def onward(si: Surface, scene: Scene, offset: Offset, seed: int) -> tuple[Float32, Float32]:
    """Cosine-distributed rays away from the surface, on the viewer's side."""
    u = np.random.default_rng(seed).random((2, si.size), np.float32)
    d = to_world(*frame(si.ng), si.ng, square_to_cosine_hemisphere(u[0], u[1]))
    return si.p + offset(scene, si) * si.ng, d


def shot(shell: Shell, offset: Offset = bound) -> float:
    """Hits per million rays that leave a convex shell, which is to say hits of itself."""
    scene = prepared(next(name for name, known in SHELLS.items() if known is shell))
    si = first_hits(scene, shell, inside=False, seed=1)
    again = trace(scene, *onward(si, scene, offset, 2)).hits.prim
    return 1e6 * np.count_nonzero(again != MISS) / si.size


def false_hits(offset: Offset = bound) -> float:
    """The worst shell, and a disc of needles."""
    return max(*(shot(shell, offset) for shell in SHELLS.values()), needles(offset))


def needles(offset: Offset = bound) -> float:
    """Rays that leave slivers 600 times as long as wide and meet the same one again, per million."""
    matrix = np.eye(4)
    matrix[:3, :3] = TILT
    scene = prepare(
        make.scene([(disc(4_000), matrix, make.diffuse())], make.orthographic((0, 0, 3), (0, 0, 0), 1.0))
    )
    r, phi = np.random.default_rng(3).random((2, COUNT))
    r, phi = np.sqrt(r), 2 * np.pi * phi
    target = TILT @ np.stack([r * np.cos(phi), r * np.sin(phi), 0 * r])
    d = np.repeat(-TILT[:, 2:], COUNT, axis=1)
    si = hits(scene, (target - 2 * d).astype(np.float32), d.astype(np.float32))
    again = trace(scene, *onward(si, scene, offset, 4)).hits.prim
    return 1e6 * np.count_nonzero(again == si.prim) / si.size


def leaks(offset: Offset = bound) -> float:
    """Escapes from closed shells per million rays that start on their inside."""
    escaped = rays = 0
    for name in ("box", "small box", "large box", "ball"):
        scene = prepared(name)
        si = first_hits(scene, SHELLS[name], inside=True, seed=5)
        escaped += COUNT - si.size
        again = trace(scene, *onward(si, scene, offset, 6)).hits.prim
        escaped += int(np.count_nonzero(again == MISS))
        rays += COUNT + si.size
    return 1e6 * escaped / rays
