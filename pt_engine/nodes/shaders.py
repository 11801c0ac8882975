"""Shader nodes: what each adds to a surface. Principled has its own file."""

from __future__ import annotations

from .graph import NodeView
from .ir import COLOR, Value
from .math_nodes import saturate
from .registry import shader
from .surface import SurfaceBuilder, is_zero

# ------------------------------------------------------------------ structure


@shader("MixShader")
def mix_shader(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    b = n.builder
    t = n.call(saturate, n.float("Fac", 0.5))
    n.closures("Shader", b.multiply(weight, b.complement(t)), out)
    n.closures("Shader_001", b.multiply(weight, t), out)


@shader("AddShader")
def add_shader(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    n.closures("Shader", weight, out)
    n.closures("Shader_001", weight, out)


@shader("Emission", "Background")
def emission(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    b = n.builder
    strength = n.float("Strength", 1.0)
    if not is_zero(strength):
        out.add_emission(b.multiply(b.multiply(weight, strength), n.color("Color", 1.0)))


@shader("BsdfTransparent")
def transparent(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    out.add_transparent(n.builder.multiply(weight, n.color("Color", 1.0)))


@shader("Holdout")
def holdout(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    n.approximate("black; it cuts no hole into the film's alpha")


__all__ = ["COLOR"]
