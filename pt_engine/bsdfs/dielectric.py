"""Glass, GGX, smooth or rough: reflection and refraction in Fresnel's proportions. See `interface`.

R = F tint_r and T = (1 − F) tint_t at each facet, F exact. `specular_tint` scales F at normal incidence and
leaves it 1 at grazing: F' = F0' + (1 − F0') s, s = (F − F0)/(1 − F0), F0' = F0 · tint (as Cycles).

A colour common to both belongs in the closure's weight. `energy.glass_gain` makes up for the light that
would bounce between facets.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.vectors import mean3
from . import fresnel, interface, thin_film
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
        Index of the far side over the near one: the material's, or its inverse when leaving it.
    reflection_tint, transmission_tint, specular_tint : (3, N) float32 or None
        White where None.
    film_thickness, film_ior : (N,) float32 or None
        Of a thin film (see `thin_film`), in nm, and its index over that of the near side.
    """

    alpha: Float32
    eta: Float32
    reflection_tint: Float32 | None = None
    transmission_tint: Float32 | None = None
    specular_tint: Float32 | None = None
    film_thickness: Float32 | None = None
    film_ior: Float32 | None = None


def law(params: Params) -> interface.Law:
    """What a facet reflects and transmits, as a function of the cosine."""
    eta = params.eta
    if all(p is None for p in params[2:]):
        return lambda cos: _clear(cos, eta)
    white = np.ones((3, 1), np.float32)
    tint_r = white if params.reflection_tint is None else params.reflection_tint
    tint_t = white if params.transmission_tint is None else params.transmission_tint
    return lambda cos: _colored(cos, params, tint_r, tint_t)


def _clear(cos: Float32, eta: Float32) -> interface.Split:
    f, g = fresnel.dielectric(cos, eta)
    return interface.Split(f[np.newaxis], (1.0 - f)[np.newaxis], f, g)


def _colored(cos: Float32, params: Params, tint_r: Float32, tint_t: Float32) -> interface.Split:
    eta, tint = params.eta, params.specular_tint
    f, g = fresnel.dielectric(cos, eta)
    colored = thin_film.covered(
        thin_film.film_of(params.film_thickness, params.film_ior),
        cos,
        lambda c, film: thin_film.over_tinted(c, eta, tint, film),
        lambda c: f[np.newaxis] if tint is None else fresnel.tinted(f, eta, tint),
    )
    reflected, transmitted = colored * tint_r, (1.0 - colored) * tint_t
    mean_r, mean_t = mean3(reflected), mean3(transmitted)
    return interface.Split(reflected, transmitted, mean_r / (mean_r + mean_t + fresnel.TINY), g)


def eval_pdf(
    params: Params, wi: Float32, wo: Float32, model: type[Distribution] = GGX
) -> tuple[Float32, Float32]:
    """f·|cosθo| (3, N) or (1, N) and pdf (N,)."""
    return interface.eval_pdf(model, params.alpha, params.eta, law(params), wi, wo)


def sample(
    params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32, model: type[Distribution] = GGX
) -> BSDFSample:
    """Reflect or refract at a visible facet."""
    return interface.sample(model, params.alpha, params.eta, law(params), wi, u0, u1, u2)


def albedo(params: Params, cos_i: Float32) -> Float32:
    """Mean of what is reflected and transmitted at the viewer's angle."""
    split = law(params)(cos_i)
    return mean3(split.reflected + split.transmitted)
