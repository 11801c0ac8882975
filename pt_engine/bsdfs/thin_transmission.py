"""Light through a thin sheet of glass, GGX: it goes on as it came, spread by the two rough faces it passes.

    f(wi, wo)·|cosθo| = that of a white reflection toward wo', wo mirrored at the surface

(Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks".) Through a smooth sheet the way is
straight. What the sheet lets through is the closure's weight, see `nodes.thin_walls`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from . import reflection
from .base import BSDFSample, Float32, Lobe
from .microfacet import GGX

SPECULAR = True
TRANSMITS = True
WHITE = np.ones((1, 1), np.float32)


class Params(NamedTuple):
    """
    Attributes
    ----------
    alpha : (N,) float32
        Roughness of both faces together (`sheet_alpha`); below about 1.4e-5 the sheet is ideally smooth.
    """

    alpha: Float32


def sheet_alpha(alpha: Float32, eta: Float32) -> Float32:
    """α of the light that has passed two faces of roughness α and index η, their fit: at most 1."""
    eta = np.maximum(eta, 1.0)
    lifted = eta - 0.5
    spread: Float32 = 3.4 * (eta - 1.0) * (lifted * lifted) / (eta * eta * eta)
    sheet: Float32 = np.minimum(alpha * np.sqrt(spread), 1.0)
    return sheet


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·|cosθo| (1, N) and pdf (N,), 0 on the viewer's side."""
    return reflection.eval_pdf(GGX, (params.alpha, None), _white, wi, across(wo))


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Mirror wi in a visible facet, and that at the surface; the weight is G2/G1."""
    s = reflection.sample(GGX, (params.alpha, None), _white, wi, u1, u2)
    lobe = np.asarray(s.lobe, np.uint8) | np.uint8(Lobe.TRANSMIT)
    return s._replace(wo=across(s.wo), lobe=lobe)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """1."""
    return np.ones(1, np.float32)


def across(w: Float32) -> Float32:
    """w mirrored at the surface."""
    return np.stack([w[0], w[1], -w[2]])


def _white(cos: Float32) -> Float32:
    return WHITE
