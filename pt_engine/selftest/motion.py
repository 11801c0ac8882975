"""What moves while the shutter is open: shutters of no length, things that come, go, turn over and break."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..scene.matrix_path import MatrixPath
from ..scene.shutter import Shutter
from ..scene.snapshot import InstanceMotion, MeshMotion, Motion, Snapshot
from . import scenes as make
from .case import Group
from .geometry import CAMERA, FLOOR, FURNACE, NOISE, NONE, UP, worst
from .scale import difference, picture, still_life
from .scenes import Matrix

MOTION = Group("Motion")
Float64 = NDArray[np.float64]
OPEN = (1.0, 1.0)
BROKEN = (np.nan, np.inf, -np.inf, 1e300)


def moving(
    snapshot: Snapshot, path: Sequence[Matrix], shutter: Sequence[float] = OPEN, instance: int = 0
) -> Snapshot:
    """A snapshot one of whose instances goes through some matrices."""
    rows = InstanceMotion(np.array([instance], np.int32), np.array([path], np.float64))
    return replace(snapshot, motion=Motion(np.array(shutter, np.float32), (rows,)))


def share(path: Sequence[Matrix], shutter: Sequence[float] = OPEN) -> float:
    """How much of a unit square a shining unit square hides while it moves; NaN if a sample was dropped."""
    camera = make.orthographic((0, 0, 3), (0, 0, 0), 1.0)
    snapshot = make.scene([(make.quad(), UP, make.emission(1.0))], camera)
    result = make.rendered(moving(snapshot, path, shutter), 16, samples=128, sampler="sobol", max_depth=1)
    return NONE if result.progress.nonfinite_count else float(result.image()[..., 0].mean())


@MOTION.case(
    "a shutter of no length",
    "steps that are all the same, and a shutter that opens for an instant in the middle",
    "largest relative difference from the picture that stands still, with equal random numbers",
    0.0,
    2e-3,
    "paths that graze an edge go the other way",
)
def instant() -> float:
    still = still_life()
    reference, here = picture(still), still.instances.matrix[1]
    blink = np.zeros(513)
    blink[256] = 1
    there = [make.translation(x, 0, 0) @ here for x in (-1e-2, 0, 1e-2)]
    moved = [moving(still, [here] * 3, instance=1), moving(still, there, list(blink), instance=1)]
    return max(difference(picture(snapshot), reference) for snapshot in moved)


@MOTION.case(
    "a shutter that never opens, or is open by NaN",
    "all times have density 0, and ∫ s is 0 or NaN",
    "largest deviation of the times from those of a shutter that is open all the time",
    0.0,
    0.0,
    "it is taken as open",
)
def closed() -> float:
    u = np.linspace(0, 1, 65)[:-1]
    shutters = ([0.0, 0.0], [-1.0, -2.0, -1.0], [np.nan] * 4, [np.inf, 0.0])
    times = np.array([[Shutter(np.array(s)).time(float(x)) for x in u] for s in shutters])
    return float(np.abs(times - u).max())


@MOTION.case(
    "objects that appear while the shutter is open",
    "a matrix of zeros has no rotation to start from",
    "share of the light of a square that grows from nothing until half time, s² = (2t)²: 2/3",
    2 / 3,
    8e-3,
    "128 stratified moments",
)
def appears() -> float:
    return share([np.diag([0.0, 0, 0, 1]), UP, UP])


@MOTION.case(
    "objects that collapse to a line",
    "one column is left of the matrix: no plane, no normal, and two axes of its rotation are missing",
    "share of the light of a turned square one of whose edges shrinks to nothing: 1/2",
    0.5,
    8e-3,
    "128 stratified moments",
)
def collapses() -> float:
    turned = np.diag([0.0, 0.0, 0.0, 1.0])
    turned[:3, 0] = 0, 1, 0  # what was x is y
    whole = np.array([[0.0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    return share([whole, turned])


@MOTION.case(
    "objects that turn over",
    "half a turn is as far either way, and element by element it leads through nothing",
    "smallest determinant on the way of a body that turns by 180°, mirrored and not, over the first",
    1.0,
    1e-12,
    "rounding",
    naive=lambda: turned_over(lambda a, b, t: (1 - t) * a + t * b),
)
def turns() -> float:
    return turned_over(lambda a, b, t: MatrixPath.of(np.stack([a, b])[None]).at(t)[0])


def turned_over(between: Callable[[Float64, Float64, float], Float64]) -> float:
    """Over 33 times, about each axis."""
    smallest = np.inf
    for axis in range(3):
        for mirror in (1.0, -1.0):
            a = np.diag([mirror, 1.0, 1.0, 1.0])
            half = -np.eye(4)
            half[axis, axis] = half[3, 3] = 1
            ways = [between(a, half @ a, t) for t in np.linspace(0, 1, 33)]
            smallest = min(smallest, *(mirror * float(np.linalg.det(way[:3, :3])) for way in ways))
    return smallest


@MOTION.case(
    "matrices that are not finite at one step",
    "NaN between two sound steps; Embree must never see it",
    "radiance of the floor below what moves so, and of one that is itself there at other steps only",
    FURNACE,
    5e-3,
    NOISE,
)
def broken_steps() -> float:
    floor = (FLOOR, UP, make.diffuse(FURNACE))
    above = (make.quad(1.0), make.translation(0, 0, 1), make.diffuse(0.0, "black"))
    scene = make.scene([above, floor], CAMERA, sky=make.world(1.0))
    paths = [[above[1], np.full((4, 4), bad), above[1]] for bad in BROKEN]
    return worst([seen(moving(scene, path)) for path in paths], FURNACE)


@MOTION.case(
    "vertices that are not finite at one step",
    "blended with sound ones they are NaN at all times between",
    "radiance of the floor beside a corner that breaks",
    FURNACE,
    5e-3,
    NOISE,
)
def broken_shapes() -> float:
    mesh = make.quad(9.0)
    values = []
    for bad in BROKEN[:3]:
        steps = np.stack([mesh.vertices] * 3)
        steps[1, 0] = bad
        scene = make.scene([(mesh, UP, make.diffuse(FURNACE)), (FLOOR, UP, make.diffuse(FURNACE))], CAMERA)
        motion = Motion(np.ones(2, np.float32), meshes=(MeshMotion(0, steps),))
        values.append(seen(replace(scene, motion=motion, world=make.world(1.0))))
    return worst(values, FURNACE)


def seen(snapshot: Snapshot) -> float:
    """Mean radiance; NaN if a sample was dropped."""
    result = make.rendered(snapshot, 8, samples=64, sampler="sobol", integrator="path_active", max_depth=2)
    return NONE if result.progress.nonfinite_count else float(result.image()[..., :3].mean())


@MOTION.case(
    "a shutter that opens ever so slightly more",
    "the root of the quadratic for the time cancels where the openness hardly grows",
    "largest error of the times of an openness 1 … 1 + 3e-13",
    0.0,
    1e-12,
    "rounding",
    naive=lambda: times_error(lambda a, growth, area: (np.sqrt(a * a + 2 * area * growth) - a) / growth),
)
def nearly_even() -> float:
    return times_error(drawn)


def drawn(openness: float, growth: float, area: float) -> float:
    """The time at which a shutter has let so much through."""
    return Shutter(np.array([openness, openness + growth])).time(area / (openness + growth / 2))


def times_error(root: Callable[[float, float, float], float]) -> float:
    """Against t = u (1 + g/2 (1 − u)), which holds to g²."""
    growth, u = 3e-13, np.linspace(0, 1, 64)[:-1]
    exact = u * (1 + growth / 2 * (1 - u))
    times = [root(1.0, growth, x * (1 + growth / 2)) for x in u]
    return float(np.abs(np.array(times) - exact).max())
