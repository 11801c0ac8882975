"""One way of light through a hair of elliptic section: where it enters, and which facets it meets.

The section's axes are X (the longer one, half 1) and Z (half b); the hair is along Y. At the parameter γ the
point is (sinγ, b cosγ) and its outward normal n ∝ (b sinγ, cosγ). What wi sees of it is r = √(cos²φi + b²
sin²φi) to either side, and light that hits at the offset h of that comes in at

    γ = atan2(cosφi, −b sinφi) − acos(−h)

With Z stretched by 1/b the section is a circle. Light from p = (sinγ, cosγ) that moves along d there meets
the wall where the inward normal's parameter is q = 2(p·d)d − p, after a way of 2|p·d| (unstretched).

Scales tilt the facets' mean normal m ("mesonormal") by −τ where light enters and by τ inside, where normals
look inward. Facets are GGX (`facets`), drawn from the visible ones; what is lost between them is made up for
as in rough glass, by 1/E. Huang, Hullin and Hanika 2022, "A Microfacet-based Hair Scattering Model".
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import dot, mean3, reflect
from . import energy, facets, fresnel
from .base import Float32
from .microfacet import masking_ratio

Bool = NDArray[np.bool_]

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
    open: Bool


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
    h, f1, g = facet(first, hair.alpha, hair.eta, u[:2])
    wt = hair.inverse * ((dot(wi, h) - g) * h - wi)
    scale = gain(hair.alpha, hair.eta, first.z)
    entered = (1.0 - f1) * scale * kept(first, wt, hair.a2)
    entered = entered * (first.open & (dot(wi, h) > 0) & (dot(wt, first.n) < 0))

    inward = -hair.sine, hair.cosine
    q, way = across(p, wt, hair.b)
    second = wall(-wt, q, hair.b, inward, hair.a2)
    through = attenuation(hair.sigma, way, wt)
    arrived = (entered * gain(hair.alpha, hair.inverse, second.z) * second.open) * through

    h, f2, _ = facet(second, hair.alpha, hair.inverse, u[2:4])
    back = reflect(second.w, h)  # into the hair
    q, way = across(-q, back, hair.b)
    third = wall(-back, q, hair.b, inward, hair.a2)
    again = attenuation(hair.sigma, way, back)
    returned = gain(hair.alpha, hair.inverse, third.z) * kept(second, back, hair.a2) * third.open
    returned = arrived * again * (f2 * returned)

    h, f3, _ = facet(third, hair.alpha, hair.inverse, u[4:])
    rest = returned * (f3 * kept(third, reflect(third.w, h), hair.a2))
    rest = rest * escaping(np.sqrt(through * again), 1.0 - 0.5 * (f2 + f3))

    white = np.broadcast_to(scale * first.open, returned.shape)
    share: Float32 = np.stack([white, arrived, returned, rest])
    if strength is not None:
        share[:3] *= strength[:, np.newaxis]
    at_once = 0.5 * (f1 + outer(first, hair.eta))
    likely = at_once, leaves(f2, second, hair.inverse), leaves(f3, third, hair.inverse)
    grey = np.stack([*(mean3(s) * x for s, x in zip(share[:3], likely, strict=True)), mean3(rest)])
    total = grey[0] + grey[1] + grey[2] + grey[3]
    return Chain((first, second, third), share, grey / np.maximum(total, 1e-20))


def facet(at: Wall, alpha: Float32, eta: Float32, u: Float32) -> tuple[Float32, Float32, Float32]:
    """A visible facet's normal, and F and g = η cosθt there (`fresnel.dielectric`); u (2, N)."""
    h = facets.visible_normal(at.w, at.m, at.z, alpha, u[0], u[1])
    return h, *fresnel.dielectric(np.maximum(dot(at.w, h), 0.0), eta)


def escaping(passed: Float32, leaving: Float32) -> Float32:
    """(3, N) of light inside, `passed` on each way across, what leaves in the end: Σ A^k (1 − L)^(k−1) L."""
    least: Float32 = np.maximum(leaving, 1e-5)
    share: Float32 = passed * least
    share /= 1.0 - passed * (1.0 - least)
    return share


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
    inverse: Float32 = 1.0 / np.sqrt(x * x + z * z + 1e-30)
    x, z = x * inverse, z * inverse
    h: Float32 = np.minimum(np.maximum(offset, -EDGE), EDGE)
    root: Float32 = np.sqrt((1.0 - h) * (1.0 + h))
    return np.stack([-h * z - root * x, root * z - h * x])


def across(p: Float32, d: Float32, b: Float32) -> tuple[Float32, Float32]:
    """Parameter (2, N) of the inward normal where light from p, moving along d, meets the wall; its way."""
    x, z = d[0], d[2] / b
    inverse: Float32 = 1.0 / np.sqrt(x * x + z * z + 1e-30)
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
    albedo: Float32 = np.maximum(energy.glass_albedo(alpha, eta, np.maximum(z, 0.0)), 1e-2)
    return np.reciprocal(albedo)
