"""Colours of a thin film: interference between what its two faces reflect, on dielectric and on metal.

Of the film's faces the upper one has the amplitudes r12 (polarisation s or p), the lower one r23 with a
phase φ; R = |r|², T = 1 − R. Light that crosses the film 2m times lags by m D, D = 2 n d cosθ₂ being the
optical path difference, and Airy's sum over all of them is, with ρ = −r12 |r23| e^{iφ},

    R(λ) = R12 + T12² R23/(1 − R12 R23) − 2 T12 T23/(1 − R12 R23) · Re Σ_{m ≥ 1} ρᵐ exp(−2πi m D/λ)

(the quotients by 1 − R12 R23 sum the repeated reflections). A colour channel is the mean of R(λ) under its
sensitivity, so exp(−2πi D/λ) becomes that sensitivity's Fourier transform S(D): no wavelengths are sampled.
Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence",
equations 6 to 10, with three terms of the sum. As in Cycles, films under 1 nm fade to none, S is interpolated
linearly between 512 nodes, and metal given by two colours has its phases from the complex index that
Gulbrandsen 2014 ("Artist Friendly Metallic Fresnel") finds for them, its reflectances from the F82 curve.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from . import fresnel
from .base import Float32
from .film_sensitivity import NODES, REACH, transforms

Complex64 = NDArray[np.complex64]
Wave = TypeVar("Wave", NDArray[np.float32], NDArray[np.complex64])
Reflectance = Callable[[Float32], Float32]  # of the cosine (N,): (3, N) or (1, N)
THINNEST = 0.1  # nm; thinner films have no effect, as in Cycles
TERMS = 3
TINY = np.float32(1e-9)


class Film(NamedTuple):
    """
    Attributes
    ----------
    thickness : (N,) or (1,) float32
        In nanometres.
    ior : (N,) or (1,) float32
        Its index over that of the viewer's side.
    """

    thickness: Float32
    ior: Float32


Coated = Callable[[Float32, Film], Float32]


def film_of(thickness: Float32 | None, ior: Float32 | None) -> Film | None:
    """The film that two parameters describe; None without them."""
    return None if thickness is None or ior is None else Film(thickness, ior)


def covered(film: Film | None, cos: Float32, coated: Coated, plain: Reflectance) -> Float32:
    """Reflectance with the film where it is thick enough to matter, and without it elsewhere."""
    if film is None:
        return plain(cos)
    there = film.thickness > THINNEST
    if there.all():  # the same bits as below
        return coated(cos, film)
    chosen: Float32 = np.where(there, coated(cos, film), plain(cos))
    return chosen


# ------------------------------------------------------------------------- what is under the film


def over_dielectric(cos: Float32, eta: Float32, film: Film) -> Float32:
    """Reflectance (3, N) of a dielectric of relative index η under a film."""
    n = _index(film)
    r12, g = _amplitudes(cos, n)
    r23, _ = _amplitudes(g / n, eta / n)
    waves = _waves(film, g, _real_tables())
    total = np.zeros((3, waves.shape[-1]), np.float32)
    for upper, lower in zip(r12, r23, strict=True):
        rho: Float32 = -upper * lower
        constant, scale = _airy(upper * upper, lower * lower)
        total += constant + scale * _interference(rho, waves)
    beyond = (eta - 1.0) * (eta + 1.0) + cos * cos <= 0  # as `fresnel.dielectric` has it, to the bit
    f: Float32 = np.maximum(np.clip(0.5 * total, 0.0, 1.0), beyond.astype(np.float32))
    return f


def over_tinted(cos: Float32, eta: Float32, tint: Float32 | None, film: Film) -> Float32:
    """`over_dielectric`, of which the tint scales what is reflected at normal incidence.

    F times tint where F is at most F0 = ((η − 1)/(η + 1))², fading to F times 1 where F is 1 (as Cycles; the
    film's F may be below F0, so `fresnel.tinted` cannot serve).
    """
    f = over_dielectric(cos, eta, film)
    if tint is None:
        return f
    f0 = fresnel.normal_incidence(eta)
    reflects = f0 > 1e-5
    factor = np.minimum(f0 * tint, 1.0) / np.maximum(f0, 1e-5)
    share = np.minimum((1.0 - f) / np.maximum(1.0 - f0, 1e-6), 1.0) * reflects
    scaled: Float32 = f * (1.0 + (factor - 1.0) * share)
    return scaled


def over_conductor(cos: Float32, eta: Float32, k: Float32, film: Film) -> Float32:
    """Reflectance (3, N) of metal of index η + ik, (3, N) or (3, 1) each, under a film."""
    n = _index(film)
    r12, g = _amplitudes(cos, n)
    waves = _waves(film, g, _complex_tables())
    channels = []
    for c in range(3):
        reflectances, phasors = _conductor(g / n, n, eta[c], k[c])
        channels.append(_metal_channel(r12, reflectances, phasors, waves[:, c]))
    return np.stack(channels)


def over_f82(cos: Float32, f0: Float32, b: Float32, film: Film) -> Float32:
    """Reflectance (3, N) of F82-tint metal (see `fresnel.f82`) under a film."""
    n = _index(film)
    r12, g = _amplitudes(cos, n)
    waves, inner = _waves(film, g, _complex_tables()), g / n
    edge = np.minimum(fresnel.f82(np.full(1, 1.0 / 7.0, np.float32), f0, b), 1.0)
    eta, k = artists_index(f0, edge)
    channels = []
    for c in range(3):
        _, phasors = _conductor(inner, n, eta[c], k[c])
        reflectance = _f82_within(inner, eta[c] / n, k[c] / n, edge[c])
        channels.append(_metal_channel(r12, (reflectance, reflectance), phasors, waves[:, c]))
    return np.stack(channels)


def artists_index(r: Float32, g: Float32) -> tuple[Float32, Float32]:
    """η and k of a metal by its reflectance r at normal incidence and its edge tint g (Gulbrandsen's map)."""
    r = np.minimum(r, np.float32(0.999))
    root: Float32 = np.sqrt(r)
    most, least = (1.0 + root) / (1.0 - root), (1.0 - r) / (1.0 + r)
    n: Float32 = most + (least - most) * g
    above, below = n + 1.0, n - 1.0
    k2: Float32 = (r * (above * above) - below * below) / (1.0 - r)
    return n, np.sqrt(np.maximum(k2, 0.0))


def _f82_within(cos: Float32, n: Float32, k: Float32, edge: Float32) -> Float32:
    """The F82 curve of metal of relative index n + ik that reflects `edge` at cosθ = 1/7."""
    k2 = k * k
    above, below = n + 1.0, n - 1.0
    f0 = (below * below + k2) / (above * above + k2)
    schlick = f0 + (1.0 - f0) * fresnel.F82_SCHLICK
    b = (schlick - edge) * fresnel.F82_SCALE
    return np.minimum(fresnel.f82(cos, f0, b), 1.0)


# ------------------------------------------------------------------------- the two faces


def _index(film: Film) -> Float32:
    """The film's index, fading to that of the outside for thicknesses from 1 nm to 0."""
    t: Float32 = np.minimum(np.maximum(film.thickness, 0.0), 1.0)
    index: Float32 = 1.0 + (film.ior - 1.0) * (t * t * (3.0 - 2.0 * t))
    return index


def _amplitudes(cos: Float32, eta: Float32) -> tuple[tuple[Float32, Float32], Float32]:
    """r_s and r_p of a dielectric face, both −1 under total reflection, and g = η cosθt (0 there)."""
    g2 = (eta - 1.0) * (eta + 1.0) + cos * cos
    g = np.sqrt(np.maximum(g2, 0.0))
    total = g2 <= 0
    s = (cos - g) / (cos + g + TINY)
    scaled = eta * eta * cos
    p = (scaled - g) / (scaled + g + TINY)
    r_s: Float32 = s - (1.0 + s) * total
    r_p: Float32 = p - (1.0 + p) * total
    return (r_s, r_p), g


def _conductor(
    cos: Float32, eta1: Float32, eta: Float32, k: Float32
) -> tuple[tuple[Float32, Float32], tuple[Complex64, Complex64]]:
    """Reflectances of metal seen from within index η₁, and e^{iφ} of the phases, each for s and p.

    Born and Wolf, Principles of Optics (7th ed.), 14.4.1, for η + ik: with (u + iv)² = (η + ik)² − η₁² sin²θ,
    r_s = (η₁c − u − iv)/(η₁c + u + iv), whose phase is that of |·|² − (u² + v²) − 2iη₁c v; r_p alike.
    """
    e2, k2, c1 = eta * eta, k * k, eta1 * cos
    t1 = e2 - k2 - eta1 * eta1 * (1.0 - cos * cos)
    ek = 2.0 * eta * k
    t2 = np.hypot(t1, ek)
    u2, v2 = np.maximum(0.5 * (t2 + t1), 0.0), np.maximum(0.5 * (t2 - t1), 0.0)
    u, v = np.sqrt(u2), np.sqrt(v2)
    r_s = ((c1 - u) ** 2 + v2) / ((c1 + u) ** 2 + v2 + TINY)
    a, b = (e2 - k2) * cos, ek * cos
    r_p = ((a - eta1 * u) ** 2 + (b - eta1 * v) ** 2) / ((a + eta1 * u) ** 2 + (b + eta1 * v) ** 2 + TINY)
    phase_s = _phasor(c1 * c1 - u2 - v2, -2.0 * c1 * v)
    phase_p = _phasor(((e2 + k2) * cos) ** 2 - eta1 * eta1 * (u2 + v2), 2.0 * c1 * (ek * u - (e2 - k2) * v))
    return (r_s, r_p), (phase_s, phase_p)


def _phasor(re: Float32, im: Float32) -> Complex64:
    """(re + i im)/|re + i im|; 1 where both are 0."""
    size = np.hypot(re, im)
    none = size == 0
    unit: Complex64 = ((re + none) + 1j * im).astype(np.complex64) / (size + none)
    return unit


# ------------------------------------------------------------------------- Airy's sum


def _metal_channel(
    r12: tuple[Float32, Float32],
    reflectances: tuple[Float32, Float32],
    phasors: tuple[Complex64, Complex64],
    waves: Complex64,
) -> Float32:
    """One channel's reflectance, the mean of both polarisations: (N,). `waves`: (TERMS, N)."""
    total = np.zeros(waves.shape[-1], np.float32)
    for upper, r23, phasor in zip(r12, reflectances, phasors, strict=True):
        constant, scale = _airy(upper * upper, r23)
        rho = (-upper * np.sqrt(r23)) * phasor
        total += constant + scale * _interference(rho, waves.conj())
    f: Float32 = np.clip(0.5 * total, 0.0, 1.0)
    return f


def _airy(r12: Float32, r23: Float32) -> tuple[Float32, Float32]:
    """What does not depend on the wavelength, and the factor of the sum that does."""
    t12 = 1.0 - r12
    quotient = t12 / (1.0 - r12 * r23 + TINY)
    constant: Float32 = r12 + t12 * r23 * quotient
    factor: Float32 = -2.0 * (1.0 - r23) * quotient
    return constant, factor


def _interference(rho: Float32 | Complex64, waves: Float32 | Complex64) -> Float32:
    """Re Σ ρᵐ waves[m − 1]."""
    power = rho
    total: Float32 = (power * waves[0]).real
    for wave in waves[1:]:
        power = power * rho
        total = total + (power * wave).real
    return total


def _waves(film: Film, g: Float32, tables: tuple[Wave, Wave]) -> Wave:
    """S(m D) for m = 1 … TERMS, (TERMS, 3, N): D = 2 d n cosθ₂ = 2 d g, in nanometres."""
    nodes, rises = tables
    at: Float32 = (film.thickness * g) * np.float32(2.0 * (NODES - 1) / REACH)
    waves = np.empty((TERMS, 3, at.size), nodes.dtype)
    for m in range(TERMS):
        place = np.minimum((m + 1) * at, np.float32(NODES - 1))
        index = np.minimum(place.astype(np.int32), NODES - 2)
        t: Float32 = (place - index).astype(np.float32)
        for c in range(3):
            waves[m, c] = nodes[c].take(index, mode="clip") + t * rises[c].take(index, mode="clip")
    return waves


@cache
def _complex_tables() -> tuple[Complex64, Complex64]:
    """`transforms` and its differences from node to node, in single precision."""
    nodes = transforms()
    return nodes.astype(np.complex64), np.diff(nodes, axis=1).astype(np.complex64)


@cache
def _real_tables() -> tuple[Float32, Float32]:
    """Their real parts, which are all that dielectrics need."""
    nodes, rises = _complex_tables()
    return np.ascontiguousarray(nodes.real), np.ascontiguousarray(rises.real)
