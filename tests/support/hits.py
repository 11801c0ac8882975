"""Rays by hand against a prepared scene, and the lanes they give."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pt_engine.scene.accel import FAR
from pt_engine.scene.arrivals import Arrivals
from pt_engine.scene.lanes import Lanes
from pt_engine.scene.scene import Scene
from pt_engine.scene.surface import Surface
from pt_engine.scene.wave import Intersection, Rays


class Shot(NamedTuple):
    """Rays, what they have found, and the hit points of the lanes that hit something."""

    rays: Rays
    found: Intersection
    lanes: np.ndarray
    si: Surface


def column(vectors: object) -> np.ndarray:
    """(3, N) float32 of N vectors."""
    return np.ascontiguousarray(np.asarray(vectors, np.float64).reshape(-1, 3).T, np.float32)


def unit(vectors: object) -> np.ndarray:
    """(3, N) float32 unit vectors of (N, 3) vectors."""
    v = np.asarray(vectors, np.float64).reshape(-1, 3)
    return column(v / np.linalg.norm(v, axis=1, keepdims=True))


def shoot(scene: Scene, origins: object, directions: object) -> Shot:
    """Rays from world points (N, 3) along (N, 3), through the scene's own methods."""
    o = column(np.asarray(origins, np.float64).reshape(-1, 3) - scene.geometry.origin)
    rays = Rays(o, unit(directions), np.full(o.shape[1], FAR, np.float32))
    found = scene.intersect(rays)
    lanes = np.flatnonzero(found.hits.prim >= 0)
    return Shot(rays, found, lanes, scene.surface(rays, found, lanes))


def lanes_of(scene: Scene, si: Surface, smooth: bool = False, kind: int = 1) -> Lanes:
    """What a program sees of these hits."""
    return Lanes(scene, si, Arrivals.by(kind, si.size), smooth)


def random_directions(n: int, seed: int = 0) -> np.ndarray:
    """(n, 3) float64, uniform on the sphere."""
    v = np.random.default_rng(seed).normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def rotation(seed: int = 4) -> np.ndarray:
    """A 3×3 rotation with no special directions."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def placed(linear: object, at: object = (0.0, 0.0, 0.0)) -> np.ndarray:
    """A 4×4 matrix of a 3×3 part and a place."""
    m = np.eye(4)
    m[:3, :3], m[:3, 3] = linear, at
    return m
