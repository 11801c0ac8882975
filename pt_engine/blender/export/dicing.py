"""Adaptive subdivision: meshes diced until their cells are as small as the camera's pixels.

Blender evaluates the modifier at its render level; from there `scene.refine` cuts on, along the cubic
patches that the vertices' normals span. All sizes are as Cycles has them: the dicing rate in pixels of the
render (or, by the modifier, in the object's own units), larger out of view.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...scene.pixel_size import pixel_size
from ...scene.refine import refined
from ...scene.snapshot import MeshData
from .camera import export_camera, full_size

MAX_TRIANGLES = 4_000_000  # of all diced meshes together: a gigabyte, with all that is built from them
SMALLEST = 0.1  # pixels; Cycles goes no further


class Adaptive(NamedTuple):
    """How a modifier dices: `rate` pixels, or lengths in the object, on a surface that is curved or not."""

    rate: float
    in_pixels: bool
    curved: bool


class Dicing:
    """Dices the meshes of a frame, within a number of triangles.

    Parameters
    ----------
    depsgraph, scene : bpy.types.Depsgraph, bpy.types.Scene
    camera : bpy.types.Object
        Evaluated; the scene may have another for dicing.
    size : (width, height) or None
        Full image size, where it isn't the render settings'.
    """

    def __init__(self, depsgraph, scene, camera, size, unsupported) -> None:
        settings = getattr(scene, "cycles", None)
        self.shown = "show_viewport" if depsgraph.mode == "VIEWPORT" else "show_render"
        rate = "preview_dicing_rate" if depsgraph.mode == "VIEWPORT" else "dicing_rate"
        self.rate = getattr(settings, rate, 1.0)
        self.offscreen = getattr(settings, "offscreen_dicing_scale", 4.0)
        self.experimental = getattr(settings, "feature_set", "") == "EXPERIMENTAL"
        other = getattr(settings, "dicing_camera", None)
        self.camera = camera if other is None else other.evaluated_get(depsgraph)
        self.render, self.size, self.unsupported = scene.render, size, unsupported
        self.left = MAX_TRIANGLES
        self._pixel = None

    def pixel(self, points):
        """(n,) size of a pixel at world positions (n, 3)."""
        if self._pixel is None:
            data = export_camera(self.camera, self.render, size=self.size, unsupported=[])
            self._pixel = pixel_size(data, *(self.size or full_size(self.render)), self.offscreen)
        return self._pixel(points)

    def dice(self, owner, mesh: MeshData, matrix) -> MeshData:
        """A mesh of `owner`, diced where its last modifier says so."""
        how = adaptive(owner, self.shown, self.experimental)
        if how is None:
            return mesh
        matrix = np.array(matrix, np.float64)
        limit = max(self.left, 1)
        if how.in_pixels:
            pixels = max(how.rate * self.rate, SMALLEST)
            diced, coarser = refined(mesh, matrix, lambda p: pixels * self.pixel(p), how.curved, limit)
        else:
            length = max(how.rate * self.rate, 1e-6)
            diced, coarser = refined(mesh, np.eye(4), lambda p: np.full(len(p), length), how.curved, limit)
        self.left -= len(diced.triangles)
        if coarser > 1:
            effect = f"diced {coarser:.1f} times as coarse as asked for, to fit into memory"
            self.unsupported.append((f"Object {owner.name}", "adaptive subdivision", effect))
        return diced


def adaptive(owner, shown: str, experimental: bool) -> Adaptive | None:
    """The settings of an evaluated object's adaptive subdivision, None where it has none.

    It must be the last of the modifiers that are on (`shown` names the switch). Blender 4.5 has its own
    switch on the object, which counts with Cycles' experimental features only.
    """
    last = next(reversed([m for m in owner.modifiers if getattr(m, shown)]), None)
    if last is None or last.type != "SUBSURF":
        return None
    curved = last.subdivision_type == "CATMULL_CLARK"
    if hasattr(last, "use_adaptive_subdivision"):
        if not last.use_adaptive_subdivision:
            return None
        in_pixels = last.adaptive_space == "PIXEL"
        rate = last.adaptive_pixel_size if in_pixels else last.adaptive_object_edge_length
        return Adaptive(rate, in_pixels, curved)
    settings = getattr(owner, "cycles", None)
    if experimental and getattr(settings, "use_adaptive_subdivision", False):
        return Adaptive(settings.dicing_rate, True, curved)
    return None
