"""A Blender shader tree, however nested, as one flat `Graph`.

Groups of any depth, reroutes, muted nodes and muted links are resolved as Blender 5 resolves them:

- a muted node hands on what reaches the input its internal link names; where nothing does, the socket it
  feeds (also that of a group) keeps its own value, and so it is behind an unlinked reroute (before Blender 5
  it gets 0);
- an unlinked input of a group hands in the value on the group node; where that and the socket inside hide
  their values, the socket inside behaves as unlinked (a texture uses its default coordinates), unless the
  node is folded (see `folding`);
- a shader in the place of a value counts for nothing: the socket that it reaches keeps its own value, and
  so does one behind a node that neither Cycles nor we know;
- a socket on the way that is narrower than what passes (a colour through a float input of a group)
  converts constants and what a folded node has computed, but not other links, so ordinary nodes that do the
  same are put in: Color to BW, a dot product, a truncation (before Blender 5: whatever passes);
- a colour or value plugged into a shader socket becomes an emission of strength 1, as in Cycles.

Sockets are keyed by `identifier`, which unlike the name is unique: the Mix node has ``Factor_Float``,
``A_Color``, ``Result_Color`` ..., the second input of Math is ``Value_001``. Every input socket is there,
also those the node's mode doesn't use; links into unused ones are dropped.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

from ...nodes import catalogue  # noqa: F401  (fills the registry)
from ...nodes.registry import NODES
from ...scene.snapshot import Graph, Link, Node
from .conversions import BLENDER_5, Feed, along, constant_of, converted, own_value, passed_through
from .folding import CONVERSION, Hidden, IfFolded, settled
from .node_props import node_props

GROUPS = {"ShaderNodeGroup", "ShaderNodeCustomGroup"}
STRUCTURAL = GROUPS | {"NodeReroute", "NodeGroupInput", "NodeGroupOutput", "NodeFrame"}
OF_OTHER_TREES = {"GeometryNodeInputSceneTime": "SceneTime"}  # what the inliner leaves of them
UNKNOWN_TO_CYCLES = {"ShaderNodeSqueeze", "ShaderNodeUVAlongStroke"}
LONGEST_CHAIN = 100_000
OUTPUT_SOCKETS = ("Surface", "Volume", "Displacement")


@dataclass
class Scope:
    """A tree together with the group node through which it is seen."""

    tree: object
    group: object = None
    outer: Scope | None = None
    feeds: dict = field(default_factory=dict)
    inner: dict = field(default_factory=dict)

    def __post_init__(self):
        for link in self.tree.links:
            if counts(link) and not link.is_muted and not link.to_socket.is_unavailable:
                self.feeds[link.to_socket.as_pointer()] = (link.from_node, link.from_socket)

    @property
    def path(self) -> str:
        return "" if self.group is None else f"{self.outer.path}{self.group.name}/"

    @property
    def key(self):
        return () if self.group is None else (*self.outer.key, self.group.as_pointer())

    def into(self, group) -> Scope:
        """The scope inside a group node of this tree."""
        pointer = group.as_pointer()
        if pointer not in self.inner:
            self.inner[pointer] = Scope(group.node_tree, group, self)
        return self.inner[pointer]


def counts(link) -> bool:
    """Whether a link hands something on: since Blender 5 also a shader into a group's value socket."""
    into_value = link.from_socket.type == "SHADER" and link.to_socket.type != "SHADER"
    return link.is_valid or (BLENDER_5 and into_value)


def flatten(tree, name: str, images, target: str = "CYCLES") -> Graph:
    """The part of a tree that its active output sees.

    Parameters
    ----------
    tree : bpy.types.ShaderNodeTree
        Of an evaluated material, world or light.
    images : ImageTable
    """
    return Flattener(tree, name, images).run(target)


def understood(tree) -> bool:
    """Whether a tree has only shader nodes and what `flatten` resolves (no zones, closures, bundles)."""
    pending, seen = [tree], set()
    while pending:
        current = pending.pop()
        if current is None or current.as_pointer() in seen:
            continue
        seen.add(current.as_pointer())
        for node in current.nodes:
            if node.bl_idname in GROUPS:
                pending.append(node.node_tree)
            elif node.bl_idname not in STRUCTURAL and not node.bl_idname.startswith("ShaderNode"):
                return False
    return True


class Flattener:
    """Walks from the output backwards; each (group path, node) becomes one `Node`."""

    def __init__(self, tree, name, images) -> None:
        self.name, self.images = name, images
        self.root = Scope(tree)
        self.nodes: list[Node] = []
        self.notes: list[tuple[str, str]] = []
        self.number: dict = {}
        self.pending: deque = deque()

    def run(self, target: str) -> Graph:
        scope, output = active_output(self.root, target)
        outputs: dict[str, Link] = {}
        for socket in output.inputs if output is not None else ():
            if socket.identifier in OUTPUT_SOCKETS:
                feed = converted(self, self.feed(scope, socket), socket.type)
                if feed is not None and feed.link is not None:
                    outputs[socket.identifier] = feed.link
        while self.pending:
            scope, node, number = self.pending.popleft()
            self.nodes[number] = self.translate(scope, node)
        nodes, outputs = in_order(self.nodes, outputs, self.notes)
        nodes, outputs = in_order(settled(nodes), outputs, [])  # without what has lost its readers
        return Graph(self.name, nodes, outputs, tuple(dict.fromkeys(self.notes)))

    def translate(self, scope, node) -> Node:
        inputs = {socket.identifier: self.input(scope, socket) for socket in node.inputs}
        return Node(kind_of(node), scope.path + node.name, inputs, node_props(node, self.images))

    def input(self, scope, socket):
        """A link, the constant that arrives, or the socket's own value."""
        feed = self.feed(scope, socket)
        value = self.arrived(feed, socket)
        if feed is None or not feed.way:
            return value
        stepwise = self.arrived(along(self, feed, feed.way), socket)
        return value if stepwise == value else IfFolded(feed.link, stepwise, value)

    def arrived(self, feed, socket):
        """What a socket makes of its feed."""
        feed = converted(self, feed, socket.type)
        if feed is None:
            return own_value(socket)
        if feed.hidden and socket.hide_value:
            return Hidden(feed.constant, own_value(socket))
        return feed.constant if feed.link is None else feed.link

    def feed(self, scope, socket) -> Feed | None:
        """What reaches an input socket; None where nothing does."""
        passed: list[str] = []  # types of the sockets on the way, nearest first
        feed = holder = None  # the last socket of a group that was passed: it has a value of its own
        bridged = False  # whether the last step was through a muted node or a reroute
        while (source := scope.feeds.get(socket.as_pointer())) is not None:
            node, out = source
            if not node.mute and node.bl_idname not in STRUCTURAL:
                if not self.is_unknown(scope, node, out):
                    feed = Feed(Link(self.add(scope, node), out.identifier), None, out.type)
                elif BLENDER_5:
                    return None
                break
            scope, beyond = step(scope, node, out)
            if beyond is None or len(passed) > LONGEST_CHAIN:
                break
            socket, bridged = beyond, node.mute or node.bl_idname == "NodeReroute"
            passed.append(socket.type)
            if not bridged:
                holder, held = socket, len(passed)
        if feed is None and bridged and not BLENDER_5:
            return Feed(None, 0.0, "VALUE")
        if feed is None and holder is not None:
            feed = constant_of(holder)
            del passed[held:]
        return passed_through(self, feed, tuple(reversed(passed)))

    def is_unknown(self, scope, node, out) -> bool:
        """Whether a node's values are nobody's: what it feeds keeps its own value."""
        if out.type == "SHADER" or kind_of(node) in NODES:
            return False
        if node.bl_idname not in UNKNOWN_TO_CYCLES:
            effect = f"{kind_of(node)} is not understood: what it feeds keeps its own value"
            self.notes.append((scope.path + node.name, effect))
        return True

    def add(self, scope, node) -> int:
        key = (scope.key, node.as_pointer())
        if key not in self.number:
            self.number[key] = self.reserve()
            self.pending.append((scope, node, self.number[key]))
        return self.number[key]

    def reserve(self) -> int:
        self.nodes.append(Node("", ""))
        return len(self.nodes) - 1

    def extra(self, kind: str, inputs: dict, props: dict | None = None) -> int:
        """A node of our own; the same one for the same input."""
        key = (kind, tuple(inputs.items()), *(props or {}).items())
        if key not in self.number:
            self.number[key] = number = self.reserve()
            self.nodes[number] = Node(kind, f"{CONVERSION}{kind})", inputs, props or {})
        return self.number[key]


def kind_of(node) -> str:
    """Our name of a node's type."""
    return OF_OTHER_TREES.get(node.bl_idname, node.bl_idname.removeprefix("ShaderNode"))


def active_output(scope, target: str):
    """The output node that Cycles renders, and its scope; else one for any engine, else EEVEE's.

    Where the tree itself has none, one inside its groups counts, as it does for Blender.
    """
    for wanted in (target, "ALL", "EEVEE"):
        node = scope.tree.get_output_node(wanted)
        if node is not None:
            return scope, node
    for group in scope.tree.nodes:
        if group.bl_idname in GROUPS and group.node_tree is not None and not group.mute:
            found = active_output(scope.into(group), target)
            if found[1] is not None:
                return found
    return scope, None


def step(scope, node, output):
    """From an output that only hands something on to the input, and its scope, that this comes from."""
    if node.mute:
        return scope, bypass(node, output)
    if node.bl_idname == "NodeReroute":
        return scope, node.inputs[0]
    if node.bl_idname in GROUPS:
        return step_in(scope, node, output)
    if scope.group is None:
        return scope, None
    return scope.outer, matching(scope.group, output)


def bypass(node, output):
    """The input that a muted node hands on to `output`."""
    for link in node.internal_links:
        if link.to_socket.as_pointer() == output.as_pointer():
            return link.from_socket
    return None


def step_in(scope, group, output):
    """Inside a group node: its scope, and the socket of the group's output node."""
    if group.node_tree is None:
        return scope, None
    ends = [node for node in group.node_tree.nodes if node.bl_idname == "NodeGroupOutput"]
    for node in sorted(ends, key=lambda node: not node.is_active_output)[:1]:
        for socket in node.inputs:
            if socket.identifier == output.identifier:
                return scope.into(group), socket
    return scope, None


def matching(group, output):
    """The socket on a group node that feeds a socket of its Group Input."""
    return next((socket for socket in group.inputs if socket.identifier == output.identifier), None)


def in_order(nodes, outputs, notes):
    """Nodes so that each comes after what feeds it; a loop is cut where it closes."""
    order: list[int] = []
    state = [0] * len(nodes)  # 1 while its inputs are being visited, 2 done
    cut: set[tuple[int, str]] = set()
    for start in [link.node for link in outputs.values()]:
        stack = [start] if state[start] == 0 else []
        while stack:
            number = stack[-1]
            if state[number] != 0:
                stack.pop()
                if state[number] == 1:
                    state[number] = 2
                    order.append(number)
                continue
            state[number] = 1
            for socket, value in nodes[number].inputs.items():
                for link in links_of(value):
                    if state[link.node] == 0:
                        stack.append(link.node)
                    elif state[link.node] == 1:
                        cut.add((number, socket))
    new = {old: position for position, old in enumerate(order)}
    result = []
    for old in order:
        node = nodes[old]
        inputs = {
            socket: None if (old, socket) in cut else renumbered(value, new)
            for socket, value in node.inputs.items()
        }
        notes.extend((node.name, f"a loop through {socket} is cut") for n, socket in cut if n == old)
        result.append(Node(node.kind, node.name, inputs, node.props))
    return tuple(result), {socket: renumbered(link, new) for socket, link in outputs.items()}


def links_of(value) -> list[Link]:
    """The links that an input is or may become."""
    return [v for v in (value if isinstance(value, IfFolded) else (value,)) if isinstance(v, Link)]


def renumbered(value, new):
    if isinstance(value, IfFolded):
        return IfFolded(*(renumbered(part, new) for part in value))
    return Link(new[value.node], value.socket) if isinstance(value, Link) else value
