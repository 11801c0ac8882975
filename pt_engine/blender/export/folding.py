"""Values that a group node hides: whether the socket inside gets them, or behaves as unlinked.

Blender 5 folds a node whose inputs are all constants before it hands a tree to Cycles, and then a hidden
value is a constant like any other: a Noise in a group whose hidden Vector is unlinked is flat, at (0, 0, 0).
If one of its inputs varies, it is not folded, and its coordinates are the Generated ones.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from ...scene.snapshot import Link, Node

NAMES = (
    "Blackbody Clamp CombineXYZ FloatCurve Gamma MapRange Math Mix MixRGB RGBCurve RadialTiling SeparateXYZ "
    "TexBrick TexChecker TexGabor TexGradient TexMagic TexNoise TexVoronoi TexWave TexWhiteNoise ValToRGB "
    "Value VectorCurve VectorMath VectorRotate"
)
FOLDED = frozenset(NAMES.split())


class Hidden(NamedTuple):
    """A constant that neither its group node nor the socket it reaches shows."""

    value: object


def with_hidden_values(nodes: tuple[Node, ...]) -> tuple[Node, ...]:
    """Nodes, each after what feeds it, with every `Hidden` input settled: its value, or None."""
    if not any(isinstance(value, Hidden) for node in nodes for value in node.inputs.values()):
        return nodes
    folded: list[bool] = []
    settled = []
    for node in nodes:
        folds = node.kind in FOLDED and all(is_constant(value, folded) for value in node.inputs.values())
        folded.append(folds)
        inputs = {
            name: (value.value if folds else None) if isinstance(value, Hidden) else value
            for name, value in node.inputs.items()
        }
        settled.append(replace(node, inputs=inputs))
    return tuple(settled)


def is_constant(value: object, folded: list[bool]) -> bool:
    """Whether an input is known before any point is shaded."""
    return folded[value.node] if isinstance(value, Link) else value is not None
