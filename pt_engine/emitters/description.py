"""What shines in a scene, in a few words that decide what a wavefront has to ask."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Description:
    """What shines in a scene; `counts` by kind: point, spot, sun, area, triangle, environment."""

    counts: dict[str, int]
    has_delta: bool
    all_delta: bool
    has_triangles: bool
    meets_lamps: bool  # some ray that is not the camera's can meet a lamp
    camera_meets_lamps: bool

    @property
    def total(self) -> int:
        """Emitters with power."""
        return sum(self.counts.values())

    def are_met(self, camera: bool) -> bool:
        """Whether camera rays, or others, can meet a lamp."""
        return self.camera_meets_lamps if camera else self.meets_lamps
