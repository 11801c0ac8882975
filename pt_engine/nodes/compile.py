"""From a snapshot's graphs to batches: read, fold, group by structure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..scene.snapshot import Graph, ImageData, Link
from ..textures.images import TextureStore
from . import catalogue as catalogue  # fills the registry
from .batch import Batch, Plan, plan
from .coverage import APPROXIMATE, IGNORED, Coverage, CoverageLog
from .graph import GraphReader
from .ir import Builder
from .normals import displaced_normal
from .probe import mean_emission
from .surface import SurfaceBuilder

Float32 = NDArray[np.float32]


@dataclass
class Materials:
    """All materials of a scene, compiled.

    Attributes
    ----------
    batch_of : (M,) int32
        Which of `batches` each material belongs to.
    emission_constant : (M, 3) float32
        Radiance of each material; exact where `emission_varies` is False, else a mean over a probe.
    emission_varies : (M,) bool
    coverage : list of Coverage
        Every reachable node.
    """

    batch_of: NDArray[np.int32]
    batches: list[Batch]
    emission_constant: Float32
    emission_varies: NDArray[np.bool_]
    coverage: list[Coverage] = field(default_factory=list)

    @property
    def needs(self) -> frozenset[str]:
        """Lane attributes that some batch reads."""
        return frozenset(name for b in self.batches for name in b.needs)


def compile_materials(
    graphs: Sequence[Graph], images: Sequence[ImageData] = (), ocio_config: str = ""
) -> Materials:
    """Compile `Snapshot.materials`; `images` and `ocio_config` are the snapshot's too."""
    textures = TextureStore(images, ocio_config)
    coverage: list[Coverage] = []
    members: dict[Plan, list[int]] = {}
    constants: dict[int, list[Float32]] = {}
    for number, graph in enumerate(graphs):
        log = CoverageLog(graph.name)
        surface = read_surface(graph, textures, log)
        key, constants[number] = plan(surface)
        members.setdefault(key, []).append(number)
        coverage += log.entries()
    batches = [Batch(key, [constants[m] for m in materials], materials) for key, materials in members.items()]
    return _collect(len(graphs), batches, coverage)


def _collect(count: int, batches: list[Batch], coverage: list[Coverage]) -> Materials:
    batch_of = np.zeros(count, np.int32)
    emission, varies = np.zeros((count, 3), np.float32), np.zeros(count, bool)
    for k, batch in enumerate(batches):
        rows = list(batch.materials)
        batch_of[rows] = k
        known = batch.constant_emission()
        varies[rows] = known is None
        emission[rows] = mean_emission(batch).T if known is None else known.T
    return Materials(batch_of, batches, emission, varies, coverage)


def read_surface(graph: Graph, textures: TextureStore, log: CoverageLog) -> SurfaceBuilder:
    """The closures of a material's Surface output."""
    return surface_of(GraphReader(graph, Builder(), textures, log))


def surface_of(reader: GraphReader) -> SurfaceBuilder:
    """The closures of the Surface output of a reader's graph."""
    graph, log = reader.graph, reader.log
    out = SurfaceBuilder(reader.builder)
    moved = graph.outputs.get("Displacement")
    if moved is not None:
        reader.surface_normal = displaced_normal(reader, moved)
        note_displacement(graph, moved, log)
    link = graph.outputs.get("Surface")
    if link is not None:
        reader.closures(link, reader.builder.one, out)
    out.only_one_transparent()
    note_other_outputs(graph, log)
    return out


def note_displacement(graph: Graph, link: Link, log: CoverageLog) -> None:
    """Say what becomes of a displacement: its shading is rendered, the surface stays where it is."""
    if not 0 <= link.node < len(graph.nodes):
        return
    name = graph.nodes[link.node].name
    log.note(name, APPROXIMATE, "heights differ over the camera pixel's footprint, after bounces too")
    if graph.displacement_method != "BUMP":
        log.note(name, IGNORED, "the surface is shaded as displaced but stays where it is")


def note_other_outputs(graph: Graph, log: CoverageLog) -> None:
    """List what hangs on the outputs that are not rendered yet, and the exporter's own notes."""
    link = graph.outputs.get("Volume")
    if link is not None and 0 <= link.node < len(graph.nodes):
        log.note(graph.nodes[link.node].name, IGNORED, "the volume is left out: clear inside")
    for node, effect in graph.notes:
        log.note(node, IGNORED, effect)


def worst_first(entries: Iterable[Coverage]) -> list[Coverage]:
    """Coverage with what is ignored before what is approximate before what is exact."""
    order = {"ignored": 0, "approximate": 1, "exact": 2}
    return sorted(entries, key=lambda e: order[e.state])
