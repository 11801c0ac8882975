"""Node trees for tests: built in a few words, compared by what they mean."""

import bpy
from support.bpy_scenes import add, cube, export

from pt_engine.scene.snapshot import Link

BLENDER_5 = bpy.app.version >= (5, 0, 0)


def with_nodes(owner):
    """The empty node tree of a material, world or light."""
    if not BLENDER_5:
        owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree


def shining(kind, output, socket="Color"):
    """A material whose emission takes its colour or strength from an output of a node."""
    made = bpy.data.materials.new(kind)
    tree = with_nodes(made)
    source, shine, out = (
        tree.nodes.new("ShaderNode" + name) for name in (kind, "Emission", "OutputMaterial")
    )
    tree.links.new(source.outputs[output], shine.inputs[socket])
    tree.links.new(shine.outputs[0], out.inputs["Surface"])
    return made


class Tree:
    """A material's tree with a Principled BSDF, and shorthands to build on it."""

    def __init__(self, tree=None):
        self.material = bpy.data.materials.new("Test") if tree is None else None
        self.tree = with_nodes(self.material) if tree is None else tree
        if tree is None:
            self.output = self.node("OutputMaterial")
            self.bsdf = self.node("BsdfPrincipled")
            self.link(self.bsdf, 0, self.output, 0)

    def node(self, kind, **settings):
        node = self.tree.nodes.new(kind if kind.startswith(("Node", "Geometry")) else f"ShaderNode{kind}")
        for key, value in settings.items():
            setattr(node, key, value)
        return node

    def link(self, source, output, target, socket):
        return self.tree.links.new(source.outputs[output], target.inputs[socket])

    def group(self, *sockets):
        """A group with (name, direction, type) sockets: its inner Tree and a node of it here."""
        tree = bpy.data.node_groups.new("Group", "ShaderNodeTree")
        for name, direction, kind in sockets:
            tree.interface.new_socket(name, in_out=direction, socket_type=f"NodeSocket{kind}")
        inner = Tree(tree)
        inner.start, inner.end = inner.node("NodeGroupInput"), inner.node("NodeGroupOutput")
        return inner, self.node("Group", node_tree=tree)

    def export(self, mesh=None):
        mesh = mesh or cube()
        mesh.materials.clear()
        mesh.materials.append(self.material)
        add(mesh)
        snapshot = export()
        return snapshot, snapshot.materials[snapshot.instances.materials[-1, 0]]


def shape_of(graph, link=None):
    """A graph without its names and numbers, as a nested tuple: equal for graphs that mean the same."""
    if link is None:
        return {socket: shape_of(graph, start) for socket, start in graph.outputs.items()}
    node = graph.nodes[link.node]
    inputs = {
        key: shape_of(graph, value) if isinstance(value, Link) else value
        for key, value in node.inputs.items()
    }
    return node.kind, link.socket, inputs, node.props


def source(graph, kind, socket):
    """The kind of the node that feeds a socket of the only node of `kind`, or the socket's value."""
    (node,) = [node for node in graph.nodes if node.kind == kind]
    value = node.inputs[socket]
    return graph.nodes[value.node].kind if isinstance(value, Link) else value
