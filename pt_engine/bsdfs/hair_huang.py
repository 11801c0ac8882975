"""Hair as a rough dielectric fibre of elliptic section: Blender's Principled Hair after Huang.

f = E[Σ share · last facet], over the offset h at which light hits, even on what wi sees of the hair, and over
the facets that it meets before the last one (`hair_chain`). It is reflected at once (R), or leaves at its
second wall (TT) or at its third (TRT): the last facet's GGX lobe is known in closed form (`reflected`,
`refracted`). All the rest is M(θi, θo)/2π after d'Eon (`hair_chiang`), of variance 4α.

The expectation has no closed form. This is the model for `CHAINS` given ways, whose random numbers are
parameters: drawn anew at each point that is shaded they make f an unbiased estimate, while the value, density
and samples of one point belong together, so that all of `base`'s contract holds.

Huang, Hullin and Hanika 2022, "A Microfacet-based Hair Scattering Model". Shares are those with which Cycles
samples; its own evaluation toward lamps has tilted scales and the rest otherwise, and not all of the energy.

The frame's tangent is the hair's; its normal has no meaning here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.vectors import dot, mean3, normalize, reflect
from . import facets, fresnel, hair_chiang
from .base import BSDFSample, Float32, Lobe
from .hair_chain import Chain, Matter, Wall, kept, trace

Int8 = NDArray[np.int8]
Bool = NDArray[np.bool_]

TRANSMITS = True
CHAINS = 2  # 1 costs half and is better under a sky, 4 toward small lamps
PI = float(np.pi)
LEAST_ROUGHNESS = 1e-3
NEAREST_INDEX = 1e-3  # |η − 1| below which light would pass within a lobe too narrow for float32
# of Kronecker's sequence: powers of 1/g, g⁷ = g + 1
STEPS = (1.0 / 1.1127756842787055 ** np.arange(1, 7)).astype(np.float32)[:, np.newaxis]


class Params(NamedTuple):
    """
    Attributes
    ----------
    alpha : (N,) float32
        Roughness of the facets.
    tilt : (N,) float32
        Of the scales toward the root, in radians.
    eta : (N,) float32
        Index of refraction.
    sigma : (3, N) float32
        Absorption per radius.
    enters, inside : (3, N) float32
    last : (N,) float32
        Uniforms: one for the offset and two for each of three facets.
    aspect : (N,) float32
        The section's shorter axis over the longer one.
    phi : (N,) float32
        Azimuth of wi, from the section's shorter axis toward the longer one.
    h, blur : (N,) float32
        Where the ray hits, as in `hair_chiang`, and how exactly that is known, both over the radius: where
        less exactly than to what the ray sees of the hair, any h there is as likely.
    strength : (3, N) float32 or None
        Factors ≥ 0 on R, TT and TRT; None is 1.
    """

    alpha: Float32
    tilt: Float32
    eta: Float32
    sigma: Float32
    enters: Float32
    inside: Float32
    last: Float32
    aspect: Float32
    phi: Float32
    h: Float32
    blur: Float32
    strength: Float32 | None = None


class Section(NamedTuple):
    """The hair as wi sees it.

    Attributes
    ----------
    wi : (3, N) float32
        In the section's frame: X its longer axis, Y along the hair, Z.
    axis : (2, N) float32
        X in the local frame's y and z.
    radius : (N,) float32
        That wi sees.
    matter : Matter
    """

    wi: Float32
    axis: Float32
    radius: Float32
    matter: Matter


def section(params: Params, wi: Float32) -> Section:
    """The section's frame."""
    a = np.maximum(np.minimum(params.alpha, 1.0), LEAST_ROUGHNESS)
    eta: Float32 = np.maximum(params.eta, LEAST_ROUGHNESS)
    eta = eta + (np.abs(eta - 1.0) < NEAREST_INDEX) * (1.0 + NEAREST_INDEX - eta)
    b = np.minimum(np.maximum(params.aspect, 1e-2), 1e2)
    along = np.minimum(np.maximum(wi[0], -1.0), 1.0)
    width = np.sqrt(wi[1] * wi[1] + wi[2] * wi[2])
    inverse = 1.0 / np.maximum(width, 1e-20)
    toward, aside = (wi[1] * inverse, wi[2] * inverse), (-wi[2] * inverse, wi[1] * inverse)
    s, c = np.sin(params.phi), np.cos(params.phi)
    axis = np.stack([c * aside[k] + s * toward[k] for k in (0, 1)])
    seen = np.sqrt(c * c + (b * s) * (b * s))
    there = np.stack([width * s, along, width * c])
    sigma = np.maximum(params.sigma, 0.0)
    inverse_eta: Float32 = np.reciprocal(eta)
    matter = Matter(a, a * a, eta, inverse_eta, b, np.sin(params.tilt), np.cos(params.tilt), sigma)
    return Section(there, axis, seen, matter)


def into(hair: Section, w: Float32) -> Float32:
    """Local frame to section."""
    x, z = hair.axis
    return np.stack([w[1] * x + w[2] * z, w[0], w[1] * z - w[2] * x])


def out_of(hair: Section, w: Float32) -> Float32:
    """Section to local frame."""
    x, z = hair.axis
    return np.stack([w[1], w[0] * x + w[2] * z, w[0] * z - w[2] * x])


def chains(params: Params, hair: Section) -> list[Chain]:
    """The ways: their offsets are from as many strata, their facets those of a lattice."""
    near = params.blur < hair.radius
    known, spread = near * params.h / hair.radius, np.float32(2.0) * ~near
    first = np.concatenate([params.enters[1:], params.inside, params.last[np.newaxis]])
    ways = []
    for number in range(CHAINS):
        u = first + np.float32(number) * STEPS
        u = np.minimum(u - np.floor(u), np.float32(1.0 - 2.0**-24))
        share = (params.enters[0] + np.float32(number)) * np.float32(1.0 / CHAINS)
        offset = known + spread * (share - np.float32(0.5))
        ways.append(trace(hair.wi, offset, u, hair.matter, params.strength))
    return ways


# ------------------------------------------------------------------------- the last facet


def reflected(at: Wall, eta: Float32, a2: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """What a wall's facets reflect to wo, and the density with which they do: (N,) each."""
    h = at.w + wo
    squared = dot(h, h)
    pdf = facets.density(at.m, h, a2) * (0.5 * squared * squared) / (at.z + at.t + (at.z <= 0))
    pdf *= at.open & (dot(at.n, wo) > 0) & (dot(at.m, h) > 0)
    cos = np.sqrt(np.maximum(0.5 + 0.5 * dot(at.w, wo), 0.0))
    return fresnel.dielectric(np.minimum(cos, 1.0), eta)[0] * kept(at, wo, a2) * pdf, pdf


def refracted(at: Wall, inverse: Float32, a2: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """What a wall's facets let out to wo, and the density with which they do: (N,) each."""
    h = at.w + inverse * wo
    ih, oh = dot(at.w, h), dot(wo, h)
    pdf = facets.density(at.m, h, a2) * (2.0 * inverse * inverse) * np.abs(ih * oh)
    pdf /= at.z + at.t + (at.z <= 0)
    pdf *= at.open & (ih * oh < 0) & (ih * dot(at.m, h) > 0) & (dot(at.n, wo) < 0)
    cos: Float32 = np.abs(ih)
    cos /= np.sqrt(dot(h, h) + 1e-20)
    passed = 1.0 - fresnel.dielectric(np.minimum(cos, 1.0), inverse)[0]
    pdf *= passed > 0
    return passed * kept(at, wo, a2) * pdf, pdf


# ------------------------------------------------------------------------- the contract


def eval_pdf(params: Params, wi: Float32, wo: Float32) -> tuple[Float32, Float32]:
    """f·|cosθo| (3, N) and pdf (N,), on both sides of the surface."""
    hair = section(params, wi)
    return _eval(hair, chains(params, hair), into(hair, wo))


def _eval(hair: Section, ways: list[Chain], wo: Float32) -> tuple[Float32, Float32]:
    n = wo.shape[1]
    value, pdf = np.zeros((3, n), np.float32), np.zeros(n, np.float32)
    rest, chance = np.zeros((3, n), np.float32), np.zeros(n, np.float32)
    matter = hair.matter
    for way in ways:
        first, second, third = way.walls
        lobes = (
            reflected(first, matter.eta, matter.a2, wo),
            refracted(second, matter.inverse, matter.a2, wo),
            refracted(third, matter.inverse, matter.a2, wo),
        )
        for share, probability, (f, p) in zip(way.share, way.probability, lobes, strict=False):
            value += share * f
            pdf += probability * p
        rest += way.share[3]
        chance += way.probability[3]
    around = hair_chiang.longitudinal(*_theta(hair.wi), *_theta(wo), 4.0 * matter.alpha) * (0.5 / PI)
    value += rest * around
    pdf += chance * around
    return value * np.float32(1 / CHAINS), pdf * np.float32(1 / CHAINS)


def _theta(w: Float32) -> tuple[Float32, Float32]:
    """Sine and cosine of the angle to the hair's normal plane."""
    sine: Float32 = np.minimum(np.maximum(w[1], -1.0), 1.0)
    return sine, np.sqrt(np.minimum(w[0] * w[0] + w[2] * w[2], 1.0))


def sample(params: Params, wi: Float32, u0: Float32, u1: Float32, u2: Float32) -> BSDFSample:
    """Draw a way and a lobe by `u0`, and the last facet by `u1`, `u2`."""
    hair = section(params, wi)
    ways = chains(params, hair)
    scaled = u0 * np.float32(CHAINS)
    number = np.minimum(scaled.astype(np.int8), CHAINS - 1)
    left = scaled - number
    probability = sum(way.probability * (number == k) for k, way in enumerate(ways))
    bounds = np.cumsum(probability[:3], axis=0)
    lobe = (left >= bounds[0]).astype(np.int8) + (left >= bounds[1]) + (left >= bounds[2])
    rest = lobe == 3
    leaving, good = _at_last_facet(hair, ways, 3 * number + np.minimum(lobe, 2), u1, u2)
    spare = np.minimum(np.maximum(left - bounds[2], 0.0) / np.maximum(probability[3], 1e-20), 1.0)
    wo = normalize(np.where(rest, _at_random(hair, spare, u1, u2), leaving))
    value, pdf = _eval(hair, ways, wo)
    good = np.where(rest, probability[3] > 0, good) & (pdf > 0)
    weight = value * good / (pdf + (pdf <= 0))
    return BSDFSample(out_of(hair, wo), pdf, weight, Lobe.GLOSSY)


def _at_last_facet(
    hair: Section, ways: list[Chain], which: Int8, u1: Float32, u2: Float32
) -> tuple[Float32, Bool]:
    """Where a visible facet of a wall, `which` of all, sends the light; and whether that is possible."""
    rows = np.zeros((11, which.size), np.float32)
    for k, at in enumerate(at for way in ways for at in way.walls):
        here = (which == k).astype(np.float32)
        for row, part in enumerate((*at.w, *at.m, *at.n, at.z, at.open)):
            rows[row] += part * here
    w, m, n, z, visible = rows[:3], rows[3:6], rows[6:9], rows[9], rows[10]
    h = facets.visible_normal(w, m, z, hair.matter.alpha, u1, u2)
    c = np.maximum(dot(w, h), 0.0)
    f, g = fresnel.dielectric(c, hair.matter.inverse)
    reflects = which % 3 == 0
    wo = np.where(reflects, reflect(w, h), hair.matter.eta * ((c - g) * h - w))
    side = dot(n, wo)
    return wo, (visible > 0) & (c > 0) & np.where(reflects, side > 0, (side < 0) & (f < 1))


def _at_random(hair: Section, u: Float32, u1: Float32, u2: Float32) -> Float32:
    """A direction by M(θ)/2π."""
    sine = hair_chiang.draw_sine(*_theta(hair.wi), 4.0 * hair.matter.alpha, u, u1)
    cosine = np.sqrt(np.maximum((1.0 - sine) * (1.0 + sine), 0.0))
    phi = np.float32(2.0 * PI) * u2
    return np.stack([cosine * np.cos(phi), sine, cosine * np.sin(phi)])


def albedo(params: Params, cos_i: Float32) -> Float32:
    """What is reflected and what passes through the middle, roughly: mean over the colours."""
    f0 = fresnel.normal_incidence(np.maximum(params.eta, 1e-3))
    through = mean3(np.exp(-np.maximum(params.sigma, 0.0)))
    share: Float32 = f0 + (1.0 - f0) * through
    return share
