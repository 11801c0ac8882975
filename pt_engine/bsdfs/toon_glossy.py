"""Glossy toon: `toon`'s disk about the mirror direction. What of it is below the horizon is lost."""

from __future__ import annotations

import numpy as np

from ..core import frames, warps
from .base import BSDFSample, Float32, Lobe
from .toon import Params, albedo, cone_of, even_pdf, intensity

__all__ = ["Params", "albedo", "eval_pdf", "sample"]


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·cosθo (1, N) and pdf (N,), 0 below the surface."""
    cone, mirror = cone_of(params), _mirrored(wi)
    local = frames.to_local(*frames.frame(mirror), mirror, wo)
    pdf: Float32 = warps.cone_pdf(local, cone.rim) * (wo[2] > 0)
    return (pdf * intensity(cone, local))[np.newaxis], pdf


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw wo evenly from the cone."""
    cone, mirror = cone_of(params), _mirrored(wi)
    local = warps.square_to_cone(u1, u2, cone.rim)
    wo = frames.to_world(*frames.frame(mirror), mirror, local)
    weight: Float32 = intensity(cone, local) * (wo[2] > 0)
    return BSDFSample(wo, even_pdf(cone, wo), weight[np.newaxis], Lobe.GLOSSY)


def _mirrored(wi: Float32) -> Float32:
    return np.stack([-wi[0], -wi[1], wi[2]])
