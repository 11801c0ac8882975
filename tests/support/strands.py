"""Snapshots with curves and points, and rays tried on every piece by hand."""

from __future__ import annotations

import numpy as np
from support import scenes as make

from pt_engine.scene.round_hits import meet
from pt_engine.scene.snapshot import CurvesData, PointsData
from pt_engine.selftest.scenes import among

__all__ = ["among", "cloud", "nearest", "rays_at", "snapshot", "strand", "tuft"]
FAR_AWAY = (make.quad(1e-3), make.translation(0, 0, -50), make.diffuse(0.5))


def strand(points, radius=0.1, shape="THICK", subdivisions=2, **more):
    """One curve."""
    p = np.asarray(points, np.float32).reshape(-1, 3)
    r = np.broadcast_to(np.asarray(radius, np.float32), len(p)).copy()
    first = np.array([0, len(p)], np.int32)
    return CurvesData("strand", p, r, first, np.zeros(1, np.int32), shape, subdivisions, **more)


def tuft(count, each, radius, shape, seed=1):
    """Bent strands that grow upward and taper to a fifth."""
    rng = np.random.default_rng(seed)
    step = rng.normal(0, 0.12, (count, each - 1, 3)) + [0, 0, 0.25]
    points = np.concatenate([np.zeros((count, 1, 3)), np.cumsum(step, axis=1)], axis=1)
    points += rng.uniform(-1, 1, (count, 1, 3)) * [1, 1, 0]
    radii = np.tile(np.linspace(radius, radius / 5, each), count).astype(np.float32)
    first = np.arange(0, count * each + 1, each, dtype=np.int32)
    slots = np.zeros(count, np.int32)
    return CurvesData("tuft", points.reshape(-1, 3).astype(np.float32), radii, first, slots, shape)


def cloud(points, radius, **more):
    """A point cloud."""
    p = np.asarray(points, np.float32).reshape(-1, 3)
    return PointsData("cloud", p, np.broadcast_to(np.asarray(radius, np.float32), len(p)).copy(), **more)


def snapshot(curves=(), points=(), matrices=None, material=None, camera=None, world=None):
    """Curves and points, all of one material, and a speck far below."""
    camera = camera or make.perspective((0, -5, 0), (0, 0, 0))
    return among(
        make.scene([FAR_AWAY[:2] + (material or FAR_AWAY[2],)], camera, sky=world), curves, points, matrices
    )


def nearest(scene, o, d, own=None):
    """(N,) t of rays (3, N) against every piece in turn but those of the curve `own`, infinite for none."""
    rounds, best = scene.geometry.rounds, np.full(o.shape[1], np.inf)
    for row, strand in zip(rounds.rows, rounds.strand, strict=True):
        near = ((row[:3, None].astype(np.float64) - o) * d).sum(axis=0).astype(np.float32)
        rows = np.broadcast_to(row, (o.shape[1], len(row)))
        t = meet(rows, rounds.kinds, o, d, near).t
        best = np.minimum(best, t if own is None else np.where(own == strand, np.inf, t))
    return best


def rays_at(scene, count, seed=2):
    """(3, N) rays from all around to near the axes of pieces."""
    rng, rows = np.random.default_rng(seed), scene.geometry.rounds.rows
    o = rng.normal(size=(count, 3))
    o *= 4 / np.linalg.norm(o, axis=1, keepdims=True)
    row, way = rows[rng.integers(0, len(rows), count)], rng.random((count, 1))
    target = row[:, :3] * (1 - way) + row[:, 4:7] * way + rng.normal(0, 1, (count, 3)) * row[:, 3:4]
    d = target - o
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return np.ascontiguousarray(o.T, np.float32), np.ascontiguousarray(d.T, np.float32)
