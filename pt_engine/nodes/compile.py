"""From a snapshot's graphs to batches: read, fold, group by structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..scene.snapshot import Graph, ImageData
from ..textures.images import TextureStore
from . import catalogue as catalogue  # fills the registry
from .batch import Batch, Plan, plan
from .coverage import APPROXIMATE, IGNORED, Coverage, CoverageLog
from .displacement import displaced_normal, displacement_entry, moves_vertices
from .graph import GraphReader
from .ir import Builder
from .light_path import BOUNCE_KIND, tells_shadow_rays
from .normals import surface_normal
from .probe import mean_emission
from .program import Entry, ordered_calls
from .ray_portal import lets_light_through
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
    displacement : dict of Entry
        Programs of the materials that move vertices, by material.
    keeps_normals : set of int
        Of these, those whose displacement is shaded as well (BOTH).
    """

    batch_of: NDArray[np.int32]
    batches: list[Batch]
    emission_constant: Float32
    emission_varies: NDArray[np.bool_]
    coverage: list[Coverage] = field(default_factory=list)
    displacement: dict[int, Entry] = field(default_factory=dict)
    keeps_normals: set[int] = field(default_factory=set)

    @property
    def emits(self) -> NDArray[np.bool_]:
        """(M,) which materials shine, or may."""
        return np.asarray(self.emission_varies | (self.emission_constant != 0).any(axis=1))

    @property
    def needs(self) -> frozenset[str]:
        """Lane attributes that some batch reads."""
        return frozenset(name for b in self.batches for name in b.needs)


def compile_materials(
    graphs: Sequence[Graph],
    images: Sequence[ImageData] = (),
    ocio_config: str = "",
    textures: TextureStore | None = None,
) -> Materials:
    """Compile `Snapshot.materials`; `images` and `ocio_config` are the snapshot's too, or in `textures`."""
    textures = textures or TextureStore(images, ocio_config)
    coverage: list[Coverage] = []
    members: dict[Plan, list[int]] = {}
    constants: dict[int, list[Float32]] = {}
    displacement: dict[int, Entry] = {}
    for number, graph in enumerate(graphs):
        log = CoverageLog(graph.name)
        surface = read_surface(graph, textures, log)
        key, constants[number] = plan(surface)
        members.setdefault(key, []).append(number)
        moves = read_displacement(graph, textures, log)
        if moves is not None:
            displacement[number] = moves
        coverage += log.entries()
    batches = [Batch(key, [constants[m] for m in materials], materials) for key, materials in members.items()]
    materials = _collect(len(graphs), batches, coverage)
    materials.displacement = displacement
    materials.keeps_normals = {m for m in displacement if graphs[m].displacement_method == "BOTH"}
    return materials


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
    if moved is not None and graph.displacement_method != "DISPLACEMENT":
        reader.bend(displaced_normal(reader, moved))
        out.base = surface_normal(reader)
    link = graph.outputs.get("Surface")
    if link is not None:
        reader.closures(link, reader.builder.one, out)
    out.only_one_transparent()
    if lets_light_through(out):
        effect = "emitters behind count about once; Cycles counts those with a size twice where the two mix"
        log.note("(portal with transparency)", APPROXIMATE, effect)
    note_other_outputs(graph, log)
    note_emission_by_bounce(graph, out, log)
    note_emission_seen_through(graph, out, log)
    return out


def note_emission_by_bounce(graph: Graph, out: SurfaceBuilder, log: CoverageLog) -> None:
    """Say what becomes of light that depends on how the surface it falls on scatters."""
    calls = ordered_calls([] if out.emission is None else [out.emission])
    if any(BOUNCE_KIND in call.op.reads(*call.static) for call in calls):
        log.note(graph.name, APPROXIMATE, "where the light is sampled, all rays count as diffuse ones")


def note_emission_seen_through(graph: Graph, out: SurfaceBuilder, log: CoverageLog) -> None:
    """Say that light from behind an emitter, which shadow rays alone let pass, depends on the sampler.

    Sampled emitters there count, emitters met by the scattered ray do not, so that their mix is the choice of
    MIS weights: Cycles' own picture changes by a tenth with the material's Emission Sampling.
    """
    clear = [] if out.emission is None or out.transparency is None else ordered_calls([out.transparency])
    if any(tells_shadow_rays(call) for call in clear):
        effect = "it shines and only shadow rays pass: light from behind counts by how often it is sampled"
        log.note(graph.name, APPROXIMATE, effect)


def read_displacement(graph: Graph, textures: TextureStore, log: CoverageLog) -> Entry | None:
    """The program that moves the vertices of a material's surfaces, if it does."""
    if not moves_vertices(graph):
        return None
    return displacement_entry(GraphReader(graph, Builder(), textures, log), graph.outputs["Displacement"])


def note_other_outputs(graph: Graph, log: CoverageLog) -> None:
    """List what hangs on the outputs that are not rendered yet, and the exporter's own notes."""
    link = graph.outputs.get("Volume")
    if link is not None and 0 <= link.node < len(graph.nodes):
        log.note(graph.nodes[link.node].name, IGNORED, "the volume is left out: clear inside")
    for node, effect in graph.notes:
        log.note(node, IGNORED, effect)
