"""Lambertian reflection of a perfectly white surface; its colour is the closure's weight.

f(wi, wo) = 1/π          pdf(wo) = cosθo/π          weight = f·cosθo/pdf = 1
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core import warps
from ..core.vectors import dot
from .base import BSDFSample, Float32, Lobe

INV_PI = np.float32(1 / np.pi)
ONE = np.ones((1, 1), np.float32)


class Params(NamedTuple):
    """None: the colour is the closure's weight."""


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·cosθo (1, N) and pdf (N,): the same numbers, 0 below the surface."""
    pdf = warps.cosine_hemisphere_pdf(wo)
    return pdf[np.newaxis], pdf


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw wo in proportion to its cosine."""
    wo = warps.square_to_cosine_hemisphere(u1, u2)
    return BSDFSample(wo, warps.cosine_hemisphere_pdf(wo), np.ones((1, len(u1)), np.float32), Lobe.DIFFUSE)


def eval_pdf_about(params: Params, cos_o: Float32) -> tuple[Float32, Float32]:
    """`eval_pdf` for callers that know the cosine and so need no frame: value (1, N) and pdf (N,)."""
    pdf = np.maximum(cos_o, 0) * INV_PI
    return pdf[np.newaxis], pdf


def sample_about(params: Params, n: Float32, u1: Float32, u2: Float32) -> tuple[BSDFSample, Float32]:
    """`sample` without a frame: n (3, N) plus a point on the unit sphere, normalised, is cosine-distributed.

    Returns
    -------
    BSDFSample
        With `wo` in the space of `n`.
    cos_o : (N,) float32
    """
    wo = n + warps.square_to_sphere(u1, u2)
    # 1e-6 is the sphere's far pole: there the sum has no direction, and the cosine is 0 anyway
    wo *= 1 / np.sqrt(np.maximum(dot(wo, wo), np.float32(1e-12)))
    cos_o = dot(n, wo)
    pdf = np.maximum(cos_o, 0) * INV_PI
    return BSDFSample(wo, pdf, ONE, Lobe.DIFFUSE), cos_o


def albedo(params: Params, cos_i: Float32) -> Float32:
    """1."""
    return np.ones(1, np.float32)
