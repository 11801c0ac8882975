"""Stand-in lanes: a sheet of points that programs are tried on when no scene is there yet.

Light selection needs a rough power for emitters whose radiance varies over the surface; the mean of
their program over this sheet is it.
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..core.raykind import RayKind
from ..core.view import View

if TYPE_CHECKING:
    from .batch import Batch

Float32 = NDArray[np.float32]
STEP = np.float32(1e-3)


class ProbeLanes:
    """A unit square in the xy plane, seen from straight above, with everything else at its default.

    Parameters
    ----------
    material : (n,) int32
    points : (3, n) float32
        Positions; their x and y are the uv too.
    """

    smooth = False
    rounds = None
    view = View()

    def __init__(self, material: NDArray[np.int32], points: Float32) -> None:
        self.n = points.shape[1]
        self.material = material
        self.position = self.p = points
        up = np.zeros_like(points)
        up[2] = 1
        self.wi = self.ng = self.ns = up
        self.backfacing = np.zeros(self.n, np.float32)
        self.ray_length = np.ones(self.n, np.float32)
        self.ray_kind = np.full(self.n, RayKind.DIFFUSE, np.int32)
        self.depth = self.transparent_depth = np.zeros(self.n, np.int32)

    @property
    def horizon(self) -> Float32:
        return self.ng

    def uv(self, name: str) -> Float32:
        return self.position[:2]

    def generated(self) -> Float32:
        return self.position

    object_position = generated

    def color(self, name: str) -> Float32:
        return np.ones((4, self.n), np.float32)

    def attribute(self, name: str) -> Float32:
        return np.concatenate([self.color(name), self.color(name)[:1]])

    def object_tangent(self, uv_name: str) -> tuple[Float32, Float32]:
        t = np.zeros_like(self.position)
        t[0] = 1
        return t, np.ones(self.n, np.float32)

    def edges(self) -> tuple[Float32, Float32]:
        return self.bump_steps(1.0)

    def along_hair(self, corner: int) -> Float32:
        return vectors.normalize(self.edges()[corner - 1])

    def strand(self) -> Float32:
        return np.zeros((4, self.n), np.float32)

    def barycentric(self) -> Float32:
        return self.position[:2]

    def object_normal(self) -> Float32:
        return self.ns

    def to_world_normal(self, n: Float32) -> Float32:
        return n

    to_object_normal = to_object_vector = to_world_vector = to_world_normal

    def object_random(self) -> Float32:
        return np.zeros(self.n, np.float32)

    object_index = object_random

    def object_color(self) -> Float32:
        return np.ones((4, self.n), np.float32)

    def depth_of(self, kind: str) -> NDArray[np.int32]:
        return self.depth

    def per_object(self, name: str) -> Float32:
        return np.zeros((4, self.n), np.float32)

    def window(self) -> Float32:
        return self.view.image_of_direction(self.position)

    def object_location(self) -> Float32:
        return np.zeros((3, self.n), np.float32)

    def sides(self) -> list[tuple[Float32, Float32]]:
        along, away = self.bump_steps(1.0)
        return [(along, away / STEP)]

    def bump_steps(self, width: float) -> tuple[Float32, Float32]:
        x, y = np.zeros((3, self.n), np.float32), np.zeros((3, self.n), np.float32)
        x[0], y[1] = STEP, STEP
        return x, y

    def shifted(self, axis: int, width: float) -> ProbeLanes:
        """One step along axis 1 or 2; a probe is flat before displacement (4 more) as after it."""
        out = copy.copy(self)
        if axis & 3:
            out.position = out.p = self.position + self.bump_steps(width)[(axis & 3) - 1]
        return out


def sheet(side: int = 16) -> Float32:
    """(3, side²) cell centres of the unit square."""
    x, y = np.meshgrid((np.arange(side) + 0.5) / side, (np.arange(side) + 0.5) / side)
    return np.stack([x.ravel(), y.ravel(), np.zeros(side * side)]).astype(np.float32)


def mean_emission(batch: Batch) -> Float32:
    """(3, M) mean radiance of each of a batch's materials over the sheet; finite and not negative."""
    points = sheet()
    means = []
    for material in batch.materials:
        value = batch.emission(ProbeLanes(np.full(points.shape[1], material, np.int32), points))
        if value is None:
            means.append(np.zeros(3, np.float32))
            continue
        finite = np.nan_to_num(value, nan=0.0, posinf=0.0, neginf=0.0).clip(0)
        means.append(finite.mean(axis=1, dtype=np.float64).astype(np.float32))
    return np.stack(means, axis=1)
