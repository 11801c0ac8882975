"""The one table of node kinds: what each node of a graph turns into.

    @node("Math")
    def math_node(n: NodeView) -> Outputs: ...            values out, by socket identifier

    @shader("BsdfDiffuse")
    def diffuse(n: NodeView, weight: Value, out: SurfaceBuilder) -> None: ...       closures out

A function asks its `NodeView` for inputs, which are compiled on demand: what it does not ask for is not
reachable, is not compiled, and is not in the coverage report.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from .ir import Value

if TYPE_CHECKING:
    from .graph import NodeView
    from .surface import SurfaceBuilder

Outputs = Mapping[str, Value | None]
NodeFunction = Callable[["NodeView"], Outputs]
ShaderFunction = Callable[["NodeView", Value, "SurfaceBuilder"], None]

NODES: dict[str, NodeFunction] = {}
SHADERS: dict[str, ShaderFunction] = {}

F = TypeVar("F", bound=Callable[..., Any])


def node(*kinds: str) -> Callable[[F], F]:
    """Register a function for nodes that give values."""

    def register(function: F) -> F:
        for kind in kinds:
            NODES[kind] = function
        return function

    return register


def shader(*kinds: str) -> Callable[[F], F]:
    """Register a function for nodes that give closures."""

    def register(function: F) -> F:
        for kind in kinds:
            SHADERS[kind] = function
        return function

    return register
