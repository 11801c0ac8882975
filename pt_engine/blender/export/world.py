"""The world: its node tree, or a background of its colour."""

from __future__ import annotations

from ...scene.snapshot import Graph, Link, Node, Visibility
from .materials import tree_graph

RAY_KINDS = {
    "camera": Visibility.CAMERA,
    "diffuse": Visibility.DIFFUSE,
    "glossy": Visibility.GLOSSY,
    "transmission": Visibility.TRANSMISSION,
    "scatter": Visibility.VOLUME,
}


def export_world(scene, view_layer, depsgraph, images) -> Graph | None:
    """The graph of the evaluated world; None where there is none or the view layer leaves it out."""
    world = world_of(scene, view_layer)
    if world is None or not view_layer.use_sky:
        return None
    if not world.is_evaluated:
        world = world.evaluated_get(depsgraph)
    graph = tree_graph(world, world.name, images, "from_world")
    return background(world) if graph is None else graph


def world_of(scene, view_layer):
    """The view layer's own world, or the scene's."""
    return getattr(view_layer, "world_override", None) or scene.world


def world_visibility(scene, view_layer) -> int:
    """`Visibility` bits of the world."""
    seen = getattr(world_of(scene, view_layer), "cycles_visibility", None)
    hidden = [bit for kind, bit in RAY_KINDS.items() if not getattr(seen, kind, True)]
    return Visibility.ALL & ~sum(hidden)


def background(world) -> Graph:
    """One Background of the world's viewport colour."""
    node = Node("Background", "Background", {"Color": (*world.color, 1.0), "Strength": 1.0})
    return Graph(world.name, (node,), {"Surface": Link(0, "Background")})
