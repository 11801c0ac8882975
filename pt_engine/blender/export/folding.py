"""What depends on whether Blender folds a node: hidden values, conversions on the way, how it is computed.

Blender 5 folds a node whose inputs are all constants before it hands a tree to Cycles, and then a hidden
value is a constant like any other: a Noise in a group whose hidden Vector is unlinked is flat, at (0, 0, 0).
If one of its inputs varies, it is not folded, and its coordinates are the Generated ones. And what a folded
node has computed is converted by each group's socket that it passes; a link is not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from ...scene.snapshot import Link, Node
from .conversions import BLENDER_5

NAMES = (
    "Blackbody Clamp CombineXYZ FloatCurve Gamma MapRange Math Mix MixRGB RGBCurve RadialTiling SeparateXYZ "
    "TexBrick TexChecker TexGabor TexGradient TexMagic TexNoise TexVoronoi TexWave TexWhiteNoise ValToRGB "
    "Value VectorCurve VectorMath VectorRotate"
)
FOLDED = frozenset(NAMES.split())
CURVES, MAPPING = "folded_curves", "texture_mapping"
IN_ONE_WAY = {CURVES, MAPPING}  # settings that only Blender or only Cycles looks at
FOLDED_OTHERWISE = {
    "Blackbody",
    "RGBToBW",
    "ValToRGB",
}  # than Cycles computes them: where they are, `folded` says so
CONVERSION = "(conversion to "  # begins the names of nodes that stand for a socket's conversion


class Hidden(NamedTuple):
    """A constant that neither its group node nor the socket it reaches shows, and that socket's own value."""

    value: object
    own: object = None


class IfFolded(NamedTuple):
    """What a socket gets of the node `source`: `then` if that is folded, else `otherwise`."""

    source: Link
    then: object
    otherwise: object


def settled(nodes: tuple[Node, ...]) -> tuple[Node, ...]:
    """Nodes, each after what feeds it, with every `Hidden` and `IfFolded` input and table decided."""
    depends = any(isinstance(v, Hidden | IfFolded) for node in nodes for v in node.inputs.values())
    if not depends and not any(
        node.kind in FOLDED_OTHERWISE or IN_ONE_WAY & node.props.keys() for node in nodes
    ):
        return nodes
    folded: list[bool] = []
    decided = []
    for node in nodes:
        folds = node.kind in FOLDED or node.name.startswith(CONVERSION)
        folds = folds and all(is_constant(value, folded) for value in node.inputs.values())
        folded.append(folds)
        inputs = {name: decide(value, folds, folded) for name, value in node.inputs.items()}
        decided.append(replace(node, inputs=inputs, props=settings(node, folds and BLENDER_5)))
    return tuple(decided)


def settings(node: Node, folds: bool) -> Mapping[str, object]:
    """A node's settings and how Blender folds it, if it does: the texture mapping is Cycles' alone."""
    if not folds:
        return {name: value for name, value in node.props.items() if name not in (CURVES, "folded_clip")}
    own = {name: value for name, value in node.props.items() if name != MAPPING}
    return own | {"folded": True} if node.kind in FOLDED_OTHERWISE else own


def decide(value: object, folds: bool, folded: list[bool]) -> object:
    """What an input of a node that `folds` is in the end."""
    if isinstance(value, IfFolded):
        value = value.then if folded[value.source.node] else value.otherwise
    if isinstance(value, Hidden):
        return value.value if folds else value.own
    return value


def is_constant(value: object, folded: list[bool]) -> bool:
    """Whether an input is known before any point is shaded."""
    source = value.source if isinstance(value, IfFolded) else value
    return folded[source.node] if isinstance(source, Link) else value is not None
