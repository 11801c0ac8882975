"""Plastic: a clear dielectric coat, smooth or rough, over a diffuse base (Mitsuba's `roughplastic`).

    f·cosθo = F D G2/(4 cosθi)  +  (1/π) cosθo  T(θi) T(θo)/η² · ρ/(1 − ρ' R)

T(θ) is the share of light that enters at θ, R that of diffuse light inside which the surface sends back
(both from `energy`'s tables), so that 1/(1 − ρ' R) sums the bounces in between. ρ' = ρ shifts the colour as
these bounces do (`nonlinear` 1), ρ' = 1 keeps it (0).

The reflection is GGX as in `reflection`, and is chosen in proportion to what it reflects toward the viewer,
but not too rarely: among its facets some may reflect all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core import warps
from ..core.vectors import mean3
from . import energy, fresnel, reflection
from .base import BSDFSample, Float32, Lobe, UInt8
from .microfacet import GGX, roughness

SPECULAR = True
LEAST_CHOICE = 0.05
WHITE = np.ones((1, 1), np.float32)


class Params(NamedTuple):
    """
    Attributes
    ----------
    alpha : (N,) float32
        Roughness of the coat; below about 1.4e-5 it is ideally smooth.
    eta : (N,) float32 > 1
        Index of the coat.
    diffuse : (3, N) float32
        ρ, reflectance of the base.
    specular : (3, N) float32 or None
        Factor on the coat's reflection; physically 1.
    nonlinear : (N,) float32 or None
        1 for colour shifts by internal scattering; None is 0.
    """

    alpha: Float32
    eta: Float32
    diffuse: Float32
    specular: Float32 | None = None
    nonlinear: Float32 | None = None


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·cosθo (3, N) and pdf (N,); of a smooth coat the base's alone."""
    entering, tint, p = _choice(params, wi[2])
    value, pdf = reflection.eval_pdf(GGX, (params.alpha, None), _facets(params), wi, wo)
    cosine = warps.cosine_hemisphere_pdf(wo) * (wi[2] > 0)
    leaving = energy.passed(params.alpha, params.eta, wo[2])
    value = tint * value + _base(params) * (entering * leaving * cosine)
    return value, p * pdf + (1.0 - p) * cosine


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Reflect at a visible facet or scatter from the base: `u0` decides which."""
    _, tint, p = _choice(params, wi[2])
    s = reflection.sample(GGX, (params.alpha, None), _facets(params), wi, u1, u2)
    gloss = (u0 < p).astype(wi.dtype)
    wo: Float32 = warps.square_to_cosine_hemisphere(u1, u2)
    wo = wo * (1.0 - gloss) + s.wo * gloss
    value, pdf = eval_pdf(params, wi, wo)
    weight = value / (pdf + (pdf <= 0))
    smooth = roughness(params.alpha, None)[2]
    dirac = smooth * gloss
    weight = weight * (1.0 - dirac) + (tint * s.weight / p) * dirac
    bits: Float32 = gloss * (Lobe.GLOSSY - Lobe.DIFFUSE) + dirac * (Lobe.DELTA - Lobe.GLOSSY)
    bits = bits + Lobe.DIFFUSE
    lobe: UInt8 = bits.astype(np.uint8)
    return BSDFSample(wo, pdf * (1.0 - dirac) + p * dirac, weight, lobe)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """Mean reflectance, roughly: what enters comes back by the base's colour."""
    entering = energy.passed(params.alpha, params.eta, cos_i)
    return (1.0 - entering) + entering * mean3(params.diffuse)


def _facets(params: Params) -> reflection.Fresnel:
    eta = params.eta
    return lambda cos: fresnel.dielectric(cos, eta)[0][np.newaxis]


def _base(params: Params) -> Float32:
    """ρ/(η² (1 − ρ' R)): (3, N) or (3, 1)."""
    back = energy.inner_reflectance(params.alpha, params.eta)[np.newaxis]
    if params.nonlinear is not None:
        darker: Float32 = params.nonlinear * (1.0 - params.diffuse)
        back = back * (1.0 - darker)
    leaving: Float32 = params.eta * params.eta * (1.0 - back)
    return params.diffuse / leaving


def _choice(params: Params, cos_i: Float32) -> tuple[Float32, Float32, Float32]:
    """T(θi), the coat's tint, and the probability of its reflection."""
    entering = energy.passed(params.alpha, params.eta, cos_i)
    tint = WHITE if params.specular is None else params.specular
    gloss = mean3(tint) * (1.0 - entering)
    base = mean3(params.diffuse) * entering
    p: Float32 = np.maximum(gloss / (gloss + base + fresnel.TINY), LEAST_CHOICE)
    return entering, tint, p
