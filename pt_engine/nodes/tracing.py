"""Reading a graph while keeping track of which node asked for what: for explanations, not for rendering."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..scene.snapshot import Graph, Link, Node
from ..textures.images import TextureStore
from .coverage import CoverageLog
from .graph import GraphReader
from .ir import Builder, Call, Const, Op, Result, Static, Value
from .registry import SHADERS
from .surface import SurfaceBuilder


@dataclass
class Trace:
    """What each node of a graph came to.

    Attributes
    ----------
    calls : dict of str to list of Call
        Per node the calls that it made or found already made.
    folded : dict of str to int
        Per node how many calls were carried out at once because their arguments were constants.
    visited : set of str
        Nodes that something asked for.
    """

    calls: dict[str, list[Call]] = field(default_factory=dict)
    folded: dict[str, int] = field(default_factory=dict)
    visited: set[str] = field(default_factory=set)

    def askers(self, call: Call) -> list[str]:
        """The nodes that share a call."""
        return [name for name, calls in self.calls.items() if any(c is call for c in calls)]


class TracingBuilder(Builder):
    """Notes who asks for a call; `asking` has the nodes that are being read, the innermost last."""

    def __init__(self) -> None:
        self.trace = Trace()
        self.asking: list[str] = ["(surface)"]
        super().__init__()

    def call(self, what: Op, *args: Value, static: Static = (), shift: int = 0) -> tuple[Value, ...]:
        made = super().call(what, *args, static=static, shift=shift)
        name = self.asking[-1]
        if isinstance(made[0], Result):
            calls = self.trace.calls.setdefault(name, [])
            if not any(call is made[0].call for call in calls):
                calls.append(made[0].call)
        elif isinstance(made[0], Const):
            self.trace.folded[name] = self.trace.folded.get(name, 0) + 1
        return made


class TracingReader(GraphReader):
    """A reader whose builder knows which node it is reading."""

    def __init__(self, graph: Graph, textures: TextureStore, log: CoverageLog) -> None:
        self.tracing = TracingBuilder()
        super().__init__(graph, self.tracing, textures, log)

    def _compile(self, number: int, node: Node, shift: int) -> Mapping[str, Value | None]:
        self._enter(node)
        try:
            return super()._compile(number, node, shift)
        finally:
            self.tracing.asking.pop()

    def closures(self, link: Link, weight: Value, out: SurfaceBuilder) -> None:
        node = self._node(link)
        known = node is not None and node.kind in SHADERS
        if node is not None and known:
            self._enter(node)
        try:
            super().closures(link, weight, out)
        finally:
            if known:
                self.tracing.asking.pop()

    def _enter(self, node: Node) -> None:
        self.tracing.asking.append(node.name)
        self.tracing.trace.visited.add(node.name)
