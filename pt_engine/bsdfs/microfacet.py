"""Rough surfaces made of tiny mirrors: GGX and Beckmann normals m under Smith's masking.

Everything is told through t(w), the "stretched length" of a direction w = (x, y, z),

    GGX       t(w) = √(αx²x² + αy²y² + z²)            Smith: Λ(w) = (t/z − 1)/2
    Beckmann  t(w) = z (1 + 2Λ(w)),  Λ = exp(−a²)/(2a√π) − erfc(a)/2,  a = z/√(αx²x² + αy²y²) = z/r

so that G1(w) = 1/(1 + Λ) = 2z/(z + t) and, height-correlated, G2 = 1/(1 + Λi + Λo) =
2 zi zo/(zi to + zo ti): no quotient by a cosine is left, and grazing angles are harmless. Hence

    D_visible(m) = G1(wi) D(m) (wi·m)/zi = 2 D(m) (wi·m)/(zi + ti)
    G2/G1 = zo (zi + ti)/(zi to + zo ti)

which is the weight of a sample drawn from the visible normals.

Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs" (JCGT 3(2));
Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"; for Beckmann: Heitz and d'Eon
2014, inverted as in Jakob 2014, "An Improved Visible Normal Sampling Routine for the Beckmann
Distribution". Both take any αx, αy > 0.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from .base import Float32
from .erf import erf, erfc_scaled, inverse_erf

PI = float(np.pi)
INV_PI = 1.0 / PI
INV_SQRT_PI = PI**-0.5
TINY = 1e-37

# αx αy below this is a mirror (as in Cycles): a lobe of α = 1.4e-5 is as narrow as float32 resolves.
SMOOTH = 2e-10
LEAST_ALPHA = 1e-5


class Distribution(Protocol):
    """A distribution of normals."""

    @staticmethod
    def stretched(w: Float32, ax2: Float32, ay2: Float32) -> Float32: ...
    @staticmethod
    def density(hx: Float32, hy: Float32, hz: Float32, ax: Float32, ay: Float32) -> Float32: ...
    @staticmethod
    def visible_normal(wi: Float32, ax: Float32, ay: Float32, u1: Float32, u2: Float32) -> Float32: ...


def roughness(alpha_x: Float32, alpha_y: Float32 | None) -> tuple[Float32, Float32, Float32]:
    """αx, αy within [1e-5, 1] (one and the same array if isotropic), and 1 where the lobe is a Dirac one."""
    ax: Float32 = np.minimum(np.maximum(alpha_x, LEAST_ALPHA), 1.0)
    ay: Float32 = ax if alpha_y is None else np.minimum(np.maximum(alpha_y, LEAST_ALPHA), 1.0)
    return ax, ay, (ax * ay <= SMOOTH).astype(ax.dtype)


def squares(ax: Float32, ay: Float32) -> tuple[Float32, Float32]:
    """αx² and αy², one and the same array if isotropic."""
    ax2 = ax * ax
    return ax2, ax2 if ax is ay else ay * ay


def masking_ratio(zi: Float32, ti: Float32, zo: Float32, to: Float32) -> Float32:
    """G2/G1(wi) = zo (zi + ti)/(zi to + zo ti), within [0, 1] for zi, zo ≥ 0."""
    both: Float32 = zi * to + zo * ti
    ratio: Float32 = zo * (zi + ti) / (both + TINY)
    return ratio


class GGX:
    """D(m) = 1/(π αx αy e²), e = mx²/αx² + my²/αy² + mz²."""

    @staticmethod
    def stretched(w: Float32, ax2: Float32, ay2: Float32) -> Float32:
        """t(w): (N,). `ax2` and `ay2` are αx² and αy²."""
        t: Float32 = np.sqrt(_stretched2(w, ax2, ay2) + w[2] * w[2])
        return t

    @staticmethod
    def density(hx: Float32, hy: Float32, hz: Float32, ax: Float32, ay: Float32) -> Float32:
        """D(h/|h|)/|h|⁴: of a half vector of any length, (N,)."""
        e = _slope2(hx, hy, ax, ay) + hz * hz
        e *= e
        d: Float32 = INV_PI / (ax * ay * e + TINY)
        return d

    @staticmethod
    def visible_normal(wi: Float32, ax: Float32, ay: Float32, u1: Float32, u2: Float32) -> Float32:
        """m drawn from D_visible, unit (3, N); (0, 0, 1) where α is 0.

        On the stretched hemisphere mirrored rays fill a cap of cosθ > −wi_z evenly; the half vector, shrunk
        back, is the normal. q = u2 (1 + wi_z) is 1 − cosθ on the cap, from which nothing cancels.
        """
        x, y, z = ax * wi[0], ay * wi[1], wi[2]
        inverse = 1.0 / np.sqrt(x * x + y * y + z * z)
        above = 1.0 + z * inverse
        q = u2 * above
        sine = np.sqrt(q * (2.0 - q))
        phi = u1 * np.float32(2.0 * PI)
        m = np.empty(wi.shape, wi.dtype)
        m[0] = ax * (sine * np.cos(phi) + x * inverse)
        m[1] = ay * (sine * np.sin(phi) + y * inverse)
        m[2] = above - q
        m *= 1.0 / np.sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2] + TINY)
        return m


class Beckmann:
    """D(m) = exp(−(mx²/αx² + my²/αy²)/mz²)/(π αx αy mz⁴)."""

    @staticmethod
    def stretched(w: Float32, ax2: Float32, ay2: Float32) -> Float32:
        """t(w) = z + exp(−a²)(r/√π − z exp(a²) erfc(a)), r = z/a: (N,)."""
        z = np.abs(w[2])
        r = np.sqrt(_stretched2(w, ax2, ay2))
        a = z / (np.maximum(r, z * (1 / 9)) + TINY)  # at most 9: beyond, exp(−a²) is 0
        t: Float32 = z + np.exp(-a * a) * (r * INV_SQRT_PI - z * erfc_scaled(a))
        return t

    @staticmethod
    def density(hx: Float32, hy: Float32, hz: Float32, ax: Float32, ay: Float32) -> Float32:
        """D(h/|h|)/|h|⁴: of a half vector of any length, (N,)."""
        # flatter than tan²θ = 1000 the density is 0 for any α ≤ 1
        z2 = np.maximum(hz * hz, 1e-3 * (hx * hx + hy * hy)) + 1e-13
        d: Float32 = np.exp(-np.minimum(_slope2(hx, hy, ax, ay) / z2, 88.0)) * (INV_PI / (ax * ay))
        d /= z2
        d /= z2
        return d

    @staticmethod
    def visible_normal(wi: Float32, ax: Float32, ay: Float32, u1: Float32, u2: Float32) -> Float32:
        """m drawn from D_visible, unit (3, N); (0, 0, 1) where α is 0."""
        x, y, z = ax * wi[0], ay * wi[1], wi[2]
        sine = np.sqrt(x * x + y * y)
        tan = sine / np.maximum(z, 1e-9)
        along = _visible_slope(np.minimum(tan, 1e6), u1)
        across = inverse_erf(2.0 * u2 - 1.0)
        inverse = 1.0 / (sine + TINY)
        c, s = x * inverse, y * inverse
        c = c + (sine <= 0)  # from straight above any azimuth will do
        m = np.empty(wi.shape, wi.dtype)
        m[0] = -ax * (c * along - s * across)
        m[1] = -ay * (s * along + c * across)
        m[2] = 1.0
        m *= 1.0 / np.sqrt(m[0] * m[0] + m[1] * m[1] + 1.0)
        return m


def _stretched2(w: Float32, ax2: Float32, ay2: Float32) -> Float32:
    """αx²x² + αy²y²."""
    if ax2 is ay2:
        r: Float32 = (w[0] * w[0] + w[1] * w[1]) * ax2
    else:
        r = w[0] * w[0] * ax2 + w[1] * w[1] * ay2
    return r


def _slope2(hx: Float32, hy: Float32, ax: Float32, ay: Float32) -> Float32:
    """hx²/αx² + hy²/αy²."""
    if ax is ay:
        r: Float32 = (hx * hx + hy * hy) * (1.0 / (ax * ax))
    else:
        r = hx * hx * (1.0 / (ax * ax)) + hy * hy * (1.0 / (ay * ay))
    return r


def _visible_slope(tan: Float32, u: Float32) -> Float32:
    """The slope x along wi, of density ∝ max(0, 1 − x tanθ) exp(−x²), at the quantile u.

    With b = erf(x), 1 + b + K exp(−x²) = u (1 + erf(cotθ) + K exp(−cot²θ)), K = tanθ/√π. The left side is
    concave in b, so that Newton's steps, held within the bracket, come to the root.
    """
    cot = 1.0 / np.maximum(tan, 1e-6)
    k = tan * INV_SQRT_PI
    upper = erf(np.minimum(cot, 10.0))
    goal = u * (1.0 + upper + k * np.exp(-np.minimum(cot * cot, 80.0)))
    # start: exp(−x²) ≈ 1 − b² makes it a quadratic in b
    root = np.sqrt(np.maximum(k * (k - u * (1.0 + upper + k * (1.0 - upper * upper)) + 1.0) + 0.25, 0.0))
    b = (u * (1.0 + upper + k * (1.0 - upper * upper)) - 1.0 - k) / (0.5 + root)
    low, high = np.full_like(b, -1.0), upper.copy()
    b = np.minimum(np.maximum(b, low), high)
    for _ in range(NEWTON_STEPS):
        x = inverse_erf(b)
        excess = 1.0 + b + k * np.exp(-x * x) - goal
        below = excess < 0
        low = np.maximum(low, b - (b + 1.0) * ~below)
        high = np.minimum(high, b + (2.0 - b) * below)
        slope = 1.0 - x * tan
        step = b - excess / np.copysign(np.maximum(np.abs(slope), 1e-4), slope)
        inside = (step >= low) & (step <= high)
        middle = 0.5 * (low + high)
        b = middle + (np.minimum(np.maximum(step, low), high) - middle) * inside
    slope_x: Float32 = inverse_erf(b)
    return slope_x


NEWTON_STEPS = 6
