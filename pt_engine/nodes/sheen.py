"""Sheen: the node, and the layer on top of the Principled."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import sheen as model
from .energy_nodes import cosine
from .graph import NodeView, shading_normal
from .ir import FLOAT, VECTOR, Value, op
from .math_nodes import saturate
from .normals import closure_normal
from .registry import shader
from .surface import SurfaceBuilder, is_zero
from .vector_nodes import unit

Float32 = NDArray[np.float32]


@op(FLOAT)
def left_by_sheen(color: Float32, roughness: Float32, cos: Float32) -> Float32:
    """1 − the largest component of what a sheen of some colour reflects."""
    left: Float32 = 1 - color.max(axis=0) * model.albedo(model.Params(roughness), cos)
    return np.clip(left, 0, 1)


@op(VECTOR)
def toward_coat(coat: Float32, base: Float32, over: Float32) -> Float32:
    """The base's normal, moved toward the coat's by the coat's weight."""
    return unit(base + np.clip(coat, 0, 1) * (over - base))


def sheen_normal(n: NodeView, base: Value | None) -> Value | None:
    """The normal of Principled's sheen: fibres stand on the coat as far as there is one."""
    coat = n.float("Coat Weight")
    over = base if is_zero(coat) else closure_normal(n, "Coat Normal")
    if over is base:
        return base
    pair = (n.call(shading_normal) if normal is None else normal for normal in (base, over))
    return n.call(toward_coat, coat, *pair)


def add_sheen_layer(
    n: NodeView, out: SurfaceBuilder, weight: Value, color: Value, base: Value | None
) -> Value:
    """Principled's sheen of some colour (its weight included); returns the share it leaves."""
    roughness, normal = n.call(saturate, n.float("Sheen Roughness", 0.5)), sheen_normal(n, base)
    out.add("sheen", {"roughness": roughness}, n.builder.multiply(weight, color), normal)
    return n.call(left_by_sheen, color, roughness, cosine(n, normal))


@shader("BsdfSheen")
def sheen(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    weight = n.builder.multiply(weight, n.color("Color", 0.8))
    roughness = n.call(saturate, n.float("Roughness", 1.0))
    if n.prop("distribution", "MICROFIBER") == "ASHIKHMIN":
        out.add("velvet", {"sigma": roughness}, weight, closure_normal(n))
    else:
        out.add("sheen", {"roughness": roughness}, weight, closure_normal(n))
