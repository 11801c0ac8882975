"""A compiled material in readable lines: steps, their inputs and cost, what was folded, shared or dropped."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.snapshot import Graph, ImageData
from ..textures.images import TextureStore
from .batch import Batch, roots_of
from .compile import compile_materials, surface_of
from .coverage import CoverageLog
from .ir import Call, shift_of
from .probe import ProbeLanes, sheet
from .program import Entry, Slot, Step, ordered_calls
from .tracing import Trace, TracingReader

Float32 = NDArray[np.float32]
SIDE = 256  # of the square of lanes that costs are measured on
SHORTEST = 24  # characters of a setting


def explain(
    graphs: Sequence[Graph], number: int, images: Sequence[ImageData] = (), ocio_config: str = ""
) -> list[str]:
    """Material `number` of `Snapshot.materials` as it is compiled together with the others."""
    compiled = compile_materials(graphs, images, ocio_config)
    batch = compiled.batches[compiled.batch_of[number]]
    reader = TracingReader(graphs[number], TextureStore(images, ocio_config), CoverageLog(""))
    surface = surface_of(reader)
    calls = ordered_calls(roots_of(surface)[0])
    steps = batch.plan.structure.steps
    call_of = {step.first: call for step, call in zip(steps, calls, strict=True)}
    listing = Listing(batch, number, call_of, reader.tracing.trace)
    mates = [graphs[m].name for m in batch.materials if m != number]
    return [
        f"Material {graphs[number].name}: nodes: {len(graphs[number].nodes)}, steps: {len(steps)}",
        "",
        f"Batch: {', '.join(['alone', *mates][bool(mates) :])}",
        f"Reads of each lane: {', '.join(sorted(batch.needs)) or 'nothing by name'}",
        *nodes_lines(graphs[number], reader.tracing.trace, calls),
        *listing.lines(),
    ]


def nodes_lines(graph: Graph, trace: Trace, calls: Sequence[Call]) -> Iterator[str]:
    """What became of nodes that the program has no steps of."""
    kept = {id(call) for call in calls}
    folded, dead = [], []
    for name in sorted(trace.visited):
        made = trace.calls.get(name, [])
        if not made:
            folded.append(name)
        elif not any(id(call) in kept for call in made):
            dead.append(name)
    dead += [node.name for node in graph.nodes if node.name not in trace.visited]
    yield f"Folded to constants: {', '.join(folded) or 'no node'}"
    yield f"Dropped, no effect here: {', '.join(dead) or 'no node'}"


class Listing:
    """The steps of a batch's entries, measured, with the constants of one of its materials."""

    def __init__(self, batch: Batch, number: int, call_of: dict[int, Call], trace: Trace) -> None:
        self.batch, self.number, self.call_of, self.trace = batch, number, call_of, trace
        self.row = batch.materials.index(number)
        points = sheet(SIDE)
        self.lanes = ProbeLanes(np.full(points.shape[1], number, np.int32), points)

    def lines(self) -> Iterator[str]:
        """All of it, entry by entry."""
        for title, entry, outputs in self._entries():
            seconds = measured(entry, self.lanes)
            total = f"{1e9 * sum(seconds) / self.lanes.n:.1f} ns per lane"
            yield ""
            yield f"{title}: {len(entry.steps)} steps, {total} (one run, {self.lanes.n} lanes)"
            users = use_counts(entry)
            for step, spent in zip(entry.steps, seconds, strict=True):
                yield f"  {1e9 * spent / self.lanes.n:8.2f}  {self._step(step, users)}"
            yield from outputs(entry)

    def _entries(self) -> Iterator[tuple[str, Entry, Callable[[Entry], Iterator[str]]]]:
        batch = self.batch
        yield "Closures", batch.closure_entry, self._closures
        if batch.emission_entry is not None:
            yield "Emission", batch.emission_entry, self._single
        if batch.transparency_entry is not None:
            yield "Transparency, for shadow rays", batch.transparency_entry, self._single
        if batch.holdout_entry is not None:
            yield "Holdout, for the film's alpha", batch.holdout_entry, self._single

    def _closures(self, entry: Entry) -> Iterator[str]:
        if not self.batch.plan.closures:
            yield "  none"
        for shape in self.batch.plan.closures:
            params = [f"{name}={self._slot(entry.outputs[k])}" for name, k in shape.params]
            if shape.normal >= 0:
                params.append(f"normal={self._slot(entry.outputs[shape.normal])}")
            if shape.tangent >= 0:
                params.append(f"tangent={self._slot(entry.outputs[shape.tangent])}")
            kind = " (Dirac)" if shape.dirac else ""
            weight = self._slot(entry.outputs[shape.weight])
            yield f"  closure {shape.bsdf}{kind}: weight {weight}{''.join(', ' + p for p in params)}"

    def _single(self, entry: Entry) -> Iterator[str]:
        yield f"  result {self._slot(entry.outputs[0])}"

    def _step(self, step: Step, users: dict[int, int]) -> str:
        results = ", ".join(f"v{step.first + k}" for k in range(len(step.op.types)))
        static = ", ".join(short(s) for s in step.static)
        names = input_names(step)
        inputs = ", ".join(f"{n}={self._slot(s)}" for n, s in zip(names, step.args, strict=True))
        text = f"{results} = {step.op.name.strip('_')}{f'[{static}]' if static else ''}({inputs})"
        if step.shift:
            axis, width = shift_of(step.shift)
            text += f" one step along {'uv'[axis - 1]}, {width:g} pixels"
        nodes = self.trace.askers(self.call_of[step.first]) if step.first in self.call_of else []
        used = max(users.get(step.first + k, 0) for k in range(len(step.op.types)))
        shared = f"; used {used} times" if used > 1 else ""
        return f"{text}    <- {', '.join(nodes)}{shared}"

    def _slot(self, slot: Slot) -> str:
        if not slot.constant:
            return f"v{slot.number}"
        fixed = self.batch.table.fixed[slot.number]
        if fixed is not None:
            return number_text(fixed)
        column = self.batch.table.varying[self.batch.table.column[slot.number]]
        return number_text(column[..., self.row]) + " (differs in the batch)"


def measured(entry: Entry, lanes: ProbeLanes) -> list[float]:
    """CPU seconds of each step of an entry, in one run."""
    spent: list[float] = []
    timed = entry.with_steps([_timed(step, spent) for step in entry.steps])
    with np.errstate(all="ignore"):
        timed.run(lanes)
    return spent


def _timed(step: Step, spent: list[float]) -> Step:
    def function(*args: Any) -> Any:
        started = time.thread_time()
        out = step.op.function(*args)
        spent.append(time.thread_time() - started)
        return out

    return step._replace(op=step.op.with_function(function))


def use_counts(entry: Entry) -> dict[int, int]:
    """How many steps and outputs take each result."""
    counts: dict[int, int] = {}
    for slot in [s for step in entry.steps for s in step.args] + entry.outputs:
        if not slot.constant:
            counts[slot.number] = counts.get(slot.number, 0) + 1
    return counts


def input_names(step: Step) -> list[str]:
    """The parameters of an op's function that its arguments are."""
    parameters = list(inspect.signature(step.op.function).parameters.values())[step.op.lanes :]
    names = [p.name for p in parameters if p.kind is not p.VAR_POSITIONAL]
    gates = step.op.gates
    more = len(step.static) + len(step.args) - gates - len(names)
    if more > 0:
        together = parameters[-1].name
        names += step.op.rest or ([together] if more == 1 else [f"{together}{k}" for k in range(more)])
    return names[len(step.static) :][: len(step.args) - gates] + ["behind"] * gates


def number_text(value: Float32) -> str:
    """A constant: one number, or three."""
    numbers = np.unique(value) if value.size > 1 and len(np.unique(value)) == 1 else np.ravel(value)
    text = " ".join(f"{x:.4g}" for x in numbers)
    return text if len(numbers) == 1 else f"({text})"


def short(setting: Any) -> str:
    """A static argument; tables and images by their kind."""
    text = setting if isinstance(setting, str) else repr(setting)
    return text if len(text) <= SHORTEST and not text.startswith("<") else type(setting).__name__
