"""Reflection off a rough surface whose facets reflect by some Fresnel law: conductors, coats, gloss.

    f·cosθo = F(wi·m) D(m) G2(wi, wo)/(4 cosθi),  m = (wi + wo)/|wi + wo|        pdf = D_visible(m)/(4 wi·m)

Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces". With the half vector
h = wi + wo, wi·m = |h|/2. See `microfacet` for the forms without quotients by cosines. Lanes as smooth as
`microfacet.SMOOTH` are ideal mirrors.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..core.vectors import dot
from .base import BSDFSample, Float32, Lobe, UInt8
from .microfacet import Distribution, masking_ratio, roughness, squares

Fresnel = Callable[[Float32], Float32]  # cosine against the facet (N,) → reflectance (3, N) or (1, N)


def eval_pdf(
    model: type[Distribution],
    alpha: tuple[Float32, Float32 | None],
    fresnel: Fresnel,
    wi: Float32,
    wo: Float32,
) -> tuple[Float32, Float32]:
    """f·cosθo (3, N) or (1, N) and pdf (N,)."""
    ax, ay, smooth = roughness(*alpha)
    ax2, ay2 = squares(ax, ay)
    zi, zo = np.maximum(wi[2], 0.0), np.maximum(wo[2], 0.0)
    valid = (wi[2] > 0) & (wo[2] > 0) & (smooth == 0)
    h = wi + wo
    h2 = dot(h, h)
    ti = model.stretched(wi, ax2, ay2)
    pdf = model.density(h[0], h[1], h[2], ax, ay)
    pdf *= h2 * h2
    pdf /= 2.0 * (zi + ti)
    pdf *= valid
    ratio = masking_ratio(zi, ti, zo, model.stretched(wo, ax2, ay2))
    ratio *= pdf
    cos: Float32 = np.sqrt(h2)
    cos *= 0.5
    return fresnel(cos) * ratio, pdf


def sample(
    model: type[Distribution],
    alpha: tuple[Float32, Float32 | None],
    fresnel: Fresnel,
    wi: Float32,
    u1: Float32,
    u2: Float32,
) -> BSDFSample:
    """Mirror wi in a visible facet."""
    ax, ay, smooth = roughness(*alpha)
    rough = 1.0 - smooth
    bx = ax * rough
    by = bx if ax is ay else ay * rough
    bx2, by2 = squares(bx, by)
    m = model.visible_normal(wi, bx, by, u1, u2)
    cos = dot(wi, m)
    wo = (2.0 * cos) * m
    wo -= wi
    zi, zo = np.maximum(wi[2], 0.0), np.maximum(wo[2], 0.0)
    ti = model.stretched(wi, bx2, by2)
    ratio = masking_ratio(zi, ti, zo, model.stretched(wo, bx2, by2))
    ratio *= (wi[2] > 0) & (wo[2] > 0)
    pdf = model.density(m[0], m[1], m[2], ax, ay)
    pdf /= 2.0 * (zi + ti)
    if smooth.any():  # a probability on mirrors
        pdf = pdf * rough + smooth
    return BSDFSample(wo, pdf, fresnel(cos) * ratio, lobes(smooth))


def lobes(smooth: Float32) -> UInt8 | int:
    """Glossy, or Dirac where `smooth` is 1."""
    if smooth.size == 1:
        return Lobe.DELTA if smooth[0] else Lobe.GLOSSY
    per_lane: UInt8 = (Lobe.GLOSSY + (Lobe.DELTA - Lobe.GLOSSY) * smooth).astype(np.uint8)
    return per_lane
