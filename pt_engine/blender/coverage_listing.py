"""How a file is rendered, node by node: in sections, a line for each finding, and as plain data for JSON."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np

from ..nodes.coverage import EXACT, IGNORED, Coverage
from ..scene.snapshot import Link
from .words import inexact

STATES = ("exact", "approximate", "ignored")
OWN_NODES = "(conversion to "  # of the exporter (see `export.node_tree`)
NO_EFFECT = "has no effect on the image"
BLACK = "nothing is connected to it: black"
LEFT_OUT = "a part of the volume, which is left out"


class Section(NamedTuple):
    """A material, the world, a lamp's tree, or what else the file asks for; and what is known of it."""

    kind: str
    name: str
    entries: tuple[Coverage, ...]

    @property
    def exact(self) -> bool:
        """Whether all of it is."""
        return not inexact(self.entries)


def sections(snapshot, coverage) -> list[Section]:
    """Everything that is rendered, in the file's order; nodes that nothing needs are listed too.

    Parameters
    ----------
    snapshot : Snapshot
    coverage : sequence of Coverage
        Of the scene prepared from it: used materials only.
    """
    by_owner: dict[str, list[Coverage]] = {}
    for entry in coverage:
        by_owner.setdefault(entry.material, []).append(entry)
    for number in np.unique(snapshot.instances.materials):
        graph = snapshot.materials[number]
        if not graph.nodes:  # nothing that coverage could know, and seen all the same
            by_owner.setdefault(graph.name, [Coverage(graph.name, "Material Output", EXACT, BLACK)])
    owners = [("material", graph) for graph in snapshot.materials if graph.name in by_owner]
    owners += [("world", snapshot.world)] if snapshot.world is not None else []
    owners += [("light", lamp.graph) for lamp in snapshot.lights if lamp.graph is not None]
    found, told = [], set()
    for kind, graph in owners:
        if (kind, graph.name) not in told:
            told.add((kind, graph.name))
            found.append(Section(kind, graph.name, whole(graph, by_owner.get(graph.name, []))))
    names = {graph.name for _, graph in owners}
    rest = [entry for entry in coverage if entry.material not in names]
    return [*found, Section("file", "", tuple(dict.fromkeys(rest)))] if rest else found


def whole(graph, entries) -> tuple[Coverage, ...]:
    """The entries of a graph's nodes, and one for each node that was not even looked at."""
    met, of_volume = {entry.node for entry in entries}, behind(graph, "Volume")
    unused = [
        Coverage(graph.name, node.name, *((IGNORED, LEFT_OUT) if number in of_volume else (EXACT, NO_EFFECT)))
        for number, node in enumerate(graph.nodes)
        if node.name not in met
    ]
    every = [*entries, *unused]
    return tuple(e for e in every if e.state != EXACT or not e.node.startswith(OWN_NODES))


def behind(graph, output: str) -> set[int]:
    """The numbers of the nodes that one of the graph's outputs is made of."""
    found: set[int] = set()
    ahead = [graph.outputs[output]] if output in graph.outputs else []
    while ahead:
        number = ahead.pop().node
        if number not in found:
            found.add(number)
            ahead += [value for value in graph.nodes[number].inputs.values() if isinstance(value, Link)]
    return found


def totals(listed) -> Counter[str]:
    """How many entries there are of each state."""
    return Counter(entry.state for section in listed for entry in section.entries)


def text_lines(listed) -> list[str]:
    """The sections as text, what is worst first, and the totals."""
    lines = []
    for section in listed:
        title = "Also asked for" if section.kind == "file" else f"{section.kind.capitalize()} {section.name}"
        lines.append(title)
        for entry in sorted(section.entries, key=lambda e: -STATES.index(e.state)):
            place = f"{entry.material}: {entry.node}" if section.kind == "file" else entry.node
            lines.append(f"  {entry.state:11}  {place}" + (f": {entry.effect}" if entry.effect else ""))
    return [*lines, closing_line(listed)]


def closing_line(listed) -> str:
    """`12 exact, 1 approximate, 0 ignored`."""
    counts = totals(listed)
    return ", ".join(f"{counts[state]} {state}" for state in STATES)


def as_data(listed) -> dict:
    """For JSON."""
    counts = totals(listed)
    return {
        "totals": {state: counts[state] for state in STATES},
        "sections": [
            {
                "kind": section.kind,
                "name": section.name,
                "entries": [
                    {"of": e.material, "node": e.node, "state": e.state, "effect": e.effect}
                    for e in section.entries
                ],
            }
            for section in listed
        ],
    }
