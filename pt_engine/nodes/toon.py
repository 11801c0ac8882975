"""Toon: disks of light with a soft edge."""

from __future__ import annotations

from .graph import NodeView
from .ir import Value
from .normals import closure_normal
from .registry import shader
from .surface import SurfaceBuilder


@shader("BsdfToon")
def toon(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    params = {"size": n.float("Size", 0.5), "smooth": n.float("Smooth")}
    model = "toon" if n.prop("component", "DIFFUSE") == "DIFFUSE" else "toon_glossy"
    out.add(model, params, n.builder.multiply(weight, n.color("Color", 0.8)), closure_normal(n))
