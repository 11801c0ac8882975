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
OTHERWISE = {"Blackbody", "RGBToBW", "ValToRGB"}  # folded, they are not quite what Cycles computes
BLENDERS_OWN = {"folded_curves", "folded_clip"}  # settings that Cycles does not know
CYCLES_OWN = {"texture_mapping"}  # and one that Blender does not fold by
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
    """Nodes, each after what feeds it, with all that depends on folding decided."""
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
    """The settings by which a node is computed; `folded` if Blender does it, and otherwise than Cycles."""
    foreign = CYCLES_OWN if folds else BLENDERS_OWN
    own = {name: value for name, value in node.props.items() if name not in foreign}
    return own | {"folded": True} if folds and node.kind in OTHERWISE else own


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
