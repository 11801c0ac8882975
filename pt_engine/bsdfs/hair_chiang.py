"""Hair as a rough, coloured dielectric cylinder: Blender's Principled Hair after Chiang.

Light that hits the cylinder at the offset h of its radius is reflected (R, p = 0), passes (TT), is reflected
once inside (TRT) or more often (all the rest, p = 3):

    f·|cosθo| = Σp Ap(h, θi) Mp(θi, θo) Np(φ)        Σ Ap = 1 without absorption

    M = exp(−sinθi' sinθo/v) I0(cosθi' cosθo/v) / (2v sinh(1/v))        of variances v₀, v/4, 4v, 4v
    N = a logistic distribution of scale s about Δφ = 2p γt − 2γ + pπ on [−π, π]; 1/2π for p = 3

θi' is θi tilted by the scales' angle: by −2α, α and 4α. Chiang et al. 2016, "A Practical and Controllable
Hair and Fur Model for Production Path Tracing"; d'Eon et al. 2011 for M. Two departures from Cycles keep M a
distribution and the samples in proportion to it: I0 is Bessel's function to float32's digits (the short
series in pbrt and Cycles loses up to 2 % of M where v is near 0.1), and R is sampled by v₀, not by v.

The frame's tangent is the hair's; its normal has no meaning here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.vectors import cross, dot, mean3, normalize
from . import fresnel
from .base import BSDFSample, Float32, Lobe, UInt8

TRANSMITS = True
PI = float(np.pi)
ONE = np.float32(1.0)
LOBES = 4
TILTS = (-2.0, 1.0, 4.0, 0.0)  # of θi, in α
GREY = (0.2126729, 0.7151522, 0.0721750)
# I0(x) = Σ (x²/4)^k/(k!)², to float32's digits for x ≤ 12; above exp(x)/√(2πx) Σ ((2k − 1)!!)²/(k! (8x)^k)
BESSEL = tuple(1.0 / float(np.prod(np.arange(1, k + 1, dtype=np.float64))) ** 2 for k in range(24))
BEYOND = (1.0, 1.0, 4.5, 37.5, 459.375, 7441.875)
LARGE = 12.0


class Params(NamedTuple):
    """
    Attributes
    ----------
    v, v0 : (N,) float32
        Variance along the hair, and of the first reflection alone (`variance` of a roughness).
    s : (N,) float32
        Scale of the logistic distribution around it (`scale` of a roughness).
    alpha : (N,) float32
        Tilt of the scales toward the root, in radians.
    eta : (N,) float32
        Index of refraction.
    sigma : (3, N) float32
        Absorption per radius.
    h : (N,) float32
        Where the ray hits, over the radius, from −1 to 1 where it grazes: −n·(T × wi)/|T × wi| for the
        cylinder's normal n there, and the hair's tangent T.
    """

    v: Float32
    v0: Float32
    s: Float32
    alpha: Float32
    eta: Float32
    sigma: Float32
    h: Float32


def variance(roughness: Float32) -> Float32:
    """v of a roughness in [0.001, 1]: d'Eon's fit."""
    b: Float32 = np.minimum(np.maximum(roughness, 1e-3), 1.0)
    sharp: Float32 = np.power(b, 20)
    root: Float32 = 0.726 * b + 0.812 * (b * b) + 3.7 * sharp
    return root * root


def scale(roughness: Float32) -> Float32:
    """s of an azimuthal roughness in [0.001, 1]: Chiang's fit."""
    b: Float32 = np.minimum(np.maximum(roughness, 1e-3), 1.0)
    sharp: Float32 = np.power(b, 22)
    s: Float32 = 0.265 * b + 1.194 * (b * b) + 5.372 * sharp
    return s * np.float32(np.sqrt(PI / 8))


# ------------------------------------------------------------------------- the hair as wi sees it


class Fibre(NamedTuple):
    """What depends on wi alone.

    Attributes
    ----------
    across, beside : (3, N) float32
        The unit part of wi across the hair, and the tangent's cross product with it.
    sine, cosine : (N,) float32
        Of θi.
    gamma, gamma_t : (N,) float32
        Angles of incidence in the normal plane, outside and inside.
    share : (4, 3, N) float32
        Ap.
    probability : (4, N) float32
        Of sampling each lobe.
    """

    across: Float32
    beside: Float32
    sine: Float32
    cosine: Float32
    gamma: Float32
    gamma_t: Float32
    share: Float32
    probability: Float32


TANGENT = np.array([[1.0], [0.0], [0.0]], np.float32)


def fibre(params: Params, wi: Float32) -> Fibre:
    """Refraction and absorption at the point that wi hits."""
    sine: Float32 = np.minimum(np.maximum(wi[0], -1.0), 1.0)
    cosine = _cosine(sine)
    across = normalize(np.stack([np.zeros_like(sine), wi[1], wi[2]]))
    h: Float32 = np.minimum(np.maximum(params.h, -1.0), 1.0)
    eta: Float32 = np.maximum(params.eta, 1e-3)
    bent = np.sqrt(np.maximum(eta * eta - sine * sine, 1e-9))
    sine_t: Float32 = np.minimum(np.maximum(h * cosine / bent, -1.0), 1.0)
    cosine_t = np.maximum(_cosine(np.minimum(np.maximum(sine / eta, -1.0), 1.0)), 1e-4)
    path = 2.0 * _cosine(sine_t) / cosine_t
    through = np.exp(-np.maximum(params.sigma, 0.0) * path)
    f = fresnel.dielectric(cosine * _cosine(h), eta)[0]
    share, probability = _shares(f, through)
    beside = cross(TANGENT, across)
    return Fibre(across, beside, sine, cosine, np.arcsin(h), np.arcsin(sine_t), share, probability)


def _shares(f: Float32, through: Float32) -> tuple[Float32, Float32]:
    """Ap: F, (1 − F)² T, (1 − F)² T² F, and the geometric series of what is left; and their probabilities."""
    white = np.broadcast_to(f, through.shape[:1] + np.broadcast_shapes(f.shape, through.shape[1:]))
    tt = (1.0 - f) * (1.0 - f) * through
    trt = tt * through * f
    rest = trt * (through * f) / np.maximum(1.0 - through * f, 1e-6)
    share = np.stack([white, tt, trt, rest])
    grey = share[:, 0] * GREY[0] + share[:, 1] * GREY[1] + share[:, 2] * GREY[2]
    total = grey[0] + grey[1] + grey[2] + grey[3]
    return share, grey / np.maximum(total, 1e-20)


def _cosine(sine: Float32) -> Float32:
    cosine: Float32 = np.sqrt(np.maximum((1.0 - sine) * (1.0 + sine), 0.0))
    return cosine


def tilted(hair: Fibre, alpha: Float32, p: int) -> tuple[Float32, Float32]:
    """Sine and cosine of θi tilted for lobe p."""
    if TILTS[p] == 0:
        return hair.sine, hair.cosine
    angle = alpha * np.float32(TILTS[p])
    c, s = np.cos(angle), np.sin(angle)
    return hair.sine * c + hair.cosine * s, np.abs(hair.cosine * c - hair.sine * s)


def lobe_variance(params: Params, p: int) -> Float32:
    """v of lobe p."""
    if p == 0:
        return params.v0
    return params.v * np.float32(0.25 if p == 1 else 4.0)


def turn(hair: Fibre, p: int) -> Float32:
    """Δφ of lobe p < 3."""
    delta: Float32 = 2.0 * p * hair.gamma_t - 2.0 * hair.gamma + np.float32(p * PI)
    return delta


# ------------------------------------------------------------------------- the two laws


def longitudinal(sine: Float32, cosine: Float32, sine_o: Float32, cosine_o: Float32, v: Float32) -> Float32:
    """M; the exponents are joined to −((cosθi − cosθo)² + (sinθi + sinθo)²)/2v, in which nothing cancels."""
    inverse: Float32 = 1.0 / v
    x = cosine * cosine_o * inverse
    apart, above = cosine - cosine_o, sine + sine_o
    exponent = -0.5 * inverse * (apart * apart + above * above)
    norm = inverse / np.maximum(1.0 - np.exp(-2.0 * inverse), 1e-6)
    m: Float32 = np.exp(np.maximum(exponent, -80.0)) * _bessel_scaled(x) * norm
    return m


def _bessel_scaled(x: Float32) -> Float32:
    """exp(−x) I0(x) for x ≥ 0: the series, and above 12 the asymptotic expansion to 1e-6."""
    small: Float32 = np.minimum(x, LARGE)
    y: Float32 = 0.25 * small * small
    series = _power_series(BESSEL, y)
    large: Float32 = np.maximum(x, LARGE)
    r: Float32 = 1.0 / (8.0 * large)
    tail = _power_series(BEYOND, r)
    root: Float32 = np.sqrt(np.float32(2.0 * PI) * large)
    expansion: Float32 = tail / root
    decay: Float32 = np.exp(-small)
    inside = x <= LARGE
    scaled: Float32 = series * decay * inside + expansion * ~inside
    return scaled


def _power_series(coefficients: tuple[float, ...], x: Float32) -> Float32:
    """Σ c_k x^k."""
    total: Float32 = np.full_like(x, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        total = total * x + np.float32(coefficient)
    return total


def azimuthal(phi: Float32, s: Float32) -> Float32:
    """N: a logistic distribution of scale s, cut off at ±π; φ in any turn."""
    x = phi - np.float32(2.0 * PI) * np.round(phi * np.float32(0.5 / PI))
    e: Float32 = np.exp(-np.abs(x) / s)
    n: Float32 = e / (s * (1.0 + e) * (1.0 + e) * _within(s))
    return n


def _within(s: Float32) -> Float32:
    """How much of the logistic distribution lies within ±π: tanh(π/2s)."""
    share: Float32 = np.tanh(np.float32(0.5 * PI) / s)
    return share


def draw_azimuth(u: Float32, s: Float32) -> Float32:
    """x of density N: s log(q/(1 − q)) = 2s artanh(2q − 1), q uniform between the tails."""
    q = (2.0 * u - 1.0) * _within(s)
    x: Float32 = 2.0 * s * np.arctanh(np.minimum(np.maximum(q, -1.0 + 6e-8), 1.0 - 6e-8))
    return np.minimum(np.maximum(x, -PI), PI)


# ------------------------------------------------------------------------- the contract


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·|cosθo| (3, N) and pdf (N,), on both sides of the surface."""
    return _eval(params, fibre(params, wi), wi, wo)


def _eval(params: Params, hair: Fibre, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    sine_o: Float32 = np.minimum(np.maximum(wo[0], -1.0), 1.0)
    cosine_o = _cosine(sine_o)
    phi = np.arctan2(dot(wo, hair.beside), dot(wo, hair.across))
    value = np.zeros((3, wo.shape[1]), np.float32)
    pdf = np.zeros(wo.shape[1], np.float32)
    for p in range(LOBES):
        m = longitudinal(*tilted(hair, params.alpha, p), sine_o, cosine_o, lobe_variance(params, p))
        n = azimuthal(phi - turn(hair, p), params.s) if p < 3 else np.float32(0.5 / PI)
        mn = m * n * (wi[2] > 0)
        value += hair.share[p] * mn
        pdf += hair.probability[p] * mn
    return value, pdf


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw a lobe by `u0`, θo by what is left of it and `u1`, φ by `u2`."""
    hair = fibre(params, wi)
    n = wi.shape[1]
    sine_o, phi, left = np.zeros(n, np.float32), np.zeros(n, np.float32), u0
    chosen_before = np.zeros(n, np.bool_)
    lobe = np.zeros(n, np.float32)
    for p in range(LOBES):
        probability = hair.probability[p]
        chosen = (left < probability) & ~chosen_before if p < 3 else ~chosen_before
        u = np.minimum(left / np.maximum(probability, 1e-20), ONE)
        angle = turn(hair, p) + draw_azimuth(u2, params.s) if p < 3 else np.float32(2.0 * PI) * u2
        sine_o += chosen * draw_sine(*tilted(hair, params.alpha, p), lobe_variance(params, p), u, u1)
        phi += chosen * angle
        lobe += chosen * np.float32(p > 0)
        left = left - probability
        chosen_before |= chosen
    cosine_o = _cosine(sine_o)
    wo = sine_o * TANGENT + (np.cos(phi) * cosine_o) * hair.across + (np.sin(phi) * cosine_o) * hair.beside
    wo = normalize(wo)
    value, pdf = _eval(params, hair, wi, wo)
    weight = value * (pdf > 0) / (pdf + (pdf <= 0))
    bits: UInt8 = (Lobe.GLOSSY + Lobe.TRANSMIT * lobe).astype(np.uint8)
    return BSDFSample(wo, pdf, weight, bits)


def draw_sine(sine: Float32, cosine: Float32, v: Float32, u: Float32, u1: Float32) -> Float32:
    """sinθo by M: d'Eon et al. 2013, "Importance Sampling for Physically-Based Hair Fiber Models"."""
    floor = np.exp(-2.0 / v)
    u = np.maximum(u, 1e-5)
    c = np.minimum(np.maximum(1.0 + v * np.log(u + (1.0 - u) * floor), -1.0), 1.0)
    drawn: Float32 = -c * sine + _cosine(c) * np.cos(np.float32(2.0 * PI) * u1) * cosine
    return np.minimum(np.maximum(drawn, -1.0), 1.0)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """What is reflected and what passes through the middle, roughly: mean over the colours."""
    f0 = fresnel.normal_incidence(np.maximum(params.eta, 1e-3))
    through = mean3(np.exp(-np.maximum(params.sigma, 0.0)))
    share: Float32 = f0 + (1.0 - f0) * through
    return share
