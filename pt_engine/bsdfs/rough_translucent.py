"""Rough diffuse transmission: what `oren_nayar` reflects toward wo', wo mirrored at the surface."""

from __future__ import annotations

import numpy as np

from . import oren_nayar
from .base import BSDFSample, Float32, Lobe
from .oren_nayar import Params, albedo
from .thin_transmission import across

TRANSMITS = True

__all__ = ["Params", "albedo", "eval_pdf", "sample"]


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·|cosθo| (3, N) and pdf (N,), 0 on the viewer's side."""
    return oren_nayar.eval_pdf(params, wi, across(wo))


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw wo in proportion to its cosine, on the far side."""
    s = oren_nayar.sample(params, wi, u0, u1, u2)
    np.negative(s.wo[2], out=s.wo[2])
    return s._replace(lobe=Lobe.DIFFUSE | Lobe.TRANSMIT)
