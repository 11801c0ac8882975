"""Which coordinates Bump follows: those that its height comes from, read beside the point as well as at it.

To Cycles all Texture Coordinate nodes of the same settings are one node, and so are those that textures
without a link have. What it does for a Bump that follows that node, every reader of it gets.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import Any

from ..scene.snapshot import Graph, Link, Node

PLAIN = (False, None)  # coordinates of neither an instancer nor another object
TEXTURES = {"TexImage", "TexSky", "TexGradient", "TexNoise", "TexGabor", "TexVoronoi", "TexWave"}
TEXTURES |= {"TexMagic", "TexChecker", "TexBrick"}  # these have plain ones where they have no Vector


def coordinates_of(node: Node) -> Hashable:
    """What Texture Coordinate nodes must have in common to be one."""
    matrix: Any = node.props.get("object_matrix")
    return bool(node.props.get("from_instancer")), None if matrix is None else tuple(matrix)


def followed_coordinates(graph: Graph) -> set[Hashable]:
    """The coordinates (`coordinates_of`) that the heights of a graph's Bumps come from."""
    bumps = [node for node in nodes_behind(graph, graph.outputs.values()) if node.kind == "Bump"]
    heights = [h for h in (bump.inputs.get("Height") for bump in bumps) if isinstance(h, Link)]
    nodes = nodes_behind(graph, heights)
    followed = {coordinates_of(node) for node in nodes if node.kind == "TexCoord"}
    if any(node.kind in TEXTURES and node.inputs.get("Vector") is None for node in nodes):
        followed.add(PLAIN)
    return followed


def nodes_behind(graph: Graph, links: Iterable[Link]) -> list[Node]:
    """The nodes that these links come from, at whatever distance."""
    return [graph.nodes[k] for k in sorted(behind(graph, links))]


def behind(graph: Graph, links: Iterable[Link]) -> set[int]:
    """Their numbers."""
    found: set[int] = set()
    ahead = [link.node for link in links]
    while ahead:
        number = ahead.pop()
        if number not in found and 0 <= number < len(graph.nodes):
            found.add(number)
            ahead += [v.node for v in graph.nodes[number].inputs.values() if isinstance(v, Link)]
    return found
