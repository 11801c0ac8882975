"""Forms of formulas that keep their digits, each beside the one that textbooks give, which does not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bsdfs import fresnel, microfacet
from ..core import frames
from ..core.distributions import AliasTable, Distribution2D
from ..core.vectors import difference_of_products, normalize
from ..core.warps import cone_pdf, square_to_cone
from ..emitters.rectangle import Rectangle, solid_angle
from ..render.path_state import mis
from .case import Group
from .scattering import COSINES, at_cosine, f32

FORMS = Group("Robust forms")
Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]
Formula = Callable[..., Any]
NONE = float("nan")
SHORT = np.full((3, 1), 1e-30, np.float32)


def exact_fresnel(cos: Float64, eta: Float64 | float) -> Float64:
    """Unpolarised reflectance in float64."""
    g = np.sqrt(np.maximum(np.asarray(eta) ** 2 - 1 + cos * cos, 0))
    s, p = (cos - g) / (cos + g), (eta**2 * cos - g) / (eta**2 * cos + g)
    return np.asarray(0.5 * (s * s + p * p))


def textbook_fresnel(cos: Float32, eta: Float32) -> Float32:
    """The same in float32, with its differences of nearly equal numbers."""
    g = np.sqrt(np.maximum(eta * eta - np.float32(1) + cos * cos, 0))
    s, p = (cos - g) / (cos + g), (eta * eta * cos - g) / (eta * eta * cos + g)
    half: Float32 = np.float32(0.5) * (s * s + p * p)
    return half


def fresnel_error(formula: Formula) -> float:
    """Worst relative error over cosines, for indices that nearly match."""
    cos, eta = (a.ravel().astype(np.float32) for a in np.meshgrid(COSINES[3:], [1 + 2.0**-14, 1 - 2.0**-14]))
    exact = exact_fresnel(cos.astype(np.float64), eta.astype(np.float64))
    return float(np.abs(formula(cos, eta) / exact - 1).max())


@FORMS.case(
    "Fresnel between nearly equal indices",
    "c − g cancels as η → 1",
    "worst relative error at η = 1 ± 2⁻¹⁴, cosines from 1e-4",
    0.0,
    2e-6,
    "some roundings, doubled by a square",
    naive=lambda: fresnel_error(textbook_fresnel),
)
def nearly_matched() -> float:
    return fresnel_error(lambda cos, eta: fresnel.dielectric(cos, eta)[0])


@FORMS.case(
    "out of an index of 100 and 1000",
    "all that passes is nearly straight: η² − 1 + cos²θ is −1 + 1",
    "worst relative error of g = η cosθt, up to 0.99 of the critical angle's sine",
    0.0,
    1e-6,
    "some roundings",
    naive=lambda: dense_error(lambda cos, eta: (eta - 1) * (eta + 1) + cos * cos),
)
def out_of_dense() -> float:
    return dense_error(fresnel.g_squared)


def dense_error(formula: Formula) -> float:
    """Of the root of g² against float64, for indices 1e-2 and 1e-3 of the far side."""
    worst = 0.0
    for eta in np.array([[1e-2], [1e-3]], np.float32):
        sine = eta.astype(np.float64) * np.array([0.0, 0.3, 0.7])
        cos = np.sqrt((1 - sine) * (1 + sine)).astype(np.float32)
        c = cos.astype(np.float64)
        exact = np.sqrt(eta.astype(np.float64) ** 2 - (1 - c) * (1 + c))
        worst = max(worst, float(np.abs(np.sqrt(np.maximum(formula(cos, eta), 0)) / exact - 1).max()))
    return worst


@FORMS.case(
    "grazing to a cosine of 0",
    "Smith's Λ is a quotient by the cosine, and the density of visible normals G1/cosθ one more",
    "worst relative error of G1/cosθ of GGX, α = 0.3, cosines from 0",
    0.0,
    1e-6,
    "some roundings",
    naive=lambda: masking_error(textbook_masking),
)
def grazing() -> float:
    return masking_error(robust_masking)


def masking_error(formula: Formula) -> float:
    """Of G1/cosθ = 2/(cosθ + √(cos²θ + α² sin²θ)) against float64."""
    w = at_cosine(np.array([0.0, 1e-25, *COSINES]))
    z = w[2].astype(np.float64)
    exact = 2 / (z + np.sqrt(z * z + 0.3**2 * (1 - z * z)))
    error = np.abs(formula(w, f32(0.3)) / exact - 1)
    return float(error.max()) if np.isfinite(error).all() else float("nan")


def robust_masking(w: Float32, alpha: Float32) -> Float32:
    """2/(z + t), as the engine has it."""
    a2 = alpha * alpha
    quotient: Float32 = 2 / (w[2] + microfacet.GGX.stretched(w, a2, a2))
    return quotient


def textbook_masking(w: Float32, alpha: Float32) -> Float32:
    """Λ = (√(1 + α² tan²θ) − 1)/2, G1 = 1/(1 + Λ) (Heitz 2014, equation 72)."""
    tan2 = (1 - w[2] * w[2]) / (w[2] * w[2])
    g1: Float32 = 2 / (1 + np.sqrt(1 + alpha * alpha * tan2))
    g1 /= w[2]
    return g1


@FORMS.case(
    "refraction's Jacobian between nearly equal indices",
    "|h| = c − g cancels, and is squared",
    "worst relative error of |h|² at η = 1 + 2⁻¹⁴",
    0.0,
    1e-6,
    "some roundings",
    naive=lambda: jacobian_error(lambda c, g, eta: (c - g) ** 2),
)
def jacobian() -> float:
    return jacobian_error(lambda c, g, eta: ((eta - 1) * (eta + 1) / (c + g)) ** 2)


def jacobian_error(formula: Formula) -> float:
    """Of |h|² against float64, over cosines from 0.1."""
    cos, eta = COSINES[-3:].astype(np.float32), np.full(3, 1 + 2.0**-14, np.float32)
    g = fresnel.dielectric(cos, eta)[1]
    exact = (
        cos.astype(np.float64) - np.sqrt(eta.astype(np.float64) ** 2 - 1 + cos.astype(np.float64) ** 2)
    ) ** 2
    return float(np.abs(formula(cos, g, eta) / exact - 1).max())


@FORMS.case(
    "differences of products",
    "a b − c d of nearly equal products loses all digits in float32",
    "worst relative error over 10,000 nearly parallel pairs",
    0.0,
    1e-6,
    "correctly rounded",
    naive=lambda: product_error(lambda a, b, c, d: a * b - c * d),
)
def products() -> float:
    return product_error(difference_of_products)


def product_error(formula: Formula) -> float:
    """Against float64, in which float32 products are exact."""
    rng = np.random.default_rng(1)
    a, d = rng.random((2, 10_000), np.float32) + np.float32(1)
    c, b = a * np.float32(1 + 1e-6), d * np.float32(1 + 2e-6)
    exact = a.astype(np.float64) * b - c.astype(np.float64) * d
    kept = exact != 0
    return float(np.abs(formula(a, b, c, d)[kept] / exact[kept] - 1).max())


@FORMS.case(
    "vectors of length 1e-30",
    "their squares underflow to 0: 0/0",
    "largest component after normalising",
    1e-30,
    1e-31,
    "they stay as short as they are",
    naive=lambda: float(np.max(SHORT / np.sqrt((SHORT * SHORT).sum(axis=0)))),
)
def short_vectors() -> float:
    return float(np.max(normalize(SHORT)))


@FORMS.case(
    "the cone of a small ball",
    "1 − cosθ in float32 has one digit left at θ = 1e-3, none at 1e-4",
    "largest relative error of the solid angle for θ = 1e-5 … 1",
    0.0,
    1e-6,
    "some roundings",
    naive=lambda: cone_error(lambda sin2: 1 - np.sqrt(1 - sin2)),
)
def small_cones() -> float:
    return cone_error(lambda sin2: sin2 / (1 + np.sqrt(1 - sin2)))


def cone_error(formula: Formula) -> float:
    """Of 1 − cosθ from sin²θ, as the engine passes it to its cones."""
    theta = np.array([1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0])
    one_minus_cos = formula((np.sin(theta) ** 2).astype(np.float32))
    zero = np.zeros(6, np.float32)
    with np.errstate(divide="ignore", invalid="ignore"):
        pdf = cone_pdf(square_to_cone(zero, zero, one_minus_cos), one_minus_cos)
    return float(np.abs(pdf * 2 * np.pi * 2 * np.sin(theta / 2) ** 2 - 1).max())


@FORMS.case(
    "a small rectangle's solid angle",
    "the sum of its four angles minus 2π has no digits left",
    "worst relative error for edges of 1e-1 … 1e-4 at distance 1, seen askew",
    0.0,
    1e-3,
    "four arc tangents that differ in their last digits; below 0.01 sr the engine samples the area",
    naive=lambda: rectangle_error(girard),
)
def small_rectangles() -> float:
    return rectangle_error(
        lambda x0, x1, y0, y1: solid_angle(
            Rectangle(*(np.array([v], np.float32) for v in (x0, x1, y0, y1, 1.0, 1.0)))
        )[0]
    )


def rectangle_error(formula: Formula) -> float:
    """Against A cosθ/d², good to the square of the edge."""
    worst_error = 0.0
    for edge in (3e-2, 1e-2):
        x0, y0 = 0.3, -0.2
        x, y = x0 + edge / 2, y0 + edge / 2
        exact = edge * edge / (1 + x * x + y * y) ** 1.5
        worst_error = max(worst_error, abs(float(formula(x0, x0 + edge, y0, y0 + edge)[0]) / exact - 1))
    return worst_error


def girard(x0: float, x1: float, y0: float, y1: float) -> Float32:
    """γ0 + γ1 + γ2 + γ3 − 2π of Ureña et al. 2013, in float32."""
    corners = np.array([(x0, y0, -1), (x1, y0, -1), (x1, y1, -1), (x0, y1, -1)], np.float32)
    n = [np.cross(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    n = [v / np.sqrt((v * v).sum()) for v in n]
    angles = [np.arccos(-np.clip((n[k] * n[(k + 1) % 4]).sum(), -1, 1)) for k in range(4)]
    return np.array([sum(angles, start=np.float32(0)) - np.float32(2 * np.pi)], np.float32)


@FORMS.case(
    "MIS of densities from 1e-30 to 1e30",
    "squares of densities overflow float32 at 1e19, and ∞/∞ is no weight",
    "largest deviation of w(p, q) + w(q, p) from 1",
    0.0,
    1e-6,
    "rounding",
    naive=lambda: heuristic(lambda p, q: p * p / (p * p + q * q)),
)
def heuristics() -> float:
    return heuristic(mis)


def heuristic(weight: Formula) -> float:
    """Over pairs of densities, a Dirac one (∞) among them."""
    line = np.array([1e-30, 1e-12, 1.0, 1e12, 1e20, 1e30], np.float32)
    p, q = (a.ravel() for a in np.meshgrid(line, line))
    error = np.abs(weight(p, q) + weight(q, p) - 1)
    dirac = weight(np.full(1, np.inf, np.float32), np.ones(1, np.float32))
    return float(max(error.max(), abs(dirac[0] - 1))) if np.isfinite([*error, *dirac]).all() else NONE


@FORMS.case(
    "tables with rows and entries of weight 0",
    "a cumulative sum finds the first of several equal entries, which may have weight 0",
    "samples drawn with probability 0, of 10,000, u = 0 and the largest u among them",
    0.0,
    0.0,
    "never",
    naive=lambda: zero_draws(by_bisection),
)
def zero_weights() -> float:
    sky = np.zeros((8, 16))
    sky[4, 2:9] = 1.0
    line = np.linspace(0, 1 - 2**-24, 100, dtype=np.float32)
    u, v = (a.ravel() for a in np.meshgrid(line, line))
    density = Distribution2D(sky).sample(u, v)[2]
    return zero_draws(lambda weights, x: AliasTable(weights).sample(x)[0]) + float(
        np.count_nonzero(density == 0)
    )


def zero_draws(draw: Formula) -> float:
    """How many of 10,000 draws are of weight 0."""
    weights = np.array([0.0, 0.0, 1.0, 0.0, 3.0, 0.0])
    u = np.linspace(0, 1 - 2**-24, 10_000, dtype=np.float32)
    return float(np.count_nonzero(weights[draw(weights, u)] == 0))


def by_bisection(weights: Float64, u: Float32) -> NDArray[np.integer]:
    """The first entry whose cumulative sum reaches u."""
    return np.searchsorted(np.cumsum(weights / weights.sum()), u)


@FORMS.case(
    "frames about −Z",
    "Frisvad's frame divides by 1 + n_z",
    "largest deviation of a frame from an orthonormal one",
    0.0,
    1e-6,
    "some roundings of numbers up to 1",
    naive=lambda: orthonormality(frisvad),
)
def poles() -> float:
    return orthonormality(frames.frame)


def orthonormality(make_frame: Formula) -> float:
    """Of frames about −Z and its neighbours."""
    tilt = np.array([0.0, 1e-7, 1e-4, 1e-3], np.float32)
    n = np.stack([tilt, np.zeros_like(tilt), -np.sqrt(1 - tilt * tilt)])
    s, t = make_frame(n)
    basis = np.stack([s, t, n])
    gram = np.einsum("icn,jcn->ijn", basis, basis)
    return float(np.abs(gram - np.eye(3)[..., None]).max())


def frisvad(n: Float32) -> tuple[Float32, Float32]:
    """Frisvad 2012: continuous but for the south pole, near which it cancels."""
    a = 1 / (1 + n[2])
    b = -n[0] * n[1] * a
    return np.stack([1 - n[0] * n[0] * a, b, -n[0]]), np.stack([b, 1 - n[1] * n[1] * a, -n[1]])
