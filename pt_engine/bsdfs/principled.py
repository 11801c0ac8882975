"""Blender's Principled BSDF, taken apart: which closures, how bright each, layered as in Cycles.

From the top: coat, metal (its share of the surface), glass (its share of the rest), gloss, and diffuse
below. A dielectric layer takes what it reflects toward the viewer from all that is below it ("albedo
scaling"), by its brightest channel:

    weight below = weight · (1 − max over RGB of the layer's albedo)

so that the sum conserves energy as far as each layer's albedo is known (`energy.gloss`). The tint of the
coat is absorption along the refracted view ray, tint^(1/cosθt). Sheen is not modelled; alpha and emission
are the caller's, the latter times the `Layers.emission` that coat lets through. Subsurface scattering is its
diffuse limit.

Which lobes exist is decided by constants alone (`lobes`), the rest per lane (`layers`).
"""

from __future__ import annotations

from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from ..core.vectors import max3
from . import conductor, dielectric, diffuse, energy, fresnel, oren_nayar, specular
from .base import Float32

CUTOFF = 1e-5  # of weights, as in Cycles
ONE = np.ones(1, np.float32)
ZERO = np.zeros(1, np.float32)
WHITE = np.ones((3, 1), np.float32)


class Inputs(NamedTuple):
    """Blender's sockets; each a number, (1,) or (N,) float32, colours (3, 1) or (3, N)."""

    base_color: Float32 = WHITE * np.float32(0.8)
    metallic: Float32 = ZERO
    roughness: Float32 = ONE * np.float32(0.5)
    ior: Float32 = ONE * np.float32(1.5)
    diffuse_roughness: Float32 = ZERO
    subsurface_weight: Float32 = ZERO
    specular_ior_level: Float32 = ONE * np.float32(0.5)
    specular_tint: Float32 = WHITE
    anisotropic: Float32 = ZERO
    transmission_weight: Float32 = ZERO
    coat_weight: Float32 = ZERO
    coat_roughness: Float32 = ONE * np.float32(0.03)
    coat_ior: Float32 = ONE * np.float32(1.5)
    coat_tint: Float32 = WHITE


class Lobes(NamedTuple):
    """Which closures there are: those that no constant rules out."""

    coat: bool
    coat_tint: bool
    metal: bool
    glass: bool
    gloss: bool
    diffuse: bool
    rough_diffuse: bool
    subsurface: bool
    anisotropic: bool
    tinted: bool


class Layer(NamedTuple):
    """A closure: its model (a module of this package), weight (3, N) or (3, 1), and parameters.

    `coat_normal`: its normal is the coat's. `tangent`: it needs the tangent, being anisotropic.
    """

    bsdf: ModuleType
    weight: Float32
    params: Any
    coat_normal: bool = False
    tangent: bool = False


class Layers(NamedTuple):
    """The closures, and the factor (3, N) or (3, 1) that emission loses to the coat."""

    closures: list[Layer]
    emission: Float32


def inputs(**sockets: Any) -> Inputs:
    """Inputs from numbers, 3-sequences and arrays."""
    colors = {"base_color", "specular_tint", "coat_tint"}
    arrays = {}
    for name, value in sockets.items():
        array = np.asarray(value, np.float32)
        if name in colors:
            array = array[:, np.newaxis] if array.ndim == 1 else array
            array = WHITE * array if array.ndim < 2 or len(array) == 1 else array
        arrays[name] = np.atleast_1d(array)
    return Inputs(**arrays)


def lobes(given: Inputs, tangent: bool = True) -> Lobes:
    """Which closures exist; a lobe is left out only if a constant makes its weight zero.

    Parameters
    ----------
    tangent : whether there is a tangent: without one anisotropy has no effect (as in Cycles).
    """
    metal, glass = _is(given.metallic, 1.0), _is(given.transmission_weight, 1.0)
    below = not metal and not glass
    subsurface = below and not _zero(given.subsurface_weight)
    lambert = below and not _is(given.subsurface_weight, 1.0)
    bare = _is(given.ior, 1.0) or _zero(given.specular_ior_level)
    dark = _zero(given.base_color)
    rough = not _zero(given.diffuse_roughness)
    return Lobes(
        coat=not _zero(given.coat_weight),
        coat_tint=not _zero(given.coat_weight) and not _is(given.coat_tint, 1.0),
        metal=not _zero(given.metallic),
        glass=not metal and not _zero(given.transmission_weight),
        gloss=below and not bare,
        diffuse=not dark and (lambert and not rough),
        rough_diffuse=not dark and lambert and rough,
        subsurface=not dark and subsurface,
        anisotropic=tangent and not _zero(given.anisotropic),
        tinted=not _is(given.specular_tint, 1.0),
    )


def layers(
    given: Inputs,
    cos_i: Float32,
    cos_coat: Float32,
    inside: Float32,
    which: Lobes | None = None,
    multiscatter: bool = True,
) -> Layers:
    """The closures of a Principled surface.

    Parameters
    ----------
    given : Inputs
    cos_i, cos_coat : (N,) float32
        Cosine of the viewer's direction against the base's and the coat's normal, ≥ 0.
    inside : (N,) or (1,) float32
        1 where the viewer is behind the surface (`lanes.backfacing`), else 0.
    which : Lobes
        Decided before, where `given` may hold per lane what was constant per material.
    multiscatter : bool
        Blender's "Multiscatter GGX", else single scattering (the coat always has the former).
    """
    which = lobes(given) if which is None else which
    made: list[Layer] = []
    weight = WHITE
    if which.coat:
        weight = _add_coat(made, given, cos_coat, weight, which.coat_tint)
    emission = weight
    given = given._replace(base_color=np.maximum(given.base_color, 0.0))
    color = np.minimum(given.base_color, 1.0)
    alpha = _alpha(given, which.anisotropic)
    if which.metal:
        share = _unit(given.metallic)
        made.append(_metal(given, color, alpha, cos_i, weight * share, multiscatter, which))
        weight = weight * (1.0 - share)
    if which.glass:
        share = _unit(given.transmission_weight)
        made.append(_glass(given, color, cos_i, inside, weight * share, multiscatter, which))
        weight = weight * (1.0 - share)
    if which.gloss:
        weight = _add_gloss(made, given, alpha, cos_i, weight, multiscatter, which)
    if which.diffuse or which.rough_diffuse or which.subsurface:
        _add_diffuse(made, given, color, weight, which)
    return Layers(made, emission)


# ------------------------------------------------------------------------- the layers, from the top


def _add_coat(made: list[Layer], given: Inputs, cos: Float32, weight: Float32, tinted: bool) -> Float32:
    """A clear dielectric of its own roughness; returns what is left for the layers below."""
    share = np.maximum(given.coat_weight, 0.0)
    alpha = _square(given.coat_roughness)
    eta: Float32 = np.maximum(given.coat_ior, 1.0)
    average: Float32 = fresnel.dielectric_average(eta)[np.newaxis]
    gain = energy.reflection_gain(alpha, None, cos, average)
    made.append(Layer(specular, weight * share * gain, specular.Params(alpha, None, eta), coat_normal=True))
    f0 = fresnel.normal_incidence(eta)
    albedo = f0 + (1.0 - f0) * energy.gloss(alpha, None, eta, cos)
    weight = weight * _left(share * albedo * _darkening(alpha, None, cos, gain))
    if tinted:
        cos_t: Float32 = np.sqrt(np.maximum(1.0 - (1.0 - cos * cos) / (eta * eta), 1e-12))
        absorbed: Float32 = np.power(np.maximum(given.coat_tint, 0.0), 1.0 / cos_t)
        weight = weight * (1.0 + share * (absorbed - 1.0))
    return weight


def _metal(
    given: Inputs,
    color: Float32,
    alpha: tuple[Float32, Float32 | None],
    cos: Float32,
    weight: Float32,
    multiscatter: bool,
    which: Lobes,
) -> Layer:
    tint = np.minimum(np.maximum(given.specular_tint, 0.0), 1.0) if which.tinted else WHITE
    params = conductor.Params(*alpha, color, tint)
    if multiscatter:
        weight = weight * energy.reflection_gain(*alpha, cos, conductor.average(params))
    return Layer(conductor, weight, params, tangent=which.anisotropic)


def _glass(
    given: Inputs,
    color: Float32,
    cos: Float32,
    inside: Float32,
    weight: Float32,
    multiscatter: bool,
    which: Lobes,
) -> Layer:
    """Coloured once on each of its two faces, hence the root of the colour."""
    ior = np.maximum(given.ior, 1e-5)
    eta: Float32 = ior * (1.0 - inside) + inside / ior
    alpha = _square(given.roughness)
    through = np.sqrt(color)
    tint = np.maximum(given.specular_tint, 0.0) if which.tinted else None
    if multiscatter:
        weight = weight * energy.glass_gain(alpha, eta, cos, through)
    return Layer(dielectric, weight, dielectric.Params(alpha, eta, None, through, tint))


def _add_gloss(
    made: list[Layer],
    given: Inputs,
    alpha: tuple[Float32, Float32 | None],
    cos: Float32,
    weight: Float32,
    multiscatter: bool,
    which: Lobes,
) -> Float32:
    """The dielectric's own reflection; returns what is left for the diffuse layers."""
    eta = _gloss_index(given)
    tint = np.maximum(given.specular_tint, 0.0) if which.tinted else None
    white = np.ones((1, 1), np.float32)
    f0 = fresnel.normal_incidence(eta)
    base: Float32 = np.minimum(f0 * (white if tint is None else tint), 1.0)
    s = energy.gloss(*alpha, eta, cos)
    albedo: Float32 = base + (1.0 - base) * s
    gain = white
    if multiscatter:
        rise = (fresnel.dielectric_average(eta) - f0) / np.maximum(1.0 - f0, 1e-6)
        average = base + (1.0 - base) * _unit(rise)
        gain = energy.reflection_gain(*alpha, cos, average)
        albedo = albedo * _darkening(*alpha, cos, gain)
    params = specular.Params(*alpha, eta, tint)
    made.append(Layer(specular, weight * gain, params, tangent=which.anisotropic))
    return weight * _left(albedo)


def _add_diffuse(made: list[Layer], given: Inputs, color: Float32, weight: Float32, which: Lobes) -> None:
    """Lambert or Oren-Nayar for the share that is not subsurface, Lambert for that which is."""
    share = _unit(given.subsurface_weight)
    smooth: Float32 = np.zeros((3, 1), np.float32)
    if which.subsurface:
        smooth = color * share * weight
    if which.diffuse:
        lambert: Float32 = given.base_color * (1.0 - share) * weight
        smooth = smooth + lambert
    if which.diffuse or which.subsurface:
        made.append(Layer(diffuse, smooth, diffuse.Params()))
    if which.rough_diffuse:
        params = oren_nayar.Params(_unit(given.diffuse_roughness), color)
        made.append(Layer(oren_nayar, given.base_color * (1.0 - share) * weight, params))


# ------------------------------------------------------------------------- small things


def _gloss_index(given: Inputs) -> Float32:
    """The index whose reflectance at normal incidence is the IOR's times twice the specular level."""
    ior: Float32 = np.maximum(given.ior, 1e-5)
    if _is(given.specular_ior_level, 0.5):
        return ior
    level: Float32 = np.maximum(given.specular_ior_level, 0.0)
    eta = fresnel.index_of(fresnel.normal_incidence(ior) * (2.0 * level))
    denser = (ior >= 1.0).astype(np.float32)
    index: Float32 = eta * denser + (1.0 - denser) / eta
    return index


def _alpha(given: Inputs, anisotropic: bool) -> tuple[Float32, Float32 | None]:
    """Roughness² along tangent and bitangent, stretched by Blender's anisotropy."""
    alpha = _square(given.roughness)
    if not anisotropic:
        return alpha, None
    aspect = np.sqrt(1.0 - 0.9 * _unit(given.anisotropic))
    return np.minimum(alpha / aspect, 1.0), alpha * aspect


def _darkening(alpha_x: Float32, alpha_y: Float32 | None, cos: Float32, gain: Float32) -> Float32:
    """gain · E: by how much less than white facets the surface gives back (Cycles has it in the albedo)."""
    return gain * energy.reflection_albedo(alpha_x, alpha_y, cos)


def _left(albedo: Float32) -> Float32:
    """1 − the brightest channel, within [0, 1]: (N,) or (1,)."""
    albedo = np.atleast_2d(albedo)
    brightest = albedo[0] if len(albedo) == 1 else max3(albedo)
    left: Float32 = np.minimum(np.maximum(1.0 - brightest, 0.0), 1.0)
    return left


def _square(roughness: Float32) -> Float32:
    root = _unit(roughness)
    return root * root


def _unit(x: Float32) -> Float32:
    unit: Float32 = np.minimum(np.maximum(x, 0.0), 1.0)
    return unit


def _zero(value: Float32) -> bool:
    """Whether a constant is not above the cut-off."""
    return value.shape[-1] == 1 and bool((value <= CUTOFF).all())


def _is(value: Float32, constant: float) -> bool:
    return value.shape[-1] == 1 and bool((value == constant).all())
