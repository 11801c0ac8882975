"""Reflection and refraction by the facets of a rough interface: glass.

With η the index of the far side over the near one, η' = 1 for reflection and η for refraction, and the
unnormalised half vector h = wi + η' wo, both lobes have one form,

    pdf = p · 2 D(h)/|h|⁴ · η'² |wi·h| |wo·h| / (zi + ti)        f·|cosθo| = (C/p) · pdf · G2/G1(wi)

where C is what the facet reflects or transmits and p the probability of that lobe. Walter et al. 2007,
"Microfacet Models for Refraction through Rough Surfaces", with Smith's masking as in `microfacet`.

Radiance that passes is not scaled by η² (the scalings of entering and leaving cancel for any light and
eye outside; Cycles does the same). G2 is 1/(1 + Λi + Λo) for both lobes, as in Cycles.

A refracted lobe is about α|η − 1| wide; narrower than float32 tells directions apart it is a Dirac lobe.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..core.vectors import dot, normalize
from . import fresnel
from .base import BSDFSample, Float32, Lobe, UInt8
from .microfacet import Distribution, masking_ratio, roughness

NARROWEST = 1e-4
NO_INTERFACE = 1e-4  # |η − 1| below which there is nothing to refract, nor to mask


class Split(NamedTuple):
    """What a facet does with light at some cosine: a `Law`'s answer.

    Attributes
    ----------
    reflected, transmitted : (3, N), (1, N) or (1, 1) float32
    probability : (N,) or (1,) float32
        Of choosing reflection.
    g : (N,) float32
        η cosθt, 0 under total reflection.
    """

    reflected: Float32
    transmitted: Float32
    probability: Float32
    g: Float32


Law = Callable[[Float32], Split]


def eval_pdf(
    model: type[Distribution], alpha: Float32, eta: Float32, law: Law, wi: Float32, wo: Float32
) -> tuple[Float32, Float32]:
    """f·|cosθo| (3, N) or (1, N) and pdf (N,)."""
    a, _, smooth = roughness(alpha, None)
    r = (wo[2] > 0).astype(wo.dtype)
    t = 1.0 - r
    side_eta = r + eta * t
    h = wi + side_eta * wo
    ih, oh = dot(wi, h), dot(wo, h)
    valid = (ih * h[2] > 0) & (oh * h[2] * wo[2] > 0) & (wi[2] > 0)
    a2 = a * a
    ti = model.stretched(wi, a2, a2)
    pdf = model.density(h[0], h[1], h[2], a, a)
    pdf *= 2.0 * (side_eta * side_eta) * np.abs(ih * oh)
    pdf /= wi[2] + ti + (wi[2] <= 0)
    pdf *= valid
    pdf *= (1.0 - smooth) * (r + t * _is_wide(a, eta))
    ratio = masking_ratio(wi[2], ti, np.abs(wo[2]), model.stretched(wo, a2, a2))
    cos: Float32 = np.abs(ih)
    cos /= np.sqrt(dot(h, h) + 1e-20)
    split = law(np.minimum(cos, 1.0))
    share = split.reflected * r + split.transmitted * t
    value = share * (pdf * ratio)
    pdf *= split.probability * r + (1.0 - split.probability) * t
    return value, pdf


def sample(
    model: type[Distribution],
    alpha: Float32,
    eta: Float32,
    law: Law,
    wi: Float32,
    u0: Float32,
    u1: Float32,
    u2: Float32,
) -> BSDFSample:
    """Reflect or refract wi at a visible facet: `u0` decides which."""
    a, _, smooth = roughness(alpha, None)
    b = a * (1.0 - smooth)
    m = model.visible_normal(wi, b, b, u1, u2)
    cos = dot(wi, m)
    ci: Float32 = np.minimum(np.maximum(cos, 0.0), 1.0)
    split = law(ci)
    r: Float32 = (u0 < split.probability).astype(wi.dtype)
    t = 1.0 - r
    inverse: Float32 = 1.0 / eta
    wo: Float32 = (r * (2.0 * ci) + t * (inverse * (ci - split.g))) * m
    wo -= (r + t * inverse) * wi
    dense = eta < fresnel.DENSE
    if dense.any():  # 1/η multiplies what rounding has made of wi and m
        wo = np.where(dense, normalize(wo), wo)

    b2 = b * b
    zi, ti = wi[2], model.stretched(wi, b2, b2)
    ratio = masking_ratio(zi, ti, np.abs(wo[2]), model.stretched(wo, b2, b2))
    invisible = t * (np.abs(eta - 1.0) < NO_INTERFACE)
    ratio += invisible * (1.0 - ratio)
    ratio *= (zi > 0) & (cos > 0) & (wo[2] * (r - t) > 0)
    chosen = split.probability * r + (1.0 - split.probability) * t
    weight = (split.reflected * r + split.transmitted * t) * (ratio / (chosen + (chosen <= 0)))

    # the Jacobian η² |wo·m|/|h|² has |h| = ci − g = −d/(ci + g), which in this form does not cancel
    d = (eta - 1.0) * (eta + 1.0)
    total = ci + split.g
    pdf = model.density(m[0], m[1], m[2], a, a)
    pdf *= 0.5 * r + t * (2.0 * eta) * ci * split.g * total * total / np.maximum(d * d, 1e-9)
    pdf /= zi + ti + (zi <= 0)
    dirac = np.maximum(smooth, t * (1.0 - _is_wide(a, eta)))
    pdf *= 1.0 - dirac
    pdf += dirac
    pdf *= chosen
    return BSDFSample(wo, pdf, weight, _lobes(dirac, t), r + t * eta)


def _is_wide(alpha: Float32, eta: Float32) -> Float32:
    """1 where the refracted lobe is wide enough to be evaluated."""
    wide: Float32 = (alpha * np.abs(eta - 1.0) >= NARROWEST).astype(alpha.dtype)
    return wide


def _lobes(dirac: Float32, t: Float32) -> UInt8:
    bits: Float32 = Lobe.GLOSSY + (Lobe.DELTA - Lobe.GLOSSY) * dirac + Lobe.TRANSMIT * t
    lobe: UInt8 = bits.astype(np.uint8)
    return lobe
