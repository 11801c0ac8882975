"""Light that hair lets through (Blender's Hair BSDF): p(θo) of `hair_lobe` times an azimuth about −wi,

    p(φ) = β/(c (q² + β²))        q = π − |φ|,  c = 2 atan(π/2β)

on the far side of the surface. It is drawn for q ≤ π/2, where it integrates to 1; the little that lies
beyond, as Cycles has it, is left to the sampling of lights.
"""

from __future__ import annotations

import numpy as np

from . import hair_lobe
from .base import BSDFSample, Float32, Lobe
from .hair_lobe import HALF_PI, Params, albedo

SPECULAR = True
TRANSMITS = True

__all__ = ["Params", "albedo", "eval_pdf", "sample"]


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·|cosθo| (1, N) and pdf (N,)."""
    p, phi = hair_lobe.along(params, hair_lobe.fibre(params, wi), wo)
    beta = hair_lobe.clamped(params.roughness_v)
    q = np.float32(np.pi) - phi
    value: Float32 = p * beta / (2.0 * np.arctan(HALF_PI / beta) * (q * q + beta * beta))
    value *= (wi[2] > 0) & (wo[2] < 0)
    return value[np.newaxis], value * (q <= HALF_PI)


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw θo and φ by their laws; the weight is 1 but on the viewer's side."""
    beta = hair_lobe.clamped(params.roughness_v)
    reach = np.arctan(HALF_PI / beta)
    phi = np.float32(np.pi) + beta * np.tan((2.0 * u2 - 1.0) * reach)
    wo = hair_lobe.direction(params, hair_lobe.fibre(params, wi), u1, phi)
    value, pdf = eval_pdf(params, wi, wo)
    weight: Float32 = value * (pdf > 0) / (pdf + (pdf <= 0))
    return BSDFSample(wo, pdf, weight, Lobe.GLOSSY | Lobe.TRANSMIT)
