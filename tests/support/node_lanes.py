"""Lanes for tests of shader programs: whatever attributes a test gives them, the rest at its default."""

import numpy as np

from pt_engine.nodes.probe import ProbeLanes


class NodeLanes(ProbeLanes):
    """Points whose colour attributes are given by name.

    Parameters
    ----------
    colors : dict of (3, n) float32
    material : int
    **given
        Anything else to set: `position`, `wi`, `ng`, `ns`, `backfacing`, `ray_kind`, `uvs` ...
    """

    def __init__(self, n=1, colors=None, material=0, **given):
        size = next((c.shape[1] for c in (colors or {}).values()), n)
        points = given.pop("position", np.zeros((3, size), np.float32))
        super().__init__(np.full(points.shape[1], material, np.int32), points)
        self.colors = colors or {}
        self.uvs = given.pop("uvs", {})
        for name, value in given.items():
            setattr(self, name, value)

    def color(self, name):
        out = np.zeros((4, self.n), np.float32)
        if name in self.colors:
            out[:3], out[3] = self.colors[name], 1
        return out

    def uv(self, name):
        return self.uvs.get(name, np.zeros((2, self.n), np.float32))
