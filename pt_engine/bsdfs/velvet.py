"""Velvet: facets that stand on edge, so that light grazes them toward the rim (Blender's Ashikhmin sheen).

    f·cosθo = D G/(4 cosθi)          D = exp(−cot²θh/σ²)/(π σ² sin⁴θh)
    G = min(1, 2 cosθh cosθi/cosθd, 2 cosθh cosθo/cosθd)          pdf = 1/(2π)

Ashikhmin, Premože and Shirley 2000, "A Microfacet-Based BRDF Generator", with D as Cycles normalises it;
θh is the half vector's angle, θd that between it and wi. Its albedo is 1 at grazing and falls toward the
normal, the faster the smaller σ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core import warps
from ..core.vectors import dot
from .base import BSDFSample, Float32, Lobe

INV_PI = float(warps.INV_PI)
LEAST_SIGMA = 0.01
EDGE = 1e-5  # Cycles evaluates no half vector this close to the normal or at a right angle to wi
TINY = 1e-37


class Params(NamedTuple):
    """
    Attributes
    ----------
    sigma : (N,) float32 in [0, 1]
        How far the facets lean.
    """

    sigma: Float32


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·cosθo (1, N) and pdf (N,), 0 below the surface."""
    pdf = warps.hemisphere_pdf(wo)
    return _value(params, wi, wo)[np.newaxis], pdf


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw wo evenly from the hemisphere."""
    wo = warps.square_to_hemisphere(u1, u2)
    weight: Float32 = _value(params, wi, wo) * (2.0 * warps.PI)
    return BSDFSample(wo, warps.hemisphere_pdf(wo), weight[np.newaxis], Lobe.DIFFUSE)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """1: what it reflects depends on the angle too much for a closed form."""
    return np.ones(1, np.float32)


def _value(params: Params, wi: Float32, wo: Float32) -> Float32:
    sigma: Float32 = np.maximum(params.sigma, LEAST_SIGMA)
    inverse = 1.0 / (sigma * sigma)
    h = wi + wo
    length = np.sqrt(dot(h, h))
    cos_h = h[2] / (length + TINY)
    cos_d = 0.5 * length
    valid = (wi[2] > EDGE) & (wo[2] > 0) & (cos_h < 1.0 - EDGE) & (cos_d > EDGE)
    sin2 = np.maximum((h[0] * h[0] + h[1] * h[1]) / (length * length + TINY), EDGE)
    density = np.exp(-(cos_h * cos_h) / sin2 * inverse) * (inverse * INV_PI) / (sin2 * sin2)
    # of G/cosθi no quotient by a vanishing cosine is left
    ratio = 2.0 * np.maximum(cos_h / np.maximum(cos_d, EDGE), EDGE)
    cos_i = np.maximum(wi[2], EDGE)
    shadowing = np.minimum(np.minimum(1.0, ratio * wo[2]) / cos_i, ratio)
    value: Float32 = 0.25 * density * shadowing * valid
    return value
