"""Reading a flat shader graph into values and closures, from the output backwards."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

from ..scene.snapshot import Graph, Link, Node
from . import coverage
from .followed import followed_coordinates
from .ir import COLOR, FLOAT, VECTOR, Builder, Const, Op, Static, Value, lane_op
from .registry import NODES, SHADERS

if TYPE_CHECKING:
    from ..textures.images import TextureStore
    from .sky_nodes import SunDisc
    from .surface import SurfaceBuilder

Number: TypeAlias = float  # `NodeView.float` hides the type of that name
MAX_DEPTH = 200  # links in a chain; deeper graphs than any artist's are cut with a note
BENDERS = {"Bump", "NormalMap", "Bevel"}  # None as their Normal is the surface's, which they leave as it is


@lane_op(VECTOR)
def shading_normal(lanes: Any) -> Any:
    """Interpolated normal, on the viewer's side."""
    return lanes.ns


class GraphReader:
    """Compiles a graph's nodes on demand, each once.

    Attributes
    ----------
    builder : Builder
    textures : TextureStore
    log : CoverageLog
    world : bool
        Whether the graph is a world's (some nodes mean something else there).
    draw_suns : bool
        Whether sky textures draw their suns.
    suns : list of SunDisc
        The suns that were drawn so far.
    """

    def __init__(
        self,
        graph: Graph,
        builder: Builder,
        textures: TextureStore,
        log: coverage.CoverageLog,
        world: bool = False,
        draw_suns: bool = True,
    ) -> None:
        self.draw_suns = draw_suns
        self.suns: list[SunDisc] = []
        self.graph, self.builder, self.textures, self.log, self.world = graph, builder, textures, log, world
        self.surface_normal: Value | None = None  # of displacement seen as bump; None: the lanes' own
        self._outputs: dict[tuple[int, int], Mapping[str, Value | None]] = {}
        self._open: set[tuple[int, int]] = set()
        self.used = used_sockets(graph)

    @cached_property
    def followed(self) -> set[Hashable]:
        """The coordinates (`coordinates_of`) that some Bump looks at from beside its point."""
        return followed_coordinates(self.graph)

    def bend(self, normal: Value | None) -> None:
        """From now on this is the surface's normal, also for nodes that were read before it was known."""
        self.surface_normal = normal
        self._outputs.clear()

    def value(self, link: Link, shift: int) -> Value | None:
        """What a link carries; None where the node has no such output or the chain is cyclic."""
        key = (link.node, shift)
        node = self._node(link)
        if node is None:
            return None
        if key in self._open or len(self._open) >= MAX_DEPTH:
            self.log.note(
                node.name, coverage.IGNORED, "cyclic or endless links: the socket's default is used"
            )
            return None
        if key not in self._outputs:
            self._open.add(key)
            try:
                self._outputs[key] = self._compile(link.node, node, shift)
            finally:
                self._open.discard(key)
        outputs = self._outputs[key]
        if link.socket not in outputs:
            effect = f"output {link.socket} is not understood: the socket's default is used"
            self.log.note(node.name, coverage.IGNORED, effect)
        return outputs.get(link.socket)

    def carried(self, link: Link, shift: int) -> Value | None:
        """The same for sockets without a normal of their own: one that stays as it is is a value to them."""
        value, node = self.value(link, shift), self._node(link)
        if value is None and node is not None and node.kind in BENDERS and link.socket == "Normal":
            return self.builder.call(shading_normal, shift=shift)[0]
        return value

    def _node(self, link: Link) -> Node | None:
        return self.graph.nodes[link.node] if 0 <= link.node < len(self.graph.nodes) else None

    def _compile(self, number: int, node: Node, shift: int) -> Mapping[str, Value | None]:
        function = NODES.get(node.kind)
        if function is None:
            effect = f"{node.kind} is not understood: its links carry their sockets' defaults"
            self.log.note(node.name, coverage.IGNORED, effect)
            return dict.fromkeys(self.used.get(number, ()))
        outputs = function(NodeView(self, number, node, shift))
        self.log.note(node.name, coverage.EXACT)
        return outputs

    def closures(self, link: Link, weight: Value, out: SurfaceBuilder) -> None:
        """Add the closures behind a shader link, each weighted by `weight`."""
        node = self._node(link)
        if node is None or (isinstance(weight, Const) and weight.is_all(0)):
            return
        key = (link.node, -1)
        if key in self._open or len(self._open) >= MAX_DEPTH:
            self.log.note(node.name, coverage.IGNORED, "cyclic or endless links: black")
            return
        function = SHADERS.get(node.kind)
        if function is None:
            self.log.note(node.name, coverage.IGNORED, f"{node.kind} is not understood: black")
            return
        self._open.add(key)
        try:
            function(NodeView(self, link.node, node, 0), weight, out)
        finally:
            self._open.discard(key)
        self.log.note(node.name, coverage.EXACT)


def used_sockets(graph: Graph) -> dict[int, set[str]]:
    """Node number → outputs that some link reads."""
    used: dict[int, set[str]] = {}
    for node in graph.nodes:
        for value in node.inputs.values():
            if isinstance(value, Link):
                used.setdefault(value.node, set()).add(value.socket)
    for link in graph.outputs.values():
        used.setdefault(link.node, set()).add(link.socket)
    return used


class NodeView:
    """What a node's function sees of its node."""

    def __init__(self, reader: GraphReader, number: int, node: Node, shift: int) -> None:
        self.reader, self.number, self.node, self.shift = reader, number, node, shift
        self.builder = reader.builder

    # ---- inputs, compiled when asked for

    def linked(self, name: str) -> Link | None:
        """The link into an input, if there is one."""
        value = self.node.inputs.get(name)
        return value if isinstance(value, Link) else None

    def _input(self, name: str, kind: str, default: Any, shift: int | None = None) -> Value:
        value = self.node.inputs.get(name)
        if isinstance(value, Link):
            linked = self.reader.carried(value, self.shift if shift is None else shift)
            if linked is not None:
                return self.builder.convert(linked, kind)
            value = None
        if value is None or isinstance(value, str):
            value = default
        return self.builder.constant(value, kind)

    def float(self, name: str, default: Number = 0.0) -> Value:
        """A number."""
        return self._input(name, FLOAT, default)

    def color(self, name: str, default: Sequence[Number] | Number = 0.0) -> Value:
        """A colour."""
        return self._input(name, COLOR, default)

    def vector(self, name: str, default: Sequence[Number] | Number = 0.0) -> Value:
        """A vector."""
        return self._input(name, VECTOR, default)

    def shifted_float(self, name: str, shift: int) -> Value:
        """A number as it would be at Bump's shifted position."""
        return self._input(name, FLOAT, 0.0, shift)

    def optional(self, name: str) -> Value | None:
        """A vector if the input is linked, else None: the node then has a default of its own."""
        link = self.linked(name)
        if link is None:
            return None
        read = self.reader.value if name.endswith("Normal") else self.reader.carried
        value = read(link, self.shift)
        return None if value is None else self.builder.convert(value, VECTOR)

    def normal(self, name: str = "Normal") -> Value | None:
        """A normal input; unlinked it is the surface's, None where that is `lanes.ns`."""
        return self.optional(name) if self.linked(name) is not None else self.reader.surface_normal

    def bent(self) -> tuple[Value, ...]:
        """The surface's normal where displacement bends it: for ops that else read `lanes.ns`."""
        normal = self.reader.surface_normal
        return () if normal is None else (normal,)

    def prop(self, name: str, default: Any) -> Any:
        """A setting of the node."""
        value = self.node.props.get(name)
        return default if value is None else value

    def wants(self, output: str) -> bool:
        """Whether some link of the graph reads this output."""
        return output in self.reader.used.get(self.number, ())

    def closures(self, name: str, weight: Value, out: SurfaceBuilder) -> None:
        """Follow a shader input."""
        link = self.linked(name)
        if link is not None:
            self.reader.closures(link, weight, out)

    # ---- making values

    def calls(self, what: Op, *args: Value, static: Static = ()) -> tuple[Value, ...]:
        """All outputs of an op."""
        return self.builder.call(what, *args, static=static, shift=self.shift)

    def call(self, what: Op, *args: Value, static: Static = ()) -> Value:
        """The (first) output of an op."""
        return self.calls(what, *args, static=static)[0]

    def constant(self, value: Any, kind: str) -> Const:
        return self.builder.constant(value, kind)

    # ---- honesty

    def exact(self, effect: str) -> None:
        """Note what this node does to the image though it is as it should be."""
        self.reader.log.note(self.node.name, coverage.EXACT, effect)

    def approximate(self, effect: str) -> None:
        """Note that this node is not exact, and what that does to the image."""
        self.reader.log.note(self.node.name, coverage.APPROXIMATE, effect)

    def ignored(self, effect: str) -> None:
        """Note that this node (or a part of it) has no effect."""
        self.reader.log.note(self.node.name, coverage.IGNORED, effect)
