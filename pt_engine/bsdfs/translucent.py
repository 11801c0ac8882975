"""Lambertian transmission: diffuse light on the other side. Its colour is the closure's weight.

f(wi, wo) = 1/π for cosθo < 0          pdf(wo) = |cosθo|/π          weight = 1
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core import warps
from .base import BSDFSample, Float32, Lobe

TRANSMITS = True
SPECULAR = True  # of its normal Cycles makes what it makes of a mirror's


class Params(NamedTuple):
    """None: the colour is the closure's weight."""


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·|cosθo| (1, N) and pdf (N,): the same numbers, 0 on the viewer's side."""
    pdf: Float32 = np.maximum(-wo[2], 0.0) * np.float32(warps.INV_PI)
    return pdf[np.newaxis], pdf


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw wo in proportion to its cosine, on the far side."""
    wo = warps.square_to_cosine_hemisphere(u1, u2)
    pdf = warps.cosine_hemisphere_pdf(wo)
    np.negative(wo[2], out=wo[2])
    return BSDFSample(wo, pdf, np.ones((1, len(u1)), np.float32), Lobe.DIFFUSE | Lobe.TRANSMIT)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """1."""
    return np.ones(1, np.float32)
