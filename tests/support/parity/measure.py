"""Ours beside Cycles', case by case.

"Exact" is |ours − Cycles| ≤ 1e-4·(|Cycles| + 0.01). Where a pixel is not, it is *torn*, not wrong, if
Cycles' value lies among ours of inputs at most four units in the last place away: a jump, a cell's border,
cancellation; and on hostile faces if it is no further away than such a unit of the largest input. What is
not finite counts as 0, as in Cycles' film.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray
from support.bpy_scenes import empty_scene
from support.node_lanes import NodeLanes

from pt_engine.blender.export.images import ImageTable
from pt_engine.blender.export.materials import export_material
from pt_engine.nodes.batch import Batch
from pt_engine.nodes.compile import compile_materials
from pt_engine.nodes.coverage import EXACT

from . import sheets
from .cases import Case
from .sweeps import EXTREME, HOSTILE, ORDINARY, TRIES, Table, jittered, sweep

Float32 = NDArray[np.float32]
TOLERANCE = 1e-4
HOSTILE_SHARE = 0.04  # of hostile faces that may be wrong
# the width of a polygon of two sides is tan(π/2), as the processor's tangent rounds it: 5 faces of 96
POLES = {("RadialTiling", "Segment Width"): 0.06}
AT_ONCE = 400  # sheets of one picture


@dataclass(frozen=True)
class Finding:
    """How a case came out.

    Attributes
    ----------
    state, effect : str
        What the coverage says: the worst of the material's nodes.
    reads : frozenset of str
        Ops that look at the scene: no sheet can tell whether they are right.
    theirs, ours : (3, n) float32
    error : (n,) float64
        |ours − Cycles| / (|Cycles| + 0.01), the largest of the three channels.
    torn : (n,) bool
        Beyond the tolerance, but among the values of neighbouring inputs.
    """

    case: Case
    state: str
    effect: str
    reads: frozenset[str]
    theirs: Float32
    ours: Float32
    error: NDArray[np.float64]
    torn: NDArray[np.bool_]
    table: Table

    @property
    def wrong(self) -> NDArray[np.bool_]:
        """(n,) beyond the tolerance and not torn."""
        return ~(self.error <= TOLERANCE) & ~self.torn

    @property
    def is_exact(self) -> bool:
        """Whether no ordinary face is wrong, and of the hostile ones next to none.

        A few are let pass: where sines of sines are fed a distortion of 1000, no float32 is right.
        """
        share = POLES.get((self.case.kind, self.case.output), HOSTILE_SHARE)
        return not self.wrong[ORDINARY].any() and self.wrong[HOSTILE].mean() <= share

    def __str__(self) -> str:
        face = int(np.where(self.wrong, np.minimum(self.error, 1e30), -1)[: HOSTILE.stop].argmax())
        values = {key: values[:, face].tolist() for key, values in self.table.items()}
        counts = [int(self.wrong[part].sum()) for part in (ORDINARY, HOSTILE, EXTREME)]
        return (
            f"{counts} ordinary, hostile, extreme faces differ; number {face} by {self.error[face]:.2g}: "
            f"{self.ours[:, face]} instead of {self.theirs[:, face]} of {values}"
        )


def measured(every: Sequence[Case]) -> list[Finding]:
    """Findings of all cases, a few hundred to a render."""
    parts = [every[k : k + AT_ONCE] for k in range(0, len(every), AT_ONCE)]
    return [finding for part in parts for finding in _measured(part)]


def _measured(part: Sequence[Case]) -> list[Finding]:
    empty_scene()
    tables, materials = [], []
    for number, case in enumerate(part):
        material, fed = sheets.material(case)
        tables.append(sweep(case.name, fed))
        owner = sheets.sheet(case.name, tables[-1], *sheets.place(number, len(part)))
        owner.data.materials.append(material)
        materials.append(material)
    picture = sheets.render(len(part))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    images = ImageTable([])
    graphs = [export_material(m.evaluated_get(depsgraph), images) for m in materials]
    return [
        finding(case, graph, table, sheets.cut(picture, number, len(part)))
        for number, (case, graph, table) in enumerate(zip(part, graphs, tables, strict=True))
    ]


def finding(case: Case, graph, table: Table, theirs: Float32) -> Finding:
    """Compile a case's material alone and compare."""
    compiled = compile_materials([graph])
    (batch,) = compiled.batches
    state, effect = worst(compiled.coverage)
    theirs, ours = blackened(theirs), blackened(values(batch, table, theirs.shape[1]))
    error = (np.abs(ours.astype(np.float64) - theirs) / (np.abs(theirs) + 0.01)).max(axis=0)
    torn = np.zeros(error.shape, bool)
    faces = np.flatnonzero(~(error <= TOLERANCE))
    reads = looks(batch, table)
    if faces.size and table and not reads:
        near = values(batch, jittered(table, faces), faces.size * TRIES).reshape(3, faces.size, TRIES)
        torn[faces] = among(theirs[:, faces], near, ours[:, faces])
    if table:
        torn[HOSTILE.start :] |= (~(error <= TOLERANCE) & rounded(theirs, ours, table))[HOSTILE.start :]
    return Finding(case, state, effect, reads, theirs, ours, error, torn, table)


def worst(coverage) -> tuple[str, str]:
    """The worst state, and its effect."""
    for entry in sorted(coverage, key=lambda e: ("ignored", "approximate", EXACT).index(e.state)):
        return entry.state, entry.effect
    return EXACT, ""


def values(batch: Batch, table: Table, n: int) -> Float32:
    """(3, n) our values."""
    ours = batch.emission(NodeLanes(n=n, colors=table))
    return np.broadcast_to(np.zeros((3, 1), np.float32) if ours is None else ours, (3, n))


def blackened(values: Float32) -> Float32:
    """What is not finite as 0, channel by channel, as Cycles' film has it."""
    return np.where(np.isfinite(values), values, np.float32(0))


def among(theirs: Float32, near: Float32, ours: Float32) -> NDArray[np.bool_]:
    """Whether values lie within the range of those of neighbouring inputs, up to the tolerance."""
    with np.errstate(all="ignore"):
        both = np.concatenate([blackened(near), ours[..., np.newaxis]], axis=-1).astype(np.float64)
    room = TOLERANCE * (np.abs(theirs) + 0.01)
    return ((both.min(axis=-1) - room <= theirs) & (theirs <= both.max(axis=-1) + room)).all(axis=0)


def rounded(theirs: Float32, ours: Float32, table: Table) -> NDArray[np.bool_]:
    """Whether values are as close as the rounding of a sum with the largest of a face's inputs."""
    largest = np.max([np.abs(values).max(axis=0) for values in table.values()], axis=0).astype(np.float64)
    return (np.abs(ours.astype(np.float64) - theirs) <= 4 * 2.0**-23 * largest).all(axis=0)


def looks(batch: Batch, table: Table) -> frozenset[str]:
    """Ops of a program that look at more of the lanes than the sheet's attributes."""
    steps = batch.plan.structure.steps
    return frozenset(s.op.name for s in steps if s.op.lanes and not (s.static and s.static[0] in table))
