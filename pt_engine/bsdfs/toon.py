"""Diffuse toon: an even disk of light about the normal, with a soft edge; its colour is the closure's weight.

    f·cosθo = pdf · I(θ)        pdf = 1/(2π (1 − cos θmax)), θmax = min(size + smooth, π/2)
    I = 1 up to θ = size, falling linearly to 0 over `smooth`

θ is wo's angle from the normal; there is no cosine law. As in Cycles the lobe ends at a right angle, without
a gain for what that cuts off. `toon_glossy` is the same about the mirror direction.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core import warps
from .base import BSDFSample, Float32, Lobe

HALF_PI = float(np.pi / 2)
LEAST_SIZE = 1e-5
NO_SMOOTH = 1e-20  # below it quotients overflow


class Params(NamedTuple):
    """
    Attributes
    ----------
    size, smooth : (N,) float32 in [0, 1]
        Of a right angle.
    """

    size: Float32
    smooth: Float32


class Cone(NamedTuple):
    """Angle (N,) at which the light starts to fall, over how much it does, and 1 − cos θmax."""

    size: Float32
    smooth: Float32
    rim: Float32


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·cosθo (1, N) and pdf (N,), 0 below the surface."""
    cone = cone_of(params)
    pdf: Float32 = warps.cone_pdf(wo, cone.rim) * (wo[2] >= 0)
    return (pdf * intensity(cone, wo))[np.newaxis], pdf


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw wo evenly from the cone."""
    cone = cone_of(params)
    wo = warps.square_to_cone(u1, u2, cone.rim)
    return BSDFSample(wo, even_pdf(cone, wo), intensity(cone, wo)[np.newaxis], Lobe.DIFFUSE)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """1."""
    return np.ones(1, np.float32)


def cone_of(params: Params) -> Cone:
    """The lobe's angles."""
    size: Float32 = np.minimum(np.maximum(params.size, LEAST_SIZE), 1.0)
    smooth: Float32 = np.minimum(np.maximum(params.smooth, 0.0), 1.0)
    half: Float32 = np.sin(np.minimum(size + smooth, 1.0) * np.float32(0.5 * HALF_PI))
    return Cone(size * np.float32(HALF_PI), smooth * np.float32(HALF_PI), 2.0 * half * half)


def even_pdf(cone: Cone, wo: Float32) -> Float32:
    """The density within the cone: (N,)."""
    return np.broadcast_to(np.float32(warps.INV_2PI) / cone.rim, wo.shape[1:])


def intensity(cone: Cone, local: Float32) -> Float32:
    """I of directions (3, N) relative to the cone's axis: (N,)."""
    angle = np.arctan2(np.sqrt(local[0] * local[0] + local[1] * local[1]), local[2])
    beyond: Float32 = np.maximum(angle - cone.size, 0.0)
    hard = cone.smooth < NO_SMOOTH  # then nothing is left beyond the size
    left: Float32 = 1.0 - beyond / (cone.smooth + hard) - hard * (beyond > 0)
    return np.maximum(left, 0.0)
