"""The world's and the lamps' shader graphs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.clock import stage
from ..scene.snapshot import Graph, ImageData
from ..textures.images import TextureStore
from . import catalogue as catalogue  # fills the registry
from .batch import Batch, plan
from .coverage import APPROXIMATE, Coverage, CoverageLog
from .graph import GraphReader
from .ir import Builder
from .program import LanesLike
from .sky_nodes import SunDisc
from .suns import Sun, find_suns
from .surface import SurfaceBuilder

Float32 = NDArray[np.float32]
DEPTHS = frozenset(
    f"{kind}depth" for kind in ("", "diffuse_", "glossy_", "transmission_", "transparent_", "portal_")
)


@dataclass
class WorldProgram:
    """What arrives from outside the scene.

    Attributes
    ----------
    constant : (3,) float32 or None
        The radiance, where it is the same in every direction.
    emits : bool
        Whether any light arrives at all.
    suns : tuple of Sun
        Discs too small to be found by chance.
    without_suns : WorldProgram or None
        The same world without the `suns`, where it has any.
    image_rows : int
        Height of its tallest image, 0 if it has none.
    """

    constant: Float32 | None
    emits: bool
    coverage: list[Coverage] = field(default_factory=list)
    needs: frozenset[str] = frozenset()
    _batch: Batch | None = None
    suns: tuple[Sun, ...] = ()
    without_suns: WorldProgram | None = None
    image_rows: int = 0

    @stage("", "environment")
    def emission(self, lanes: LanesLike) -> Float32:
        """(3, n) radiance that travels along the lanes' rays backwards, into the scene."""
        if self._batch is None:
            known = np.zeros(3, np.float32) if self.constant is None else self.constant
            return np.broadcast_to(known[:, None], (3, lanes.n))
        value = self._batch.emission(lanes)
        if value is None:
            return np.zeros((3, lanes.n), np.float32)
        return np.broadcast_to(value, (3, lanes.n)) if value.shape[1] != lanes.n else value


def compile_world(
    graph: Graph | None,
    images: Sequence[ImageData] = (),
    ocio_config: str = "",
    textures: TextureStore | None = None,
) -> WorldProgram:
    """Compile a world; None is black."""
    if graph is None:
        return WorldProgram(np.zeros(3, np.float32), False)
    textures = textures or TextureStore(images, ocio_config)
    batch, log, discs = _emitter(graph, textures, world=True)
    known = batch.constant_emission()
    if known is None:
        rows = textures.tallest(node.props.get("image") for node in graph.nodes)
        world = WorldProgram(None, True, log.entries(), batch.needs, batch, image_rows=rows)
        suns = find_suns(discs)
        if suns:
            world.suns = suns
            plain, _, _ = _emitter(graph, textures, world=True, draw_suns=False)
            world.without_suns = WorldProgram(None, True, _batch=plain, image_rows=rows)
        return world
    radiance = np.ascontiguousarray(known[:, 0])
    return WorldProgram(radiance, bool((radiance != 0).any()), log.entries(), batch.needs)


class LightProgram(NamedTuple):
    """What a lamp's node tree does to its power.

    Attributes
    ----------
    constant : (3,) float32
        Its factor; 1 where it varies.
    coverage : list of Coverage
    batch : Batch or None
        The factor where it varies.
    """

    constant: Float32
    coverage: list[Coverage]
    batch: Batch | None = None


def compile_light(
    graph: Graph | None,
    images: Sequence[ImageData] = (),
    ocio_config: str = "",
    textures: TextureStore | None = None,
) -> LightProgram:
    """Compile a lamp; None is the factor 1."""
    one = np.ones(3, np.float32)
    if graph is None:
        return LightProgram(one, [])
    batch, log, _ = _emitter(graph, textures or TextureStore(images, ocio_config), world=False)
    known = batch.constant_emission()
    if known is not None:
        return LightProgram(np.ascontiguousarray(known[:, 0]), log.entries())
    if batch.needs & DEPTHS:
        log.note(graph.name, APPROXIMATE, "a lamp does not know how deep the path is: 1, and 0 of each kind")
    return LightProgram(one, log.entries(), batch)


def _emitter(
    graph: Graph, textures: TextureStore, world: bool, draw_suns: bool = True
) -> tuple[Batch, CoverageLog, list[SunDisc]]:
    builder, log = Builder(), CoverageLog(graph.name)
    out = SurfaceBuilder(builder)
    reader = GraphReader(graph, builder, textures, log, world, draw_suns)
    link = graph.outputs.get("Surface")
    if link is not None:
        reader.closures(link, builder.one, out)
    if graph.outputs.get("Volume") is not None:
        log.note(graph.name, "ignored", "the volume is left out: clear air")
    for node, effect in graph.notes:
        log.note(node, "ignored", effect)
    out.leaves, out.transparency = [], None
    key, constants = plan(out)
    return Batch(key, [constants], [0]), log, reader.suns
