"""Ashikhmin and Shirley's glossy reflection: Phong's lobe of the half vector, stretched along the tangents.

    f·cosθo = c cosθo cos^e θh / (cosθd max(cosθi, cosθo))        pdf = c cos^e θh / cosθd
    c = √((nx + 1)(ny + 1))/(8π)      e = nx cos²φh + ny sin²φh      n = 2/α² − 2

Ashikhmin and Shirley 2000, "An Anisotropic Phong BRDF Model", eqs. 4 to 9, without its Fresnel factor and
diffuse base, as in Cycles; θh, φh are the half vector's angles, θd that between it and wi. The closure's
weight is its colour. Up to α = 1e-4 both ways it is an ideal mirror.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.vectors import dot
from .base import BSDFSample, Float32
from .reflection import lobes

SPECULAR = True
SMOOTH = 1e-4
PI = float(np.pi)


class Params(NamedTuple):
    """
    Attributes
    ----------
    alpha_x, alpha_y : (N,) float32
        Roughness along the frame's tangent and bitangent; `alpha_y` None: isotropic.
    """

    alpha_x: Float32
    alpha_y: Float32 | None = None


class Exponents(NamedTuple):
    """nx, ny (one and the same array if isotropic), and 1 on mirrors: (N,) or (1,) each."""

    x: Float32
    y: Float32
    smooth: Float32


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·cosθo (1, N) and pdf (N,), 0 below the surface."""
    n = _exponents(params)
    h = wi + wo
    length: Float32 = np.maximum(np.sqrt(dot(h, h)), 1e-6)
    h = h / length
    cos_d: Float32 = 0.5 * length
    pdf: Float32 = _density(n, h, cos_d) * ((wi[2] > 0) & (wo[2] > 0) & (n.smooth == 0))
    return (pdf * _ratio(wi, wo))[np.newaxis], pdf


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Mirror wi in a half vector drawn from the lobe; from the far side it has no mirror image above."""
    n = _exponents(params)
    azimuth, e = _azimuth(n, u1)
    power = np.log1p(-u2) / (e + 1.0)  # cosθh = (1 − u2)^(1/(e + 1))
    cos = np.exp(power)
    sin = np.sqrt(-np.expm1(2.0 * power)) * (1.0 - n.smooth)
    h = np.stack([sin * azimuth[0], sin * azimuth[1], cos + (1.0 - cos) * n.smooth])
    cos_d = dot(wi, h)
    wo = (2.0 * cos_d) * h
    wo -= wi
    above = (cos_d > 0) & (wo[2] > 0)
    pdf = _density(n, h, np.maximum(cos_d, 1e-6)) * (1.0 - n.smooth) + n.smooth
    weight: Float32 = (_ratio(wi, wo) * (1.0 - n.smooth) + n.smooth) * above
    return BSDFSample(wo, pdf, weight[np.newaxis], lobes(n.smooth))


def albedo(params: Params, cos_i: Float32) -> Float32:
    """1."""
    return np.ones(1, np.float32)


def _exponents(params: Params) -> Exponents:
    x: Float32 = np.minimum(np.maximum(params.alpha_x, SMOOTH), 1.0)
    y: Float32 = x if params.alpha_y is None else np.minimum(np.maximum(params.alpha_y, SMOOTH), 1.0)
    smooth = (np.maximum(x, y) <= SMOOTH).astype(np.float32)
    nx: Float32 = 2.0 / (x * x) - 2.0
    ny: Float32 = nx if y is x else 2.0 / (y * y) - 2.0
    return Exponents(nx, ny, smooth)


def _ratio(wi: Float32, wo: Float32) -> Float32:
    """f·cosθo over pdf: cosθo/max(cosθi, cosθo)."""
    larger: Float32 = np.maximum(np.maximum(wi[2], wo[2]), 1e-6)
    ratio: Float32 = np.maximum(wo[2], 0.0)
    return ratio / larger


def _density(n: Exponents, h: Float32, cos_d: Float32) -> Float32:
    """c cos^e θh/cosθd; the power by the half vector's sine, so that a cosine near 1 keeps its digits."""
    sin2 = h[0] * h[0] + h[1] * h[1]
    if n.x is n.y:
        e = n.x
        c: Float32 = n.x + 1.0
    else:
        e = n.x * h[0] * h[0] + n.y * h[1] * h[1]
        e /= np.maximum(sin2, 1e-30)
        product: Float32 = (n.x + 1.0) * (n.y + 1.0)
        c = np.sqrt(product)
    log_cos: Float32 = 0.5 * np.log1p(-np.minimum(sin2, np.float32(1 - 2**-24)))
    density: Float32 = c * np.exp(e * log_cos) * (0.125 / PI)
    density /= np.maximum(cos_d, 1e-6)
    return density


def _azimuth(n: Exponents, u: Float32) -> tuple[tuple[Float32, Float32], Float32]:
    """Cosine and sine of φh drawn from its density, and the exponent there.

    Within a quadrant tan φh = √((nx + 1)/(ny + 1)) tan(π u/2) (eq. 9); of a whole turn likewise, as both
    tangents stand for directions (cos, sin) that keep their quadrant.
    """
    turn = u * np.float32(2.0 * PI)
    cos, sin = np.cos(turn), np.sin(turn)
    if n.x is n.y:
        return (cos, sin), n.x
    sin = sin * np.sqrt((n.x + 1.0) / (n.y + 1.0))
    scale = 1.0 / np.sqrt(cos * cos + sin * sin)
    cos, sin = cos * scale, sin * scale
    return (cos, sin), n.x * cos * cos + n.y * sin * sin
