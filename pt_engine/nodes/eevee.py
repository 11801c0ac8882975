"""Nodes of EEVEE that Cycles knows nothing of: stand-ins, so that such a file is not black."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .batch import model, params_of
from .energy_nodes import cosine
from .graph import NodeView
from .ir import COLOR, FLOAT, Value, op
from .math_nodes import saturate
from .normals import closure_normal
from .ray_portal import PORTAL
from .registry import Outputs, node, shader
from .roughness import Rough, isotropic, squared
from .surface import TRANSPARENT, Leaf, SurfaceBuilder, is_zero

Float32 = NDArray[np.float32]


@op(FLOAT)
def estimated_albedo(bsdf: str, names: tuple[str, ...], cos: Float32, *values: Float32) -> Float32:
    """What a scattering model thinks that it reflects toward the viewer."""
    module: Any = model(bsdf)
    albedo: Float32 = module.albedo(params_of(module, dict(zip(names, values, strict=True))), cos)
    return albedo + np.zeros_like(cos)  # a model may give one number for all lanes


def evenly_lit(n: NodeView, leaf: Leaf) -> Value:
    """A closure's colour under white light from all sides."""
    names, values = zip(*leaf.params, strict=True) if leaf.params else ((), ())
    share = n.call(estimated_albedo, cosine(n, leaf.normal), *values, static=(leaf.bsdf, names))
    return n.builder.multiply(leaf.weight, share)


@node("ShaderToRGB")
def shader_to_rgb(n: NodeView) -> Outputs:
    """The shader's emission, and its reflection as if radiance 1 came from everywhere."""
    n.approximate("an EEVEE node: the shader as lit by even white light, without shadows or lamps")
    b, out = n.builder, SurfaceBuilder(n.builder)
    n.closures("Shader", b.one, out)
    color: Value = n.constant(0.0, COLOR) if out.emission is None else out.emission
    if not n.reader.world:
        for leaf in out.leaves:
            if leaf.bsdf not in (TRANSPARENT, PORTAL):
                color = b.add(color, evenly_lit(n, leaf))
    alpha = b.one if out.transparency is None else b.complement(b.convert(out.transparency, FLOAT))
    return {"Color": color, "Alpha": n.call(saturate, alpha)}


@shader("EeveeSpecular")
def eevee_specular(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    """Diffuse, Schlick's gloss with the specular colour at normal incidence, a clear coat, emission."""
    n.approximate("an EEVEE node: its layers are added up, without ambient occlusion")
    b, white, normal = n.builder, n.constant(1.0, COLOR), closure_normal(n)
    out.add_emission(b.multiply(weight, n.color("Emissive Color")))
    clear = n.call(saturate, n.float("Transparency"))
    out.add_transparent(b.multiply(weight, clear))
    weight = b.multiply(weight, b.complement(clear))
    coat = n.call(saturate, n.float("Clear Coat"))
    if not is_zero(coat):
        rough = Rough(n.call(squared, n.float("Clear Coat Roughness")))
        params = rough.params() | {"eta": n.constant(1.5, FLOAT)}
        over = closure_normal(n, "Clear Coat Normal")
        out.add("specular", params, b.multiply(weight, coat), over, dirac=rough.is_smooth)
    rough, color = isotropic(n, 0.2), n.color("Specular", 0.03)
    if not is_zero(color):
        params = rough.params() | {"color": out.positive(color), "edge_tint": white}
        out.add("conductor", params, weight, normal, dirac=rough.is_smooth)
    out.add("diffuse", {}, b.multiply(weight, n.color("Base Color", 0.8)), normal)
