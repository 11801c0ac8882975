"""Fresnel reflectance: how much of the light an ideally smooth interface sends back.

Dielectric, relative index η (far side over near side), c = cosθi, g = η cosθt = √((η−1)(η+1) + c²):

    r_s = (c − g)/(c + g) = −d/(c + g)²            d = (η − 1)(η + 1)
    r_p = (η²c − g)/(η²c + g) = d((η² + 1)c² − 1)/(η²c + g)²            F = (r_s² + r_p²)/2

The right-hand forms have no difference of nearly equal numbers: they hold their digits for η → 1 and at
grazing angles. Under total reflection F = 1.

Conductor, index η + ik: Born and Wolf, Principles of Optics (7th ed.), 14.4.1.

F82-tint: Kutz, Hašan, Edmondson 2021, "Novel aspects of the Adobe Standard Material":
F = Schlick(c) − b c (1 − c)⁶, with b such that F(c = 1/7) is Schlick's value times the tint.

Averages over the hemisphere, F_avg = 2∫ F(c) c dc, serve the energy that single scattering misses.
"""

from __future__ import annotations

import numpy as np

from .base import Float32

TINY = 1e-37
DENSE = np.float32(0.5)  # index of the far side below which the near one counts as dense
LARGEST_INDEX = np.float32(1e6)  # a perfect mirror for float32; its powers do not overflow
F82_SCHLICK = (6.0 / 7.0) ** 5  # (1 − c)⁵ at c = 1/7
F82_SCALE = 7.0 / (6.0 / 7.0) ** 6  # 1 / (c (1 − c)⁶) at c = 1/7


def dielectric(cos_i: Float32, eta: Float32) -> tuple[Float32, Float32]:
    """Unpolarised reflectance and g = η cosθt (0 under total reflection).

    Parameters
    ----------
    cos_i : (N,) float32
        Against the interface's normal, ≥ 0.
    eta : (N,) or (1,) float32
        Relative index, > 0.
    """
    eta = np.minimum(eta, LARGEST_INDEX)
    d = (eta - 1.0) * (eta + 1.0)
    cos2 = cos_i * cos_i
    g2 = g_squared(cos_i, eta)
    total = g2 <= 0
    d = d * ~total
    g = np.sqrt(np.maximum(g2, 0.0))
    eta2 = eta * eta
    s = cos_i + g
    p = eta2 * cos_i + g
    s = d / (s * s + TINY)
    p = d * ((eta2 + 1.0) * cos2 - 1.0) / (p * p + TINY)
    s *= s
    p *= p
    s += p
    reflectance: Float32 = np.minimum(0.5 * s + total, 1.0)
    return reflectance, g


def g_squared(cos_i: Float32, eta: Float32) -> Float32:
    """g² = η² − sin²θi, (N,); below 0 under total reflection.

    As (η − 1)(η + 1) + cos²θi it keeps its digits where η is near 1. Out of dense matter, where all that
    passes is nearly straight, that is −1 + 1; there sin²θi is small.
    """
    g2: Float32 = (eta - 1.0) * (eta + 1.0) + cos_i * cos_i
    dense = eta < DENSE
    if dense.any():
        g2 = np.where(dense, eta * eta - (1.0 - cos_i) * (1.0 + cos_i), g2)
    return g2


def normal_incidence(eta: Float32) -> Float32:
    """F(0°) = ((η − 1)/(η + 1))²."""
    r: Float32 = (eta - 1.0) / (eta + 1.0)
    return r * r


def index_of(f0: Float32) -> Float32:
    """The index η ≥ 1 whose reflectance at normal incidence is `f0` (at most 0.99)."""
    root: Float32 = np.sqrt(np.minimum(np.maximum(f0, 0.0), 0.99))
    index: Float32 = (1.0 + root) / (1.0 - root)
    return index


def dielectric_average(eta: Float32) -> Float32:
    """Hemispherical average: fits of Kulla and Conty 2017, "Revisiting Physically Based Shading"."""
    below: Float32 = (eta < 1.0).astype(eta.dtype)
    inner: Float32 = np.minimum(eta, 1.0)
    inside = inner * (inner * (inner * -0.130607 - 0.965241) + 0.1014) + 0.997118
    average: Float32 = (eta - 1.0) / (eta * 1.00071 + 4.08567)
    np.maximum(average, 0.0, out=average)
    average += below * inside
    return average


def schlick(cos_i: Float32, f0: Float32) -> Float32:
    """F0 + (1 − F0)(1 − c)⁵."""
    m: Float32 = np.maximum(1.0 - cos_i, 0.0)
    m2 = m * m
    rise: Float32 = m2 * m2 * m
    f: Float32 = f0 + (1.0 - f0) * rise
    return f


def f82_slope(f0: Float32, tint: Float32) -> Float32:
    """b of the F82-tint model: (3, N)."""
    b: Float32 = (f0 + (1.0 - f0) * F82_SCHLICK) * (1.0 - tint) * F82_SCALE
    return b


def f82(cos_i: Float32, f0: Float32, b: Float32) -> Float32:
    """Schlick(c) − b c (1 − c)⁶, not below 0 (nor above 1, for colours and tints in [0, 1]): (3, N)."""
    m: Float32 = np.maximum(1.0 - cos_i, 0.0)
    m2 = m * m
    m5 = m2 * m2 * m
    f: Float32 = b * (cos_i * m)
    f = (1.0 - f0) - f
    f *= m5
    f += f0
    return np.maximum(f, 0.0, out=f)


def f82_average(f0: Float32, b: Float32) -> Float32:
    """2∫ F c dc = F0 + (1 − F0)/21 − b/126."""
    average: Float32 = f0 + (1.0 - f0) * (1.0 / 21.0) - b * (1.0 / 126.0)
    return average


def conductor(cos_i: Float32, eta: Float32, k: Float32) -> Float32:
    """Unpolarised reflectance against index η + ik, (3, N) or (3, 1): (3, N)."""
    cos2 = cos_i * cos_i
    # channel by channel: three times smaller temporaries stay in the cache
    return np.stack([_conductor(cos_i, cos2, eta[c], k[c]) for c in range(len(eta))])


def _conductor(c: Float32, c2: Float32, eta: Float32, k: Float32) -> Float32:
    """With u + iv = √(t + 2iηk), t = η² − k² − sin²θ, r = |u + iv|²:

    R_s = (r + c² − 2uc)/(r + c² + 2uc)        R_p = R_s (r c² + s⁴ − 2uc s²)/(r c² + s⁴ + 2uc s²)
    """
    ek = eta * k
    t = c2 + ((eta - 1.0) * (eta + 1.0) - k * k)
    r = np.sqrt(t * t + 4.0 * (ek * ek))
    # the larger of u and v by the root, the smaller from u v = ηk, which cannot cancel
    larger = np.sqrt(0.5 * (r + np.abs(t)))
    smaller = ek / (larger + TINY)
    u = smaller + (t >= 0) * (larger - smaller)
    u *= 2.0 * c
    s2 = 1.0 - c2
    a = r + c2
    b = r * c2 + s2 * s2
    s = (a - u) / (a + u + TINY)
    u *= s2
    f: Float32 = 0.5 * s * (1.0 + (b - u) / (b + u + TINY))
    return f


def conductor_average(eta: Float32, k: Float32) -> Float32:
    """Hemispherical average, by the F82 model through the values at 0° and cosθ = 1/7 (as Cycles)."""
    f0 = conductor(np.ones(1, np.float32), eta, k)
    f82_value = conductor(np.full(1, 1.0 / 7.0, np.float32), eta, k)
    b = (f0 + (1.0 - f0) * F82_SCHLICK - f82_value) * F82_SCALE
    average: Float32 = np.clip(f82_average(f0, b), 0.0, 1.0)
    return average


def tinted(f: Float32, eta: Float32, tint: Float32) -> Float32:
    """A dielectric's reflectance f with its value at normal incidence times `tint`, 1 staying 1: (3, N)."""
    f0 = normal_incidence(eta)
    s = (f - f0) / np.maximum(1.0 - f0, 1e-6)
    s = np.minimum(np.maximum(s, 0.0), 1.0)
    base = np.minimum(f0 * tint, 1.0)
    colored: Float32 = base + (1.0 - base) * s
    return colored
