"""One way of light through a hair of elliptic section: where it enters, and which facets it meets.

The section's axes are X (the longer one, half 1) and Z (half b), the hair is along Y. The point of parameter
γ is p = (sinγ, b cosγ), its outward normal n ∝ (b sinγ, cosγ). Light that hits at the offset h of the radius
r that it sees has

    sinγ = (h cosφi − b sinφi √(1 − h²))/−r  …        (sinγ, cosγ) turns (−h, √(1 − h²)) into the ellipse's frame

Between two of its points light moves as in a circle whose Z has been stretched by 1/b: with the direction d
there, the inward normal's parameter is q = 2 (p·d) d − p, the way 2|p·d| times the shrinking back.

Scales tilt the facets' mean normal (the mesonormal) by −τ where light enters, and by τ inside, where normals
look inward. Facets are GGX (`facets`), drawn from those visible; what they lose between them is made up for
as in rough glass, by 1/E. Huang, Hullin and Hanika 2022, "A Microfacet-based Hair Scattering Model".
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..core.vectors import dot, mean3, reflect
from . import energy, facets, fresnel
from .base import Float32
from .microfacet import masking_ratio

LEAST = np.float32(0.05)  # of the light that leaves at a facet, in the estimates that choose lobes
EDGE = np.float32(1 - 1e-6)


class Wall(NamedTuple):
    """A place on the surface as the direction that arrives there sees it.

    Attributes
    ----------
    w : (3, N) float32
        Where the light comes from, away from the surface.
    m, n : (3, N) float32
        Mesonormal and normal, on that side.
    z, t : (N,) float32
        w·m and its `facets.stretched`.
    open : (N,) bool
        Whether w is above both normals.
    """

    w: Float32
    m: Float32
    n: Float32
    z: Float32
    t: Float32
    open: Float32


def wall(w: Float32, p: Float32, b: Float32, tilt: tuple[Float32, Float32], a2: Float32) -> Wall:
    """At the parameter p = (sinγ, cosγ) of the normal that w is to see; `tilt` has its sine and cosine."""
    x = b * p[0]
    inverse = 1.0 / np.sqrt(x * x + p[1] * p[1])
    n = np.stack([x * inverse, np.zeros_like(inverse), p[1] * inverse])
    sine, cosine = tilt
    m = np.stack([n[0] * cosine, np.broadcast_to(sine, inverse.shape), n[2] * cosine])
    z = dot(w, m)
    return Wall(w, m, n, z, facets.stretched(z, a2), (z > 0) & (dot(w, n) > 0))


def kept(at: Wall, wo: Float32, a2: Float32) -> Float32:
    """G2/G1 of light that leaves a wall to wo, on either side."""
    zo: Float32 = np.abs(dot(at.m, wo))
    return masking_ratio(np.abs(at.z), at.t, zo, facets.stretched(zo, a2))


class Matter(NamedTuple):
    """What the hair is made of, (N,) or (1,) each but `sigma` (3, N).

    `alpha` roughness, `eta` index, `b` half axis, `sine` and `cosine` of the tilt.
    """

    alpha: Float32
    a2: Float32
    eta: Float32
    inverse: Float32
    b: Float32
    sine: Float32
    cosine: Float32
    sigma: Float32


class Chain(NamedTuple):
    """Three places that light meets, and what it carries away from each.

    Attributes
    ----------
    walls : (Wall, Wall, Wall)
        Where it enters, and where it may leave after none or one reflection inside.
    share : (4, 3, N) float32
        Of the light, without what happens at the last facet: R, TT, TRT; and all the rest.
    probability : (4, N) float32
        Of sampling each.
    """

    walls: tuple[Wall, Wall, Wall]
    share: Float32
    probability: Float32


def trace(wi: Float32, offset: Float32, u: Float32, hair: Matter, strength: Float32 | None) -> Chain:
    """Follow light that hits at `offset` (N,) of the radius, with facets drawn by u (6, N).

    Parameters
    ----------
    wi : (3, N) float32
        In the section's frame.
    strength : (3, N) float32 or None
        Factors on R, TT and TRT.
    """
    p = entry(wi, offset, hair.b)
    first = wall(wi, p, hair.b, (hair.sine, hair.cosine), hair.a2)
    h = facets.visible_normal(wi, first.m, first.z, hair.alpha, u[0], u[1])
    c = np.maximum(dot(wi, h), 0.0)
    f1, g = fresnel.dielectric(c, hair.eta)
    wt = hair.inverse * ((c - g) * h - wi)
    scale1 = gain(hair.alpha, hair.eta, first.z)
    ok = first.open & (dot(wi, h) > 0) & (dot(wt, first.n) < 0)
    entered = (1.0 - f1) * scale1 * kept(first, wt, hair.a2) * ok

    q, way = across(p, wt, hair.b)
    second = wall(-wt, q, hair.b, (-hair.sine, hair.cosine), hair.a2)
    through = attenuation(hair.sigma, way, wt)
    scale2 = gain(hair.alpha, hair.inverse, second.z)
    arrived = (entered * scale2 * second.open) * through

    h = facets.visible_normal(second.w, second.m, second.z, hair.alpha, u[2], u[3])
    c = np.maximum(dot(second.w, h), 0.0)
    f2, _ = fresnel.dielectric(c, hair.inverse)
    back = reflect(second.w, h)  # into the hair
    q, way = across(-q, back, hair.b)
    third = wall(-back, q, hair.b, (-hair.sine, hair.cosine), hair.a2)
    again = attenuation(hair.sigma, way, back)
    scale3 = gain(hair.alpha, hair.inverse, third.z)
    returned = arrived * again * (f2 * scale3 * kept(second, back, hair.a2) * third.open)

    h = facets.visible_normal(third.w, third.m, third.z, hair.alpha, u[4], u[5])
    c = np.maximum(dot(third.w, h), 0.0)
    f3, _ = fresnel.dielectric(c, hair.inverse)
    mean_way = np.sqrt(through * again)
    leaving = np.maximum(0.5 * (1.0 - f2) + 0.5 * (1.0 - f3), 1e-5)
    rest = mean_way * leaving / (1.0 - mean_way * (1.0 - leaving))
    rest = returned * rest * (f3 * kept(third, reflect(third.w, h), hair.a2))

    white = np.broadcast_to(scale1 * first.open, returned.shape)
    share = np.stack([white, arrived, returned, rest])
    if strength is not None:
        share[:3] *= strength[:, np.newaxis]
    likely = (
        0.5 * f1 + 0.5 * outer(first, hair.eta),
        leaves(f2, second, hair.inverse),
        leaves(f3, third, hair.inverse),
        1.0,
    )
    grey = np.stack([mean3(s) * x for s, x in zip(share, likely, strict=True)])
    total = grey[0] + grey[1] + grey[2] + grey[3]
    return Chain((first, second, third), share, grey / np.maximum(total, 1e-20))


def outer(at: Wall, eta: Float32) -> Float32:
    """Fresnel's F at the mesonormal."""
    return fresnel.dielectric(np.minimum(np.maximum(at.z, 0.0), 1.0), eta)[0]


def leaves(f: Float32, at: Wall, inverse: Float32) -> Float32:
    """Roughly how much leaves at a wall, of which one facet reflects f."""
    share: Float32 = np.maximum(1.0 - 0.5 * f - 0.5 * outer(at, inverse), LEAST)
    return share


def entry(wi: Float32, offset: Float32, b: Float32) -> Float32:
    """(2, N) sinγ and cosγ of the point that wi hits."""
    x, z = -b * wi[0], wi[2]
    inverse = 1.0 / np.sqrt(x * x + z * z + 1e-30)
    x, z = x * inverse, z * inverse
    h = np.minimum(np.maximum(offset, -EDGE), EDGE)
    root = np.sqrt((1.0 - h) * (1.0 + h))
    # γ = atan2(z, x) − acos(−h)
    return np.stack([-h * z - root * x, root * z - h * x])


def across(p: Float32, d: Float32, b: Float32) -> tuple[Float32, Float32]:
    """Parameter (2, N) of the inward normal where light from p, moving along d, meets the wall; its way."""
    x, z = d[0], d[2] / b
    inverse = 1.0 / np.sqrt(x * x + z * z + 1e-30)
    x, z = x * inverse, z * inverse
    twice = 2.0 * (p[0] * x + p[1] * z)
    bz = b * z
    return np.stack([twice * x - p[0], twice * z - p[1]]), np.abs(twice) * np.sqrt(x * x + bz * bz)


def attenuation(sigma: Float32, way: Float32, d: Float32) -> Float32:
    """(3, N) what is left of light after a way across, on which d also climbs along the hair."""
    cosine = np.sqrt(d[0] * d[0] + d[2] * d[2])
    left: Float32 = np.exp(-sigma * (way / np.maximum(cosine, 1e-4)))
    return left


def gain(alpha: Float32, eta: Float32, z: Float32) -> Float32:
    """1/E: what facets of rough glass lose between them."""
    g: Float32 = 1.0 / np.maximum(energy.glass_albedo(alpha, eta, np.maximum(z, 0.0)), 1e-2)
    return g
