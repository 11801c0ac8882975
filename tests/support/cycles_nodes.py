"""One node's output in Cycles, on sheets of faces (see `parity.sheets`) whose attributes a test chooses.

Face attributes A, B, C, D (vectors) feed the sockets that a case names; the others keep their values.
"""

import bpy
import numpy as np
from support.bpy_nodes import with_nodes
from support.parity.sheets import SIDE, cut, place, render, sheet

__all__ = ["SIDE", "cut", "feed", "inputs", "material", "place", "render", "sheet"]
NAMES = ("A", "B", "C", "D")


def inputs(seed, low=-2.0, high=2.0):
    """(3, n) inputs of the four attributes: random, with zeros, ones and negatives among them."""
    rng = np.random.default_rng(seed)
    n = SIDE * SIDE
    table = {}
    for k, name in enumerate(NAMES):
        values = rng.uniform(low, high, (3, n)).astype(np.float32)
        special = np.array([0, 1, -1, 0.5, 2], np.float32)
        values[:, k::11] = rng.choice(special, (3, len(range(k, n, 11))))
        table[name] = values
    return table


def material(name, kind, settings, links, output):
    """A material that shines with an output of a node; `links`: socket identifier → source as in `feed`."""
    made = bpy.data.materials.new(name)
    tree = with_nodes(made)
    node = tree.nodes.new("ShaderNode" + kind)
    for key, value in settings.items():
        if callable(value):
            value(node)
        else:
            setattr(node, key, value)
    for socket in node.inputs:
        if socket.identifier in links:
            feed(tree, socket, links[socket.identifier])
    shine, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    source = next(s for s in node.outputs if s.identifier == output)
    tree.links.new(source, shine.inputs["Color"])
    tree.links.new(shine.outputs[0], end.inputs["Surface"])
    return made


def feed(tree, socket, source):
    """Link a socket to an attribute's vector (`"A"`) or component (`"A.x"`), or set a constant."""
    if not isinstance(source, str):
        socket.default_value = source
        return
    name, _, axis = source.partition(".")
    attribute = tree.nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = name
    vector = attribute.outputs["Vector"]
    if axis:
        split = tree.nodes.new("ShaderNodeSeparateXYZ")
        tree.links.new(vector, split.inputs[0])
        vector = split.outputs["xyz".index(axis)]
    tree.links.new(vector, socket)
