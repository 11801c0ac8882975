"""What every scattering model must fulfil, as functions that its tests call."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pt_engine.bsdfs.base import BSDFSample, Lobe, gather

from .chi2 import chi2_sphere

Array = NDArray[np.float32]
LARGEST = np.float32(1 - 2**-24)  # the largest uniform
# of microfacets: alpha_x, alpha_y, cosine, azimuth
LOBES = [
    (1.0, None, 0.9, 0.0),
    (1.0, None, 0.05, 0.0),
    (0.3, None, 1.0, 0.0),
    (0.3, None, 0.2, 2.0),
    (0.1, None, 0.7, 0.0),
    (0.1, 0.5, 0.5, 0.6),
    (1.0, 0.05, 0.3, 1.2),
]
NARROW = [(0.01, None, 0.6, 0.5), (0.001, None, 0.9, 0.0), (0.002, None, 0.1, 0.0)]


def f32(*values: float) -> Array:
    """A parameter: (1,), or (3, 1) of three numbers."""
    array = np.array(values, np.float32)
    return array if len(values) == 1 else array[:, np.newaxis]


def direction(cos: float, phi: float = 0.0) -> Array:
    """(3, 1) unit vector."""
    sine = np.sqrt((1 - cos) * (1 + cos))
    return np.array([[sine * np.cos(phi)], [sine * np.sin(phi)], [cos]], np.float32)


def repeat(w: Array, n: int) -> Array:
    """(3, n) copies of a (3, 1) vector."""
    return np.repeat(w, n, axis=1)


def uniforms(n: int, seed: int = 1) -> Array:
    """(3, n) float32 in [0, 1)."""
    return np.random.default_rng(seed).random((3, n), np.float32)


def is_dirac(s: BSDFSample) -> NDArray[np.bool_]:
    """Which lanes sampled a Dirac lobe."""
    return np.broadcast_to((np.asarray(s.lobe) & Lobe.DELTA) != 0, s.pdf.shape)


def chi2(model: ModuleType, params: Any, wi: Array, *, n: int = 100_000, **options: Any) -> float:
    """p-value of the sampler against the density; Dirac samples and failed ones count as outside."""

    def draw(u0: Array, u1: Array, u2: Array) -> tuple[Array, NDArray[np.bool_]]:
        s = model.sample(params, repeat(wi, len(u0)), u0, u1, u2)
        return s.wo, (s.weight.max(axis=0) > 0) & ~is_dirac(s)

    def pdf(wo: Array) -> Array:
        return model.eval_pdf(params, repeat(wi, wo.shape[1]), wo)[1]

    return chi2_sphere(draw, pdf, n=n, **options)


def chi2_about_mirror(model: ModuleType, params: Any, wi: Array, alpha: float) -> float:
    """The same on a grid about the mirror direction that spans a few α."""
    x, y, z = (float(c) for c in wi[:, 0])
    return chi2(model, params, wi, pole=(-x, -y, z), cap=float(1 - np.cos(min(8 * alpha, 1.0))))


def square_midpoints(rows: int) -> Array:
    """(2, rows²) centres of the cells of the unit square."""
    x = ((np.arange(rows) + 0.5) / rows).astype(np.float32)
    u, v = np.meshgrid(x, x)
    return np.stack([u.ravel(), v.ravel()])


def directional_albedo(
    model: ModuleType, params: Any, wi: Array, rows: int = 160, choices: int = 16
) -> NDArray[np.float64]:
    """∫ f·|cosθo| dωo = E[weight], (channels,): by the midpoint rule in the sampler's own square.

    `choices` stratifies the number that picks the lobe: (3 · rows² · choices) evaluations, error O(1/rows²)
    where the weight is smooth and O(1/choices/rows) from the choice.
    """
    cells = square_midpoints(rows)
    n = cells.shape[1]
    # a lattice in the third dimension: each cell gets its own offset, so the choice is stratified finely
    offset = np.arange(n, dtype=np.float64) * 0.6180339887498949 % 1.0
    total: NDArray[np.float64] = np.zeros(1)
    for k in range(choices):
        u0 = np.minimum(((k + offset) / choices).astype(np.float32), LARGEST)
        weight = model.sample(params, repeat(wi, n), u0, *cells).weight
        total = total + weight.mean(axis=1, dtype=np.float64)
    return total / choices


def check_weight_is_value_over_pdf(
    model: ModuleType, params: Any, wi: Array, rtol: float, n: int = 4096, seed: int = 3
) -> None:
    """At sampled directions `eval_pdf` tells the sampler's own pdf and weight · pdf, for most to `rtol`.

    The half vector is found again from float32 directions; so only quantiles are held to `rtol`.
    """
    s = model.sample(params, repeat(wi, n), *uniforms(n, seed))
    value, pdf = model.eval_pdf(params, repeat(wi, n), s.wo)
    keep = (s.weight.max(axis=0) > 0) & ~is_dirac(s)
    if not keep.any():
        return
    density = np.quantile(np.abs(pdf[keep] / s.pdf[keep] - 1), 0.99)
    expected = np.broadcast_to(s.weight, (3, n))[:, keep] * s.pdf[keep]
    error = np.abs(np.broadcast_to(value, (3, n))[:, keep] - expected) / (expected + (expected == 0))
    if density > rtol or np.quantile(error, 0.99) > rtol:
        raise AssertionError(f"pdf off by {density:.2e}, value by {np.quantile(error, 0.99):.2e}")


def hostile_uniforms() -> Array:
    """(3, 125) corners, edges and middles of the unit cube."""
    ends = np.array([0.0, 1e-7, 0.5, 1 - 1e-6, LARGEST], np.float32)
    return np.stack([g.ravel() for g in np.meshgrid(ends, ends, ends)])


HOSTILE_COSINES = (1e-7, 1e-6, 1e-4, 0.01, 0.3, 1 - 1e-7, 1.0)


def check_finite(
    model: ModuleType, params: Any, weight_bound: float = 1.0001, length_error: float = 1e-5
) -> None:
    """Samples, densities and values are finite and not negative at hostile angles and uniforms."""
    u = hostile_uniforms()
    n = u.shape[1]
    for cos in HOSTILE_COSINES:
        for phi in (0.0, 0.7, np.pi / 2):
            wi = repeat(direction(cos, phi), n)
            s = model.sample(params, wi, *u)
            kept = s.weight.max(axis=0) > 0
            _finite(s.weight, s.pdf, s.wo)
            if s.weight.max() > weight_bound or s.weight.min() < 0:
                raise AssertionError(f"weight {s.weight.min()} … {s.weight.max()} at cosine {cos}")
            length = np.sqrt((s.wo.astype(np.float64) ** 2).sum(axis=0))[kept]
            if length.size and np.abs(length - 1).max() > length_error:
                raise AssertionError(f"direction of length {length.min()} … {length.max()}")
            given = [repeat(direction(c, p), n) for c in (cos, -cos, 0.5, -1.0) for p in (phi, 3.0)]
            for wo in (s.wo, *given):
                value, pdf = model.eval_pdf(params, wi, wo)
                _finite(value, pdf)
                if min(value.min(), pdf.min()) < 0:
                    raise AssertionError("a negative value or density")
            if not np.isfinite(model.albedo(params, wi[2])).all():
                raise AssertionError("albedo is not finite")


def _finite(*arrays: Array) -> None:
    for array in arrays:
        if array.dtype != np.float32:
            raise AssertionError(f"promoted to {array.dtype}")
        if not np.isfinite(array).all():
            raise AssertionError("not finite")


def check_lanes_are_independent(model: ModuleType, params: Any, n: int = 37) -> None:
    """Any subset of lanes, in any order, gives the same bits: also one lane, or parameters per lane."""
    rng = np.random.default_rng(5)
    wi, wo = _random_directions(rng, n), _random_directions(rng, n)
    wi[2] = np.abs(wi[2])
    u = uniforms(n)
    whole_eval, whole = model.eval_pdf(params, wi, wo), model.sample(params, wi, *u)
    spread = type(params)(*(p if p is None else p + np.zeros(n, np.float32) for p in params))
    for index in (rng.permutation(n), np.array([5]), np.array([7, 3])):
        part, w, v = gather(spread, index), wi.take(index, axis=1), wo.take(index, axis=1)
        some_eval, some = model.eval_pdf(part, w, v), model.sample(part, w, *u.take(index, axis=1))
        for a, b in zip((*whole_eval, *whole), (*some_eval, *some), strict=True):
            a, b = (np.atleast_1d(x) + np.zeros(k, np.int32) for x, k in ((a, n), (b, len(index))))
            if not np.array_equal(a.take(index, axis=-1), b):
                raise AssertionError("a lane's result depends on its neighbours")


def _random_directions(rng: np.random.Generator, n: int) -> Array:
    w = rng.normal(size=(3, n)).astype(np.float32)
    return w / np.sqrt((w * w).sum(axis=0))
