"""The world: its node tree, or a background of its colour."""

from __future__ import annotations

from ...scene.snapshot import Graph, Link, Node
from .materials import tree_graph

RAY_KINDS = ("camera", "diffuse", "glossy", "transmission", "scatter")


def export_world(scene, view_layer, depsgraph, images, unsupported) -> Graph | None:
    """The graph of the evaluated world; None where there is none or the view layer leaves it out."""
    world = getattr(view_layer, "world_override", None) or scene.world
    if world is None or not view_layer.use_sky:
        return None
    if not world.is_evaluated:
        world = world.evaluated_get(depsgraph)
    seen = getattr(world, "cycles_visibility", None)
    hidden = [kind for kind in RAY_KINDS if seen is not None and not getattr(seen, kind, True)]
    if hidden:
        unsupported.append((f"World {world.name}", "ray visibility", f"seen by {', '.join(hidden)} rays too"))
    graph = tree_graph(world, world.name, images, "from_world")
    return background(world) if graph is None else graph


def background(world) -> Graph:
    """One Background of the world's viewport colour."""
    node = Node("Background", "Background", {"Color": (*world.color, 1.0), "Strength": 1.0})
    return Graph(world.name, (node,), {"Surface": Link(0, "Background")})
