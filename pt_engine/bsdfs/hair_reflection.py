"""Light that hair reflects (Blender's Hair BSDF): p(θo) of `hair_lobe` times an azimuth about wi,

    p(φ) = cos(φ/2β)/(4β)        |φ| ≤ min(πβ, π/2)

on the viewer's side of the surface. What would lie beyond π/2, or behind, is lost.
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
    around: Float32 = np.maximum(np.cos(np.minimum(phi * (0.5 / beta), HALF_PI)), 0.0) * (0.25 / beta)
    value: Float32 = p * around
    value *= (wi[2] > 0) & (wo[2] > 0) & (phi <= HALF_PI)
    return value[np.newaxis], value / _kept(beta)


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw θo and φ by their laws; the weight is the share of the azimuth's that is kept."""
    beta = hair_lobe.clamped(params.roughness_v)
    phi = (2.0 * beta) * np.arcsin((1.0 - 2.0 * u2) * _kept(beta))
    wo = hair_lobe.direction(params, hair_lobe.fibre(params, wi), u1, phi)
    value, pdf = eval_pdf(params, wi, wo)
    weight: Float32 = value * (pdf > 0) / (pdf + (pdf <= 0))
    return BSDFSample(wo, pdf, weight, Lobe.GLOSSY)


def _kept(beta: Float32) -> Float32:
    """The share of p(φ) within ±π/2: sin(π/4β), 1 for β ≤ 1/2."""
    share: Float32 = np.sin(np.minimum(np.float32(np.pi / 4) / beta, HALF_PI))
    return share
