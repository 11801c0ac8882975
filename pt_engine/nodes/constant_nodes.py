"""Nodes whose output is their setting: Value, RGB."""

from __future__ import annotations

from .graph import NodeView
from .ir import COLOR, FLOAT
from .registry import Outputs, node


@node("Value")
def value_node(n: NodeView) -> Outputs:
    return {"Value": n.constant(n.prop("value", 0.0), FLOAT)}


@node("RGB")
def rgb_node(n: NodeView) -> Outputs:
    return {"Color": n.constant(n.prop("value", (0.5, 0.5, 0.5)), COLOR)}
