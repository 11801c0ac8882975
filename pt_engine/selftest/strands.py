"""Hair and points at their limits: needles seen from afar, no radius, NaN, points that coincide."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..scene.accel import MISS
from ..scene.prepare import prepare
from ..scene.round_hits import THICK, meet
from ..scene.snapshot import CurvesData, PointsData, Snapshot
from . import scenes as make
from .case import Group
from .geometry import CAMERA, FLOOR, FURNACE, NOISE, NONE, UP, worst
from .rays import TILT, bound, hits, onward, trace

STRANDS = Group("Hair and points")
Float32 = NDArray[np.float32]
SHAPES = ("RIBBON", "THICK", "LINEAR")
SKY = make.world(1.0)


def strand(points: object, radius: object, shape: str = "THICK") -> CurvesData:
    """One curve."""
    p = np.asarray(points, np.float32).reshape(-1, 3)
    r = np.broadcast_to(np.asarray(radius, np.float32), len(p)).copy()
    return CurvesData("strand", p, r, np.array([0, len(p)], np.int32), np.zeros(1, np.int32), shape)


def balls(points: object, radius: object) -> PointsData:
    """A point cloud."""
    p = np.asarray(points, np.float32).reshape(-1, 3)
    return PointsData("balls", p, np.broadcast_to(np.asarray(radius, np.float32), len(p)).copy())


def radiance(snapshot: Snapshot, depth: int = 2) -> float:
    """Mean; NaN if a sample was dropped."""
    how = {"samples": 64, "sampler": "sobol", "integrator": "path_active", "max_depth": depth}
    result = make.rendered(snapshot, 8, **how)
    return NONE if result.progress.nonfinite_count else float(result.image()[..., :3].mean())


@STRANDS.case(
    "hair of 1e-5, seen from 100 away",
    "its square is 1e-10, and float32's squares of the distance have a spacing of 1e-3",
    "share of a view five times as wide that it takes, all shapes, the worst",
    0.2,
    2e-3,
    "8 × 8 pixels of 64 Sobol samples; edges",
    naive=lambda: covered_in_float32(1e-5, 100.0),
)
def thin() -> float:
    return worst([covered(shape, 1e-5, 100.0) for shape in SHAPES], 0.2)


def covered(shape: str, radius: float, away: float) -> float:
    """Share of a view of ten radii that a strand across it takes, as the camera sees it."""
    camera = replace(make.orthographic((0, 0, away), (0, 0, 0), 10 * radius), clip=(1e-3, 1e6))
    far = make.quad(1e-3), make.translation(0.5, 0.5, -0.5), make.emission(1.0)
    hair = strand([(-1, 0, 0), (1, 0, 0)], radius, shape)
    return radiance(make.among(make.scene([far], camera), [hair]), depth=1)


def covered_in_float32(radius: float, away: float) -> float:
    """The same by the cylinder's quadratic about the ray's origin, in float32."""
    y = ((np.arange(4096) + 0.5) / 4096 * 10 - 5).astype(np.float32) * np.float32(radius)
    o, d = np.stack([y, np.full_like(y, away)]), np.float32(-1)
    b, c = o[1] * d, o[0] * o[0] + o[1] * o[1] - np.float32(radius) ** 2
    return float((b * b - c >= 0).mean())


@STRANDS.case(
    "strands and points without radius",
    "cones of no opening, normals of 0/0, a taper that ends in nothing",
    "radiance of a white sky behind them, all shapes",
    1.0,
    0.0,
    "there is nothing to be hit",
)
def no_radius() -> float:
    line = [(-1, 0, 0), (0, 0.1, 0), (1, 0, 0)]
    values = []
    for radius in (0.0, -1.0, 1e-30):
        hair = [strand(line, radius, shape) for shape in SHAPES]
        empty = make.scene([(make.quad(1e-3), make.translation(0, 0, -9), make.diffuse())], CAMERA, sky=SKY)
        values.append(radiance(make.among(empty, hair, [balls(line, radius)])))
    return worst(values, 1.0)


@STRANDS.case(
    "strands and points of NaN and infinity",
    "one of them in a hull spoils Embree's tree",
    "radiance of a floor below strands each of which is broken somewhere",
    FURNACE,
    5e-3,
    NOISE,
)
def broken() -> float:
    values = []
    for bad in (np.nan, np.inf, -np.inf, 3e38):
        line = np.array([(-9, 9, -1), (0, 9, -1), (9, 9, -1)], float)
        corner, radii = line.copy(), np.full(3, 0.1)
        corner[1], radii[1] = bad, bad
        hair = [
            strand(p, r, shape) for shape in SHAPES for p, r in ((corner, np.full(3, 0.1)), (line, radii))
        ]
        points = [balls(corner, 0.1), balls(line, radii)]
        values.append(below(hair, points))
    return worst(values, FURNACE)


def below(hair: list[CurvesData], points: list[PointsData] | None = None) -> float:
    """Radiance of the floor among strands and points."""
    floor = make.scene([(FLOOR, UP, make.diffuse(FURNACE))], CAMERA, sky=SKY)
    return radiance(make.among(floor, hair, points or []))


@STRANDS.case(
    "points of a strand that coincide",
    "pieces of no length have no direction, and splines through them no tangent",
    "radiance of a white strand with doubled points in a white sky, over that of one without, all shapes",
    1.0,
    1e-3,
    "a spline through them is cut elsewhere; edges",
)
def doubled() -> float:
    line = np.array([(-1, 0, 0), (-0.3, 0, 0), (0.2, 0, 0), (1, 0, 0)])
    values = []
    for shape in SHAPES:
        twice = alone(strand(line[[0, 0, 1, 1, 2, 3, 3, 3]], 0.2, shape))
        values.append(twice / alone(strand(line, 0.2, shape)))
    return worst(values, 1.0)


def alone(hair: CurvesData) -> float:
    """Radiance of a grey strand."""
    speck = make.quad(1e-3), make.translation(0, 0, -9), make.diffuse(0.5)
    return radiance(make.among(make.scene([speck], CAMERA, sky=SKY), [hair]))


@STRANDS.case(
    "no curve, no point, curves of one point",
    "tables without rows",
    "radiance of the floor among them",
    FURNACE,
    5e-3,
    NOISE,
)
def empty() -> float:
    nothing = CurvesData("none", np.zeros((0, 3), np.float32), np.zeros(0, np.float32), np.zeros(1, np.int32),
                         np.zeros(0, np.int32))  # fmt: skip
    one = [strand([(0, 0, 1)], 0.5, shape) for shape in SHAPES]
    hollow = replace(nothing, first=np.zeros(3, np.int32), material_slot=np.zeros(2, np.int32))
    return below([nothing, hollow, *one], [balls(np.zeros((0, 3)), 0.1)])


@STRANDS.case(
    "no acne on tubes, cones and balls",
    "where a ray leaves a round surface depends on the root of a quadratic, not on a plane's bound",
    "false hits per million rays that leave a straight strand or a ball, at sizes from 1e-3 to 1e3",
    0.0,
    0.0,
    "rays do not meet the curve that they start on, and balls from outside only",
    naive=lambda: float(1e6 * again_in_float32()),
)
def acne() -> float:
    return max(left(round_, size) for size in (1e-3, 1.0, 1e3) for round_ in (*SHAPES[1:], "BALL"))


def left(shape: str, size: float) -> float:
    """Rays that leave it outward and meet it again, per million."""
    line = TILT @ np.array([(-1.0, 0, 0), (1, 0, 0)]).T * size
    speck = make.quad(1e-6), make.translation(0, 0, 0), make.diffuse()
    camera = make.orthographic((0, 0, 3), (0, 0, 0), 1.0)
    curves = [] if shape == "BALL" else [strand(line.T, 0.3 * size, shape)]
    points = [balls([(0, 0, 0)], 0.3 * size)] if shape == "BALL" else []
    scene = prepare(make.among(make.scene([speck], camera), curves, points))
    rng = np.random.default_rng(2)
    target = rng.normal(size=(3, 20_000)) * 0.2 * size
    d = rng.normal(size=target.shape)
    d /= np.linalg.norm(d, axis=0)
    si = hits(scene, (target - 4 * size * d).astype(np.float32), d.astype(np.float32))
    again = trace(scene, *onward(si, scene, bound, 3), si.strand).hits.prim
    return 1e6 * float(np.count_nonzero(again != MISS)) / si.size


def again_in_float32() -> float:
    """Share of rays from a ball's surface whose quadratic in float32 has a root ahead of them."""
    rng = np.random.default_rng(2)
    n = rng.normal(size=(3, 20_000)).astype(np.float32)
    n /= np.sqrt((n * n).sum(axis=0))
    d = rng.normal(size=n.shape).astype(np.float32)
    d *= np.copysign(np.float32(1), (d * n).sum(axis=0)) / np.sqrt((d * d).sum(axis=0))
    b, c = (n * d).sum(axis=0), (n * n).sum(axis=0) - np.float32(1)
    t = -b + np.sqrt(np.maximum(b * b - c, 0))
    return float((t > 0).mean())


@STRANDS.case(
    "a needle looked at along its axis",
    "the quadratic's leading coefficient is 0 where the ray runs along a cone's side",
    "largest distance of where rays along a cone meet it from where they should, over its length",
    0.0,
    1e-6,
    "float32's rays; the rest is float64",
)
def along() -> float:
    """A cone from radius 0 at x = 0 to 1e-3 at x = 1, rays toward +x at heights h meet it at x = h/1e-3."""
    height = np.linspace(5e-5, 9.5e-4, 200).astype(np.float32)
    row = np.zeros((200, 16), np.float32)
    row[:, 4], row[:, 7], row[:, 8], row[:, 11], row[:, 14] = 1, 1e-3, 1, 1, THICK
    o = np.stack([np.full_like(height, -2), height, np.zeros_like(height)])
    d = np.zeros_like(o)
    d[0] = 1
    met = meet(row, (THICK,), o, d, np.full_like(height, 2))
    slope = float(np.float32(1e-3))
    return float(np.abs(met.t - 2 - height.astype(np.float64) / slope).max())
