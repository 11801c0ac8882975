"""Materials, worlds' and lights' trees: which tree counts, and the table that numbers the materials."""

from __future__ import annotations

from dataclasses import replace

import bpy

from ...scene.snapshot import Graph, Link, Node
from .node_tree import flatten, understood

BLENDER_5 = bpy.app.version >= (5, 0, 0)
DEFAULT_GREY = (0.8, 0.8, 0.8, 1.0)


class MaterialTable:
    """Numbers materials as they are met; number 0 stands in for an empty slot."""

    def __init__(self, depsgraph, images) -> None:
        self.depsgraph, self.images = depsgraph, images
        self.graphs: list[Graph] = [default_surface()]
        self._index: dict[int, int] = {}

    def index(self, material) -> int:
        """Number of a slot's material (None: 0)."""
        if material is None:
            return 0
        if not material.is_evaluated:
            material = material.evaluated_get(self.depsgraph)
        key = material.as_pointer()
        if key not in self._index:
            self._index[key] = len(self.graphs)
            self.graphs.append(export_material(material, self.images))
        return self._index[key]


def export_material(material, images) -> Graph:
    """The graph of an evaluated material; without nodes a Diffuse of its viewport colour, as in Cycles."""
    graph = tree_graph(material, material.name, images, "from_material")
    if graph is None:
        return diffuse(material.name, tuple(material.diffuse_color))
    sampling = getattr(getattr(material, "cycles", None), "emission_sampling", "AUTO")
    return replace(
        graph,
        displacement_method=material.displacement_method,
        pass_index=material.pass_index,
        sampled=sampling != "NONE",
    )


def tree_graph(owner, name: str, images, inline: str) -> Graph | None:
    """The flat graph of an ID's own tree, None where it has none or doesn't use it.

    Blender 5's zones, closures and bundles are resolved by Blender's own inliner (`inline` names its
    constructor); it folds constants and renames nodes, so only trees that need it go that way.
    """
    tree = owner.node_tree
    if tree is None or not (BLENDER_5 or owner.use_nodes):
        return None
    inliner = getattr(bpy.types, "InlineShaderNodes", None)
    if inliner is not None and not understood(tree):
        inlined = getattr(inliner, inline)(owner)  # owns the tree: keep it until it has been read
        graph = flatten(inlined.node_tree, name, images)
        return replace(graph, notes=(*graph.notes, *undefined(tree)))
    return flatten(tree, name, images)


def undefined(tree) -> list[tuple[str, str]]:
    """Notes on nodes of unknown types that feed something: the inliner leaves them out, as Cycles does."""
    found = []
    for node in tree.nodes:
        if node.bl_idname == "NodeUndefined" and any(socket.is_linked for socket in node.outputs):
            found.append((node.name, "a node of an unknown type: what it feeds keeps its own value"))
    return found


def default_surface() -> Graph:
    """What faces without a material have: Cycles 5 gives them a Principled BSDF, before it was a Diffuse."""
    if not BLENDER_5:
        return diffuse("(no material)", DEFAULT_GREY)
    inputs = {"Base Color": DEFAULT_GREY, "Roughness": 0.5, "IOR": 1.5}
    node = Node("BsdfPrincipled", "Principled BSDF", inputs)
    return Graph("(no material)", (node,), {"Surface": Link(0, "BSDF")})


def diffuse(name: str, color) -> Graph:
    """One Diffuse BSDF."""
    node = Node("BsdfDiffuse", "Diffuse BSDF", {"Color": color, "Roughness": 0.0, "Normal": None})
    return Graph(name, (node,), {"Surface": Link(0, "BSDF")})
