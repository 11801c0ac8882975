"""Refraction alone, GGX, as Blender's Refraction BSDF: everything is transmitted, but for total reflection.

See `interface`. Its colour is the closure's weight.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import fresnel, interface
from .base import BSDFSample, Float32
from .microfacet import GGX, Distribution

SPECULAR = True
TRANSMITS = True


class Params(NamedTuple):
    """
    Attributes
    ----------
    alpha : (N,) float32
        Roughness; below about 1.4e-5 the interface is ideally smooth.
    eta : (N,) float32
        Index of the far side over the near one.
    """

    alpha: Float32
    eta: Float32


def law(params: Params) -> interface.Law:
    """All is transmitted, or none."""
    eta = params.eta
    nothing, never = np.zeros((1, 1), np.float32), np.zeros(1, np.float32)

    def split(cos: Float32) -> interface.Split:
        g2 = fresnel.g_squared(cos, eta)
        passes: Float32 = (g2 > 0).astype(cos.dtype)
        return interface.Split(nothing, passes[np.newaxis], never, np.sqrt(np.maximum(g2, 0.0)))

    return split


def eval_pdf(
    params: Params, wi: Float32, wo: Float32, model: type[Distribution] = GGX
) -> tuple[Float32, Float32]:
    """f·|cosθo| (1, N) and pdf (N,)."""
    return interface.eval_pdf(model, params.alpha, params.eta, law(params), wi, wo)


def sample(
    params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32, model: type[Distribution] = GGX
) -> BSDFSample:
    """Refract at a visible facet."""
    return interface.sample(model, params.alpha, params.eta, law(params), wi, u0, u1, u2)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """1, or 0 beyond the critical angle."""
    albedo: Float32 = law(params)(cos_i).transmitted[0]
    return albedo
