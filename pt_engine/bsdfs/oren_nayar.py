"""Rough diffuse reflection that keeps its energy: Oren-Nayar as improved by Fujii, with its missing light.

    f = a + b t + M (1 − E(θi))(1 − E(θo))          t = s / max(cosθi, cosθo) if s > 0 else s
    s = wi·wo − cosθi cosθo        a = 1/(π + σ(π/2 − 2/3))        b = σ a

Y. Fujii, "A tiny improvement of Oren-Nayar reflectance model": the single-scattering part, whose albedo
is E(θ) = π a + b G(θ), on average Ē. The rest is spread so that albedo 1 reflects all light, and colour
ρ as often as it bounces (OpenPBR): M = ρ² Ē/(1 − Ē) / (1 − ρ(1 − Ē)) / π, per unit of the closure's
weight as Cycles has it (OpenPBR has one ρ less there). σ is Blender's roughness; σ = 0 is Lambert.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core import vectors, warps
from .base import BSDFSample, Float32, Lobe

PI = float(np.pi)
SIGMA_A = PI / 2 - 2 / 3
AVERAGE_G = (2 * PI - 5.6) / 3  # 2∫ G(θ) cosθ d(cosθ) = (2π − 28/5)/3


class Params(NamedTuple):
    """
    Attributes
    ----------
    roughness : (N,) float32 in [0, 1]
    color : (3, N) float32 in [0, 1]
        Of multiple scattering; the closure's weight carries the colour itself.
    """

    roughness: Float32
    color: Float32


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·cosθo (3, N) and pdf (N,), 0 below the surface."""
    pdf = warps.cosine_hemisphere_pdf(wo)
    return _reflectance(params, wi, wo) * pdf, pdf


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw wo in proportion to its cosine; the weight is π f."""
    wo = warps.square_to_cosine_hemisphere(u1, u2)
    return BSDFSample(wo, warps.cosine_hemisphere_pdf(wo), _reflectance(params, wi, wo), Lobe.DIFFUSE)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """Nearly 1, per unit of the closure's weight."""
    return np.ones(1, np.float32)


def _reflectance(params: Params, wi: Float32, wo: Float32) -> Float32:
    """π f: (3, N)."""
    sigma: Float32 = np.minimum(np.maximum(params.roughness, 0.0), 1.0)
    color: Float32 = np.minimum(np.maximum(params.color, 0.0), 1.0)
    a: Float32 = PI / (PI + sigma * SIGMA_A)
    b: Float32 = sigma * a
    cos_i, cos_o = np.maximum(wi[2], 0.0), np.maximum(wo[2], 0.0)
    s = vectors.dot(wi, wo) - cos_i * cos_o
    forward = s > 0
    larger = np.maximum(np.maximum(cos_i, cos_o), 1e-9)  # s ≤ √… ≤ 1 there, so the quotient stays finite
    t = s / (larger + (1.0 - larger) * ~forward)
    average = a + b * (AVERAGE_G / PI)
    # where nothing is missing, nothing is lost either
    missing: Float32 = np.maximum(1.0 - average, 1e-9)
    scale: Float32 = color * color * average / missing
    scale = scale / (1.0 - color * missing)
    lost: Float32 = (1.0 - _albedo(a, b, cos_i)) * (1.0 - _albedo(a, b, cos_o))
    f: Float32 = scale * lost
    f += np.maximum(a + b * t, 0.0)  # a = b at σ = 1, and t ≥ −1 but for rounding
    return f


def _albedo(a: Float32, b: Float32, cos: Float32) -> Float32:
    """E(θ) of the single-scattering part, a and b here being π a and π b."""
    return a + b * (_g(cos) * np.float32(1 / PI))


def _g(cos: Float32) -> Float32:
    """Fujii's G(θ) = sinθ(θ − 2/3 − sinθ cosθ) + ⅔ tanθ (1 − sin³θ), which tends to π/2 − 2/3 at grazing.

    With 1 − s³ = (1 − s)(1 + s + s²) = c²(1 + s + s²)/(1 + s), the tangent's 1/c goes.
    """
    c = np.minimum(cos, 1.0)
    s = np.sqrt((1.0 - c) * (1.0 + c))
    g: Float32 = s * (np.arccos(c) - 2 / 3 - s * c + (2 / 3) * c * (1.0 + s + s * s) / (1.0 + s))
    return g
