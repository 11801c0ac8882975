"""Point clouds as arrays."""

from __future__ import annotations

import numpy as np

from ...scene.snapshot import PointsData
from .curves import colors, radii
from .meshes import PAIRS, READ_AS, read
from .needs import Needs

DEFAULT_RADIUS = 0.01


def export_points(name: str, cloud, needs: Needs) -> PointsData | None:
    """An evaluated PointCloud; None where it has no points."""
    position = cloud.attributes.get("position")
    if position is None or not len(position.data):
        return None
    points = read(position.data, "vector", np.float32, 3)
    stored = {attribute.name: attribute for attribute in cloud.attributes}
    uvs = {
        wanted: read(stored[wanted].data, *READ_AS[PAIRS])
        for wanted in sorted(needs.uvs & stored.keys())
        if stored[wanted].data_type == PAIRS
    }
    return PointsData(
        name, points, radii(stored, len(points), DEFAULT_RADIUS), uvs, colors(stored, needs, uvs)
    )
