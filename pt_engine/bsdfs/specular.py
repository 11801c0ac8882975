"""The glossy sheen of a dielectric, GGX: reflection alone, by Fresnel's exact law; for coats and plastics.

f·cosθo = F(wi·m) D(m) G2(wi, wo)/(4 cosθi)

What F lets through is the business of the layers below (see `energy.gloss`). `tint` scales F at normal
incidence and leaves it 1 at grazing (see `dielectric`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.vectors import mean3
from . import fresnel, reflection, thin_film
from .base import BSDFSample, Float32
from .microfacet import GGX

SPECULAR = True


class Params(NamedTuple):
    """
    Attributes
    ----------
    alpha_x, alpha_y : (N,) float32
        Roughness along the frame's tangent and bitangent; `alpha_y` None: isotropic.
    eta : (N,) float32
        Relative index of refraction.
    tint : (3, N) float32 or None
        Of the reflectance at normal incidence; white where None.
    film_thickness, film_ior : (N,) float32 or None
        Of a thin film (see `thin_film`), in nm.
    """

    alpha_x: Float32
    alpha_y: Float32 | None
    eta: Float32
    tint: Float32 | None = None
    film_thickness: Float32 | None = None
    film_ior: Float32 | None = None


def facets(params: Params) -> reflection.Fresnel:
    """The facets' reflectance as a function of the cosine."""
    eta, tint = params.eta, params.tint
    film = thin_film.film_of(params.film_thickness, params.film_ior)

    def plain(cos: Float32) -> Float32:
        f = fresnel.dielectric(cos, eta)[0]
        return f[np.newaxis] if tint is None else fresnel.tinted(f, eta, tint)

    def coated(cos: Float32, film: thin_film.Film) -> Float32:
        return thin_film.over_tinted(cos, eta, tint, film)

    return lambda cos: thin_film.covered(film, cos, coated, plain)


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·cosθo (3, N) or (1, N) and pdf (N,)."""
    return reflection.eval_pdf(GGX, (params.alpha_x, params.alpha_y), facets(params), wi, wo)


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Mirror wi in a visible facet; the weight is F G2/G1."""
    return reflection.sample(GGX, (params.alpha_x, params.alpha_y), facets(params), wi, u1, u2)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """Mean reflectance at the viewer's angle."""
    return mean3(facets(params)(cos_i))
