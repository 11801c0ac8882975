"""The Principled BSDF: layers, each taking what the one above lets through.

    transparency · (1 − alpha);  then sheen, coat, emission, metal · metallic, glass · transmission,
    gloss, diffuse

A layer of weight w and directional albedo A toward the viewer leaves 1 − w·max(A) to those below ("albedo
scaling"), as in Cycles; metal and glass take their share of the surface. The coat's tint is absorption along
the refracted view ray. Not Cycles': subsurface scattering, in its diffuse limit; the coverage entries say so.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import fresnel as law
from .color_nodes import saturate_color
from .energy_nodes import glass_average, glass_gained, gloss_layer, glossy_cosine, tinted_average
from .graph import NodeView
from .ir import COLOR, FLOAT, Const, Value, op
from .math_nodes import at_least, saturate, select
from .normals import closure_normal
from .registry import shader
from .roughness import Rough, anisotropic, principled_alphas, squared
from .shaders import add_diffuse, add_metal, is_lambert, is_multiscatter, note_rough_glass, relative_index
from .sheen import add_sheen_layer
from .surface import SurfaceBuilder, at_least_zero, is_at_most, is_constantly, is_zero
from .thin_films import film_params, glass_film_params
from .thin_walls import add_sheet, forward, is_true

Float32 = NDArray[np.float32]
CUTOFF: Final = 1e-5  # Cycles leaves out layers of less weight


# ------------------------------------------------------------------ what the layers leave


@op(COLOR)
def through_coat(cos: Float32, eta: Float32, tint: Float32) -> Float32:
    """The coat's tint over the length of the refracted path: tint^(1/cosθt)."""
    cos_t = np.sqrt(np.maximum(1 - (1 - cos * cos) / (eta * eta), np.float32(1e-6)))
    out: Float32 = np.power(np.maximum(tint, 0), 1 / cos_t)
    return out


@op(FLOAT)
def coat_share(weight: Float32, under: Float32) -> Float32:
    """What a coat of some weight leaves: 1 − weight·(1 − under), not below 0."""
    left: Float32 = np.maximum(1 - weight * (1 - under), 0)
    return left


@op(FLOAT)
def leveled_index(ior: Float32, level: Float32) -> Float32:
    """The index whose reflectance at normal incidence is 2·level times that of `ior`."""
    eta = law.index_of(law.normal_incidence(ior) * (2 * np.maximum(level, 0)))
    return select(level == np.float32(0.5), ior, select(ior < 1, 1 / eta, eta))


@op(COLOR)
def leveled_tint(tint: Float32, ior: Float32, level: Float32, eta: Float32) -> Float32:
    """The tint of the leveled index' reflectance: what the level asks for beyond its limit is in it."""
    f0 = law.normal_incidence(eta)
    wanted = law.normal_incidence(ior) * (2 * np.maximum(level, 0))
    # but for the limit both are the same to rounding, and tints stay as they are
    beyond = (wanted > np.float32(0.99)) * (wanted / np.maximum(f0, np.float32(1e-6)) - 1)
    out: Float32 = tint * (1 + beyond)
    return out


@op(COLOR)
def root(c: Float32) -> Float32:
    """√c: half of a colour's absorption, for each of the two passes through glass."""
    return np.sqrt(np.maximum(c, 0))


# ------------------------------------------------------------------ layers


class Layers:
    """Adds Principled's closures from the top down; `weight` is what is left for the next."""

    def __init__(self, n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
        self.n, self.weight, self.out, self.b = n, weight, out, n.builder
        self.normal, self.multiscatter = closure_normal(n), is_multiscatter(n)
        self.base = n.color("Base Color", 0.8)
        self.clamped = n.call(saturate_color, self.base)
        self.ior = n.call(at_least, n.float("IOR", 1.5), n.constant(1e-5, FLOAT))
        self.tint = n.call(at_least_zero, n.color("Specular Tint", 1.0))
        self.film = film_params(n)
        self.thin = n.call(is_true, n.float("Thin Wall"))
        self.may_be_dark = False  # whether a component of `weight` may be 0 where others are not

    def share(self, name: str) -> Value:
        """A layer's weight in [0, 1]; the constant 0 where too small to matter."""
        value = self.n.float(name)
        return self.b.zero if is_at_most(value, CUTOFF) else self.n.call(saturate, value)

    def leave(self, share: Value) -> None:
        """Scale what is left."""
        self.weight = self.b.multiply(self.weight, share)

    def transparency(self) -> None:
        alpha = self.n.call(saturate, self.n.float("Alpha", 1.0))
        self.out.add_transparent(self.b.multiply(self.weight, self.b.complement(alpha)))
        self.leave(alpha)

    def sheen(self) -> None:
        n, share = self.n, self.n.float("Sheen Weight")
        if is_at_most(share, CUTOFF):
            return
        tint = n.call(at_least_zero, n.color("Sheen Tint", 1.0))
        color = self.b.multiply(n.call(at_least, share, self.b.zero), tint)  # above 1 too, as in Cycles
        self.leave(add_sheen_layer(n, self.out, self.weight, color, self.normal))

    def coat(self) -> None:
        n, share = self.n, self.n.float("Coat Weight")
        if is_at_most(share, CUTOFF):
            return
        share = n.call(at_least, share, self.b.zero)  # above 1 too, as in Cycles
        normal = closure_normal(n, "Coat Normal")
        eta = n.call(at_least, n.float("Coat IOR", 1.5), n.constant(1.0, FLOAT))
        rough = Rough(n.call(squared, n.float("Coat Roughness", 0.03)))
        gain, under = gloss_layer(n, rough, eta, n.constant(1.0, COLOR), normal, multiscatter=True, film={})
        weight = self.b.multiply(self.b.multiply(self.weight, share), gain)
        self.out.add("specular", rough.params() | {"eta": eta}, weight, normal, None, rough.is_smooth)
        self.leave(n.call(coat_share, share, under))
        tint = n.color("Coat Tint", 1.0)
        if not is_constantly(tint, 1):
            self.may_be_dark = not (isinstance(tint, Const) and bool((tint.data > 0).all()))
            tinted = n.call(through_coat, glossy_cosine(n, normal), eta, tint)
            rest = self.b.multiply(self.b.complement(share), n.constant(1.0, COLOR))
            self.leave(self.b.add(rest, self.b.multiply(share, tinted)))

    def emission(self) -> None:
        strength = self.n.float("Emission Strength")
        if not is_zero(strength):
            color = self.n.color("Emission Color", 1.0)
            self.out.add_emission(self.b.multiply(self.weight, self.b.multiply(strength, color)))

    def metal(self, rough: Rough) -> None:
        share = self.share("Metallic")
        if not is_zero(share):
            edge = self.n.call(saturate_color, self.tint)
            weight = self.b.multiply(self.weight, share)
            average = self.n.call(tinted_average, self.clamped, edge) if self.multiscatter else None
            color = {"color": self.clamped, "edge_tint": edge}
            add_metal(self.n, self.out, weight, rough, average, **color, **self.film)
            self.leave(self.b.complement(share))

    def glass(self) -> None:
        n, share = self.n, self.share("Transmission Weight")
        if is_zero(share):
            return
        rough = Rough(n.call(squared, n.float("Roughness", 0.5)))
        weight = self.b.multiply(self.weight, share)
        sheet, solid = (self.b.multiply(weight, part) for part in (self.thin, self.b.complement(self.thin)))
        if not is_zero(sheet):
            colors = self.tint, self.clamped
            add_sheet(n, self.out, sheet, rough.alpha_x, self.ior, colors, self.film, self.normal)
        if not is_zero(solid):
            self.solid_glass(solid, rough)
        self.leave(self.b.complement(share))

    def solid_glass(self, weight: Value, rough: Rough) -> None:
        n = self.n
        note_rough_glass(n, rough)
        through, eta = n.call(root, self.clamped), n.call(relative_index, self.ior)
        params = {"alpha": rough.alpha_x, "eta": eta, "transmission_tint": through}
        params |= glass_film_params(n, self.ior)
        if not is_constantly(self.tint, 1):
            params["specular_tint"] = self.tint
        if self.multiscatter:
            has_color = isinstance(through, Const) and bool((through.data > 0).any())
            average = through if has_color else n.call(glass_average, through, eta, self.tint)
            weight = glass_gained(n, weight, rough, eta, average, self.normal)
        self.out.add("dielectric", params, weight, self.normal, dirac=rough.is_smooth)

    def gloss(self, rough: Rough) -> None:
        n, level = self.n, self.n.float("Specular IOR Level", 0.5)
        if not self.film and (is_at_most(level, 0) or is_constantly(self.ior, 1)):
            return
        eta, tint = self.ior, self.tint
        if not is_constantly(level, 0.5):
            eta = n.call(leveled_index, self.ior, level)
            tint = n.call(leveled_tint, tint, self.ior, level, eta)
        params = rough.params() | {"eta": eta} | self.film
        if not is_constantly(tint, 1):
            params["tint"] = tint
        dark = self.weight if self.may_be_dark else None
        gain, left = gloss_layer(n, rough, eta, tint, self.normal, self.multiscatter, self.film, dark)
        weight = self.b.multiply(self.weight, gain)
        self.out.add("specular", params, weight, self.normal, rough.tangent, rough.is_smooth)
        self.leave(left)

    def diffuse(self) -> None:
        n, b, roughness = self.n, self.b, self.n.float("Diffuse Roughness")
        share = self.share("Subsurface Weight")
        rest = b.multiply(b.complement(share), self.base)
        under = b.multiply(share, self.clamped)
        sheet, solid = b.multiply(under, self.thin), b.multiply(under, b.complement(self.thin))
        if not is_zero(sheet):
            rest = b.add(rest, self.thin_subsurface(sheet, roughness))
        if not is_zero(solid):
            if not (
                is_zero(n.float("Subsurface Scale", 0.05)) or is_zero(n.vector("Subsurface Radius", 1.0))
            ):
                n.approximate("subsurface light leaves where it enters")
            if is_lambert(roughness):
                rest = b.add(rest, solid)
            else:
                self.out.add("diffuse", {}, b.multiply(self.weight, solid), self.normal)
        add_diffuse(n, self.out, b.multiply(self.weight, rest), roughness, self.base, self.normal)

    def thin_subsurface(self, color: Value, roughness: Value) -> Value:
        """Adds what a sheet of dense matter lets through; returns the colour of what it sends back."""
        n, b = self.n, self.b
        share = n.call(forward, n.float("Subsurface Anisotropy"))
        weight = b.multiply(self.weight, b.multiply(share, color))
        if is_lambert(roughness):
            self.out.add("translucent", {}, weight, self.normal)
        else:
            params = {"roughness": n.call(saturate, roughness), "color": self.clamped}
            self.out.add("rough_translucent", params, weight, self.normal)
        return b.multiply(b.complement(share), color)


@shader("BsdfPrincipled")
def principled(n: NodeView, weight: Value, out: SurfaceBuilder) -> None:
    layers = Layers(n, weight, out)
    layers.transparency()
    layers.sheen()
    layers.coat()
    layers.emission()
    if is_zero(layers.weight):
        return
    rough = anisotropic(n, principled_alphas, ("Anisotropic", "Anisotropic Rotation"), layers.normal)
    layers.metal(rough)
    if not is_zero(layers.weight):
        layers.glass()
    if not is_zero(layers.weight):
        layers.gloss(rough)
        layers.diffuse()
