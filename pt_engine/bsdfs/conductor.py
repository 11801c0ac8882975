"""Metal and gloss, GGX: reflection off a rough surface, any light not reflected being absorbed.

    f·cosθo = F(wi·m) D(m) G2(wi, wo)/(4 cosθi)

The facets' reflectance F is one of three, by the parameters that are given:

    color                 the same at all angles (Blender's Glossy)
    color, edge_tint      F82-tint (Blender's Metallic and Principled)
    eta, k                a complex index of refraction; `color` then scales it

`conductor_beckmann` is the same with Beckmann's distribution. `energy.reflection_gain` makes up for light
that would bounce between facets.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from ..core.vectors import mean3
from . import fresnel, reflection, thin_film
from .base import BSDFSample, Float32
from .microfacet import GGX, Distribution

SPECULAR = True


class Params(NamedTuple):
    """
    Attributes
    ----------
    alpha_x, alpha_y : (N,) float32
        Roughness along the frame's tangent and bitangent; `alpha_y` None: isotropic.
    color, edge_tint, eta, k : (3, N) float32
        See above.
    film_thickness, film_ior : (N,) float32
        Of a thin film (see `thin_film`), in nm, over the last two of the three.
    """

    alpha_x: Float32
    alpha_y: Float32 | None = None
    color: Float32 | None = None
    edge_tint: Float32 | None = None
    eta: Float32 | None = None
    k: Float32 | None = None
    film_thickness: Float32 | None = None
    film_ior: Float32 | None = None


def facets(params: Params) -> reflection.Fresnel:
    """The facets' reflectance as a function of the cosine."""
    plain = _bare(params)
    film = thin_film.film_of(params.film_thickness, params.film_ior)
    return lambda cos: thin_film.covered(film, cos, partial(_filmed, params), plain)


def _filmed(params: Params, cos: Float32, film: thin_film.Film) -> Float32:
    if params.eta is not None and params.k is not None:
        return thin_film.over_conductor(cos, params.eta, params.k, film)
    if params.color is None or params.edge_tint is None:
        raise ValueError("a thin film needs metal given by eta and k, or by color and edge_tint")
    b = fresnel.f82_slope(params.color, params.edge_tint)
    return thin_film.over_f82(cos, params.color, b, film)


def _bare(params: Params) -> reflection.Fresnel:
    color, tint, eta, k = params.color, params.edge_tint, params.eta, params.k
    if eta is not None and k is not None:
        complex_eta, complex_k = eta, k
        if color is None:
            return lambda cos: fresnel.conductor(cos, complex_eta, complex_k)
        scale = color
        return lambda cos: scale * fresnel.conductor(cos, complex_eta, complex_k)
    if color is None:
        return lambda cos: np.ones((1, 1), np.float32)
    f0 = color
    if tint is None:
        return lambda cos: f0
    b = fresnel.f82_slope(f0, tint)
    return lambda cos: fresnel.f82(cos, f0, b)


def average(params: Params) -> Float32:
    """Hemispherical average of the facets' reflectance: (3, N) or (1, 1)."""
    if params.eta is not None and params.k is not None:
        scale = 1.0 if params.color is None else params.color
        return fresnel.conductor_average(params.eta, params.k) * scale
    if params.color is None:
        return np.ones((1, 1), np.float32)
    if params.edge_tint is None:
        return params.color
    return fresnel.f82_average(params.color, fresnel.f82_slope(params.color, params.edge_tint))


def eval_pdf(
    params: Params, wi: Float32, wo: Float32, model: type[Distribution] = GGX
) -> tuple[Float32, Float32]:
    """f·cosθo (3, N) and pdf (N,)."""
    return reflection.eval_pdf(model, (params.alpha_x, params.alpha_y), facets(params), wi, wo)


def sample(
    params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32, model: type[Distribution] = GGX
) -> BSDFSample:
    """Mirror wi in a visible facet; the weight is F G2/G1."""
    return reflection.sample(model, (params.alpha_x, params.alpha_y), facets(params), wi, u1, u2)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """Mean reflectance at the viewer's angle."""
    return mean3(facets(params)(cos_i))
