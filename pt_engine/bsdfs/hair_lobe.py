"""Hair as a cylinder that shines in one lobe: what `hair_reflection` and `hair_transmission` have in common.

With the tangent T, the angles θ of wi and wo above T's normal plane, their mean θh and t = θh − offset,

    p(θo) = β / (2 (t² + β²) (a − b) cosθo)        a, b = atan(((±π/2 + θi)/2 − offset)/β)

per solid angle: a Cauchy distribution of θh, cut off where θo would leave [−π/2, π/2]. The azimuth φ from wi
has a law of its own; f·|cosθo| is the product of both, for directions on one side of the surface. After
Marschner et al. 2003, "Light Scattering from Human Hair Fibers", as in Cycles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.vectors import cross, dot, normalize
from .base import Float32

HALF_PI = np.float32(np.pi / 2)
POLE = np.float32(1e-3)  # rad; light so nearly along the hair is left out, as in Cycles


class Params(NamedTuple):
    """
    Attributes
    ----------
    roughness_u, roughness_v : (N,) float32
        β along the hair and around it, in radians; within [0.001, 1].
    offset : (N,) float32
        By how much the lobe is tilted along the hair, in radians.
    lean : (N,) float32 or None
        Cosine between T and the frame's normal; the rest of T is along the frame's tangent. None is 0.
    """

    roughness_u: Float32
    roughness_v: Float32
    offset: Float32
    lean: Float32 | None = None


class Fibre(NamedTuple):
    """T, the unit part of wi across it, θi, and the longitudinal β, a and b."""

    tangent: Float32
    across: Float32
    theta: Float32
    beta: Float32
    a: Float32
    b: Float32


def fibre(params: Params, wi: Float32) -> Fibre:
    """The hair as `wi` sees it."""
    tangent = np.array([[1.0], [0.0], [0.0]], np.float32)
    if params.lean is not None:
        lean = np.minimum(np.maximum(params.lean, -1.0), 1.0)
        tangent = np.stack([np.sqrt(1.0 - lean * lean), np.zeros_like(lean), lean])
    sine = dot(tangent, wi)
    theta: Float32 = np.arcsin(np.minimum(np.maximum(sine, -1.0), 1.0))
    beta = clamped(params.roughness_u)
    a: Float32 = np.arctan(((theta + HALF_PI) * 0.5 - params.offset) / beta)
    b: Float32 = np.arctan(((theta - HALF_PI) * 0.5 - params.offset) / beta)
    return Fibre(tangent, normalize(wi - sine * tangent), theta, beta, a, b)


def clamped(roughness: Float32) -> Float32:
    """β within [0.001, 1]."""
    beta: Float32 = np.minimum(np.maximum(roughness, 1e-3), 1.0)
    return beta


def along(params: Params, hair: Fibre, wo: Float32) -> tuple[Float32, Float32]:
    """p(θo), and |φ|."""
    sine = dot(hair.tangent, wo)
    theta: Float32 = np.arcsin(np.minimum(np.maximum(sine, -1.0), 1.0))
    t: Float32 = 0.5 * (theta + hair.theta) - params.offset
    cos: Float32 = np.maximum(np.cos(theta), POLE)
    width: Float32 = (t * t + hair.beta * hair.beta) * (hair.a - hair.b) * cos
    p: Float32 = hair.beta / (2.0 * width)
    p *= HALF_PI - np.abs(theta) >= POLE
    cos_phi = dot(normalize(wo - sine * hair.tangent), hair.across)
    phi: Float32 = np.arccos(np.minimum(np.maximum(cos_phi, -1.0), 1.0))
    return p, phi


def direction(params: Params, hair: Fibre, u: Float32, phi: Float32) -> Float32:
    """wo at azimuth φ, its θo drawn by `u`."""
    theta: Float32 = 2.0 * (hair.beta * np.tan(u * (hair.a - hair.b) + hair.b) + params.offset) - hair.theta
    cos: Float32 = np.cos(theta)
    forth: Float32 = np.cos(phi) * cos
    beside: Float32 = np.sin(phi) * cos
    up: Float32 = np.sin(theta)
    wo = forth * hair.across - beside * cross(hair.across, hair.tangent) + up * hair.tangent
    return normalize(wo)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """1."""
    return np.ones(1, np.float32)
