"""Shader nodes: what each adds to a surface. Principled has its own file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import ashikhmin_shirley
from .energy_nodes import complex_average, gained, glass_gained, tinted_average
from .graph import NodeView
from .ir import COLOR, FLOAT, Value, lane_op
from .math_nodes import at_least, saturate
from .normals import closure_normal
from .registry import shader
from .roughness import Rough, anisotropic, glossy_alphas, isotropic, principled_alphas
from .surface import SurfaceBuilder, is_at_most, is_constantly, is_zero
from .thin_films import film_params, glass_film_params

Float32 = NDArray[np.float32]
ALMOST_SMOOTH = 1e-5  # diffuse roughness up to this is Lambert's law, as in Cycles
NARROW_PHONG = 0.05  # alpha; Cycles' sampler keeps to the formula for narrower lobes
WIDE_GLASS = 0.36  # alpha; see `note_rough_glass`
MORE_LIGHT_IN_CYCLES = "as the formula has it; rougher than 0.6 Cycles adds light that no facet refracts so"


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
    out.add_holdout(weight)


# ------------------------------------------------------------------ diffuse


def add_diffuse(
    n: NodeView,
    out: SurfaceBuilder,
    weight: Value,
    roughness: Value,
    color: Value,
    normal: Value | None,
) -> None:
    """Lambert, or Oren-Nayar where the roughness is not constantly 0; `weight` carries the colour."""
    if is_lambert(roughness):
        out.add("diffuse", {}, weight, normal)
        return
    params = {"roughness": n.call(saturate, roughness), "color": n.call(saturate_color(), color)}
    out.add("oren_nayar", params, weight, normal)


def is_lambert(roughness: Value) -> bool:
    """Whether a diffuse roughness is constantly 0."""
    return is_at_most(roughness, ALMOST_SMOOTH)


def saturate_color() -> Any:
    """The op that clamps a colour (its file comes after this one's in the imports)."""
    from .color_nodes import saturate_color as clamped

    return clamped


@shader("BsdfDiffuse", "PtDiffuse")
def diffuse(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    color = n.color("Color", 0.8)
    weight = n.builder.multiply(weight, color)
    if not is_zero(weight):
        add_diffuse(n, out, weight, n.float("Roughness"), color, closure_normal(n))


@shader("BsdfTranslucent")
def translucent(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    weight = n.builder.multiply(weight, n.color("Color", 0.8))
    if n.linked("Normal") is not None:
        n.approximate("bumps do not dim what passes; in Cycles they dim that of sampled lights")
    out.add("translucent", {}, weight, closure_normal(n))


@shader("SubsurfaceScattering")
def subsurface(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    weight = n.builder.multiply(weight, n.color("Color", 0.8))
    if not (is_zero(n.float("Scale", 1.0)) or is_zero(n.vector("Radius", 1.0))):
        n.approximate("diffuse: light leaves where it enters")
    out.add("diffuse", {}, weight, closure_normal(n))


# ------------------------------------------------------------------ glossy


def metal_model(n: NodeView, default: str = "MULTI_GGX") -> str:
    """The reflection model of a node's distribution."""
    return "conductor_beckmann" if n.prop("distribution", default) == "BECKMANN" else "conductor"


def is_multiscatter(n: NodeView, default: str = "MULTI_GGX") -> bool:
    """Whether light that bounces between facets is kept."""
    return bool(n.prop("distribution", default) == "MULTI_GGX")


def add_metal(
    n: NodeView, out: SurfaceBuilder, weight: Value, rough: Rough, average: Value | None, **fresnel: Value
) -> None:
    """A microfacet reflection; `average` is its facets' mean reflectance, None for single scattering."""
    normal = closure_normal(n)
    if average is not None:
        weight = gained(n, weight, rough, average, normal)
    out.add(metal_model(n), rough.params() | fresnel, weight, normal, rough.tangent, rough.is_smooth)


def add_phong(n: NodeView, out: SurfaceBuilder, weight: Value, rough: Rough, normal: Value | None) -> None:
    """Ashikhmin-Shirley's lobe.

    Where a half vector faces away from the viewer, Cycles' sampler mirrors wrongly and reflects light that
    the model (and Cycles' own evaluation of it) does not: at roughness 0.8 up to 40 % at grazing.
    """
    if not rough.is_at_most(NARROW_PHONG):
        n.approximate("as the formula has it; toward grazing Cycles' sampler adds light to rough highlights")
    dirac = rough.is_at_most(ashikhmin_shirley.SMOOTH)
    out.add("ashikhmin_shirley", rough.params(), weight, normal, rough.tangent, dirac)


@shader("BsdfGlossy", "BsdfAnisotropic")
def glossy(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    color = n.color("Color", 0.8)
    weight = n.builder.multiply(weight, color)
    if is_zero(weight):
        return
    normal = closure_normal(n)
    rough = anisotropic(n, glossy_alphas, ("Anisotropy", "Rotation"), normal)
    if n.prop("distribution", "MULTI_GGX") == "ASHIKHMIN_SHIRLEY":
        add_phong(n, out, weight, rough, normal)
        return
    add_metal(n, out, weight, rough, out.positive(color) if is_multiscatter(n) else None)


@shader("BsdfMetallic")
def metallic(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    clamped, many = saturate_color(), is_multiscatter(n)
    rough = anisotropic(n, principled_alphas, ("Anisotropy", "Rotation"), closure_normal(n))
    film = film_params(n)
    if n.prop("fresnel_type", "F82") == "PHYSICAL_CONDUCTOR":
        eta = n.builder.convert(n.vector("IOR", (2.757, 2.513, 2.231)), COLOR)
        k = n.builder.convert(n.vector("Extinction", (3.867, 3.404, 3.009)), COLOR)
        average = n.call(complex_average, eta, k) if many else None
        add_metal(n, out, weight, rough, average, eta=eta, k=k, **film)
        return
    color = n.call(clamped, n.color("Base Color", (0.617, 0.577, 0.540)))
    tint = n.call(clamped, n.color("Edge Tint", (0.695, 0.726, 0.770)))
    average = n.call(tinted_average, color, tint) if many else None
    add_metal(n, out, weight, rough, average, color=color, edge_tint=tint, **film)


@shader("PtConductor")
def pt_conductor(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    eta, k = n.color("Eta", (0.2, 0.92, 1.1)), n.color("K", (3.9, 2.45, 2.14))
    rough, normal = isotropic(n, 0.0), closure_normal(n)
    params = rough.params() | {"color": n.color("Color", 1.0), "eta": eta, "k": k}
    out.add(metal_model(n, "GGX"), params, weight, normal, dirac=rough.is_smooth)


# ------------------------------------------------------------------ glass


@lane_op(FLOAT)
def relative_index(lanes: Any, ior: Float32) -> Float32:
    """Index of the far side over the viewer's: ior in front of the face, 1/ior behind."""
    eta = np.maximum(ior, np.float32(1e-5))
    out: Float32 = eta + lanes.backfacing * (1 / eta - eta)
    return out


def note_rough_glass(n: NodeView, rough: Rough) -> None:
    """List what Cycles adds to rough glass.

    Where lamps are sampled it does not ask whether some facet could refract so: a half vector that faces away
    from the eye passes for its opposite. A sheet of roughness 1 before a lamp becomes 5 % brighter so, one of
    0.6 less than 0.5 %.
    """
    if not rough.is_at_most(WIDE_GLASS):
        n.approximate(MORE_LIGHT_IN_CYCLES)


def add_glass(
    n: NodeView, out: SurfaceBuilder, kind: str, weight: Value, rough: Rough, eta: Value, **more: Value
) -> None:
    """Glass or refraction; a Dirac lobe where the roughness is constantly 0."""
    if n.prop("distribution", "GGX") == "BECKMANN":
        kind += "_beckmann"
    params = {"alpha": rough.alpha_x, "eta": eta} | more
    out.add(kind, params, weight, closure_normal(n), dirac=rough.is_smooth)


@shader("BsdfGlass")
def glass(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    color = n.color("Color", 1.0)
    weight = n.builder.multiply(weight, color)
    if is_zero(weight):
        return
    ior = n.float("IOR", 1.5)
    rough, eta = isotropic(n, 0.0), n.call(relative_index, ior)
    note_rough_glass(n, rough)
    if is_multiscatter(n):
        weight = glass_gained(n, weight, rough, eta, out.positive(color), closure_normal(n))
    add_glass(n, out, "dielectric", weight, rough, eta, **glass_film_params(n, ior))


@shader("BsdfRefraction")
def refraction(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    weight = n.builder.multiply(weight, n.color("Color", 1.0))
    rough, eta = isotropic(n, 0.0), n.call(relative_index, n.float("IOR", 1.45))
    note_rough_glass(n, rough)
    add_glass(n, out, "refraction", weight, rough, eta)


@shader("PtDielectric")
def pt_dielectric(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    tints = {
        name: n.color(socket)
        for name, socket in (
            ("reflection_tint", "Reflection Tint"),
            ("transmission_tint", "Transmission Tint"),
        )
        if socket in n.node.inputs
    }
    eta = n.call(relative_index, n.float("IOR", 1.5))
    add_glass(n, out, "dielectric", weight, isotropic(n, 0.0), eta, **tints)


@shader("PtRoughPlastic")
def pt_rough_plastic(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    """A clear coat over a diffuse base, on both sides: `bsdfs.plastic`."""
    params = {
        "alpha": isotropic(n, 0.3).alpha_x,
        "eta": n.call(at_least, n.float("IOR", 1.5), n.builder.one),
        "diffuse": n.call(saturate_color(), n.color("Color", 0.5)),
    }
    specular = n.color("Specular Color", 1.0)
    if not is_constantly(specular, 1):
        params["specular"] = n.call(saturate_color(), specular)
    if n.prop("nonlinear", False):
        params["nonlinear"] = n.builder.one
    out.add("plastic", params, weight, closure_normal(n))
