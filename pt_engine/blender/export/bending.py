"""Strands and points whose shape changes while the shutter is open, and what attributes say of velocities."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...scene.snapshot import CurvesData, PointsData, RoundMotion
from .curves import export_curves, export_strands
from .meshes import read
from .needs import Needs
from .points import export_points

VELOCITY = "velocity"  # metres a second, by point; Cycles knows no other
UNMOVED = 1e-5  # of the largest coordinate: strands of particles come from the world, with its rounding


@dataclass
class Bend:
    """Curves or points at the times looked at so far, while they stay the same ones."""

    name: str
    middle: CurvesData | PointsData
    steps: int
    velocity: np.ndarray | None = None
    shapes: dict = field(default_factory=dict)
    problem: str = ""

    def look(self, owner, depsgraph, time: int) -> None:
        """As they are now, which does not matter where an attribute says how they move."""
        if self.velocity is not None:
            return
        there = shape_of(owner, depsgraph)
        if there is None or not same_ones(there, self.middle):
            self.problem = "strands or points come and go while the shutter is open: sharp where they bend"
        elif differs(there.points, self.middle.points) or differs(there.radius, self.middle.radius):
            self.shapes[time] = there

    def motion(self, number: int, finest: int, seconds: float) -> RoundMotion | None:
        """Shapes of geometry `number`, the shutter open for `seconds`; None where there is but one."""
        if self.velocity is not None and self.velocity.any():
            points = by_velocity(self.middle.points, self.velocity, seconds)
            return RoundMotion(number, points, np.array([self.middle.radius] * 2))
        if self.problem or not self.shapes:
            return None
        shapes = [self.shapes.get(t, self.middle) for t in range(0, finest, (finest - 1) // (self.steps - 1))]
        return RoundMotion(number, np.array([s.points for s in shapes]), np.array([s.radius for s in shapes]))


def shape_of(owner, depsgraph) -> CurvesData | PointsData | None:
    """The strands or points of an evaluated object as they are now, without what materials ask for."""
    if owner.type == "POINTCLOUD":
        return export_points(owner.name, owner.data, Needs())
    if owner.type == "CURVES":
        return export_curves(owner.name, owner.data, Needs(), "RIBBON", 0)
    emitter = owner.original.evaluated_get(depsgraph)
    return export_strands(emitter, depsgraph.mode == "VIEWPORT", Needs(), "RIBBON", 0)


def same_ones(a, b) -> bool:
    """Whether two shapes have the same strands, of equally many points."""
    return len(a.points) == len(b.points) and np.array_equal(getattr(a, "first", 0), getattr(b, "first", 0))


def differs(a, b) -> bool:
    """Whether numbers differ by more than they are rounded."""
    return bool(np.abs(a - b).max(initial=0) > UNMOVED * np.abs(b).max(initial=0))


def velocity(data):
    """(P, 3) of an evaluated geometry's points; None where no attribute says it."""
    attribute = data.attributes.get(VELOCITY)
    if attribute is None or attribute.domain != "POINT" or attribute.data_type != "FLOAT_VECTOR":
        return None
    return read(attribute.data, "vector", np.float32, 3)


def has_velocity(data) -> bool:
    """Whether a geometry's attribute says how its points move."""
    return VELOCITY in getattr(data, "attributes", ())


def by_velocity(points, speed, seconds: float):
    """(2, P, 3) where `points` (P, 3) are when the shutter opens and when it closes, `seconds` later."""
    way = speed * np.float32(seconds / 2)
    return np.array([points - way, points + way])
