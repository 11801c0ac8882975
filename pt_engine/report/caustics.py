"""A scene without caustics: after a diffuse bounce surfaces have no specular closures, as Cycles does it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..nodes.batch import Closure, model
from ..scene.scene import DEPTHS, Scene
from ..scene.shading import ShadedBSDF, SliceBSDF
from ..scene.versions import changed

if TYPE_CHECKING:
    from ..render.path_state import PathState
    from ..scene.surface import Surface


class WithoutCaustics(Scene):
    """See the module. Made by `without_caustics` of a prepared scene."""

    def shade(self, si: Surface, path: PathState, spans: list[tuple[int, slice]]) -> ShadedBSDF:
        shaded = super().shade(si, path, spans)
        slices = [(span, _dropped(bsdf, path.diffuse_depth[span] == 0)) for span, bsdf in shaded.slices]
        return ShadedBSDF(shaded.size, slices, shaded.smooth_count)


def _dropped(bsdf: SliceBSDF, straight: NDArray[np.bool_]) -> SliceBSDF:
    """Only lanes that have not been diffuse yet keep their specular closures."""
    keep = straight.astype(np.float32)
    closures = [
        Closure(c.bsdf, c.params, c.weight * keep, c.normal, c.tangent, c.base)  # type: ignore[arg-type]
        if is_specular(c.bsdf)
        else c
        for c in bsdf.closures
    ]
    return SliceBSDF(closures, bsdf.lanes, bsdf.lanes.scene.clear_glass, bsdf.angles)


def is_specular(bsdf: object) -> bool:
    """Whether a model reflects or refracts about a direction."""
    return bool(getattr(bsdf, "SPECULAR", False))


def without_caustics(scene: Scene) -> Scene:
    """The same scene; paths remember how often they have scattered diffusely."""
    return changed(scene, _drop_caustics)


def _drop_caustics(scene: Scene) -> None:
    scene.__class__ = WithoutCaustics
    scene.tracks_history = True
    scene.tracked_depths = tuple(sorted({*scene.tracked_depths, "diffuse_depth"} & DEPTHS))


def why_no_caustics(scene: Scene) -> str:
    """ "" if some material is diffuse and some specular, else what is missing."""
    kinds = {kind for batch in scene.used_batches for kind in batch.kinds}
    specular = {kind for kind in kinds if is_specular(model(kind))}
    if not specular:
        return "no material in use is specular"
    return "" if kinds - specular - {"transparent"} else "no material in use is diffuse"
