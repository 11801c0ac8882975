"""Nodes whose output is the same everywhere: Value, RGB, Scene Time."""

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


@node("SceneTime")
def scene_time(n: NodeView) -> Outputs:
    """The frame that is rendered, and its time."""
    return {name.title(): n.constant(n.prop(name, 0.0), FLOAT) for name in ("frame", "seconds")}
