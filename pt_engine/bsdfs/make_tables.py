"""Makes `tables.npz`: what rough GGX interfaces reflect and transmit in all, by quadrature in float64.

    python -m pt_engine.bsdfs.make_tables

Each entry is an average over the visible normals m (of density D_visible, so over the unit square):

    reflection   mean of G2/G1, facets white                                            [roughness, cosθ]
    glass        mean of F G2/G1 (reflected) + (1 − F) G2/G1 (refracted)                 [roughness, η, cosθ]
    passed       mean of (1 − F) G2/G1 (refracted, below the horizon) alone              [roughness, η, cosθ]
    inner        mean of F G2/G1 (reflected), leaving the denser side                    [roughness, η, cosθ]
    gloss        mean of (F − F0)/(1 − F0), of reflections above the horizon             [roughness, η, cosθ]
    schlick      mean of (1 − wi·m)⁵, of reflections above the horizon                   [roughness, cosθ]

The grids are Cycles', so that linear interpolation errs alike: roughness √α and cosθ uniform in [0, 1], η by
z = √|(η − 1)/(η + 1)| uniform in [0, 1], entering the denser side; `glass` has η leaving it behind them. In
`glass` light counts that a facet refracts upward, as it must meet another one, though the sampler drops it:
when leaving at grazing angles that is most of it, and to make up for it by brighter survivors would be noise
(Cycles' tables are so too). `…_average` are 2∫ … cosθ d(cosθ). In u1, the azimuth, the integrand is periodic
and the midpoint rule converges fast; in u2 Gauss-Legendre.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import fresnel
from .interface import NO_INTERFACE
from .microfacet import GGX, masking_ratio

Array = NDArray[Any]  # float64 throughout
AZIMUTHS, POLARS, COSINES = 48, 96, 40
PATH = Path(__file__).with_name("tables.npz")


def square() -> tuple[Array, Array, Array]:
    """u1, u2 and weights that sum to 1. By mirror symmetry u1 in [0, 1/2] will do."""
    x, w = np.polynomial.legendre.leggauss(POLARS)
    u1, u2 = np.meshgrid((np.arange(AZIMUTHS) + 0.5) / (2 * AZIMUTHS), (x + 1) / 2)
    weights = np.broadcast_to(w[:, np.newaxis] / (2 * AZIMUTHS), u1.shape)
    return u1.ravel(), u2.ravel(), weights.ravel()


class View:
    """Facets seen at one roughness and cosine: what each reflects and where refraction leads."""

    def __init__(self, rough: float, cos: float) -> None:
        u1, u2, self.weights = square()
        self.alpha = np.array([max(rough, 1e-4) ** 2])
        cos = max(cos, 1e-4)
        self.wi = np.repeat(np.array([[np.sqrt(1 - cos * cos)], [0.0], [cos]]), len(u1), axis=1)
        self.m = GGX.visible_normal(self.wi, self.alpha, self.alpha, u1, u2)
        self.cos = np.clip((self.wi * self.m).sum(axis=0), 0.0, 1.0)
        mirrored = 2 * self.cos * self.m - self.wi
        self.above = mirrored[2] > 0
        self.reflected = self.ratio(mirrored) * self.above

    def ratio(self, wo: Array) -> Array:
        """G2/G1."""
        a2 = self.alpha**2
        ti, to = GGX.stretched(self.wi, a2, a2), GGX.stretched(wo, a2, a2)
        ratio: Array = masking_ratio(self.wi[2], ti, np.abs(wo[2]), to)
        return ratio

    def fresnel(self, eta: float) -> tuple[Array, Array, NDArray[np.bool_]]:
        """F, and G2/G1 of the refracted direction, and whether that is below the horizon."""
        f, g = fresnel.dielectric(self.cos, np.array([eta]))
        refracted = ((self.cos - g) * self.m - self.wi) / eta
        ratio = self.ratio(refracted)
        if abs(eta - 1) < NO_INTERFACE:
            ratio = np.ones_like(ratio)
        return f, ratio, refracted[2] < 0

    def mean(self, values: Array) -> float:
        return float(np.sum(values * self.weights))


def etas(count: int) -> Array:
    """η of the grid's z."""
    z = np.clip(np.arange(count) / (count - 1), 1e-4, 0.99)
    root = np.minimum(z * z, np.sqrt(0.99))
    eta: Array = (1 + root) / (1 - root)
    return eta


def entries(view: View) -> dict[str, Array]:
    """Rows of the tables that depend on η."""
    rows: dict[str, list[float]] = {"glass": [], "passed": [], "inner": [], "gloss": []}
    for eta in etas(16):
        f, ratio, below = view.fresnel(float(eta))
        rows["glass"].append(view.mean(f * view.reflected + (1 - f) * ratio))
        rows["passed"].append(view.mean((1 - f) * ratio * below))
        f0 = ((eta - 1) / (eta + 1)) ** 2
        rows["gloss"].append(view.mean(np.clip((f - f0) / (1 - f0), 0, 1) * view.above))
    for eta in 1 / etas(16):
        f, ratio, _ = view.fresnel(float(eta))
        rows["glass"].append(view.mean(f * view.reflected + (1 - f) * ratio))
        rows["inner"].append(view.mean(f * view.reflected))
    return {name: np.array(row) for name, row in rows.items()}


def main() -> None:
    """Compute and save the tables."""
    fine, coarse = np.linspace(0, 1, 32), np.linspace(0, 1, 16)
    x, w = np.polynomial.legendre.leggauss(COSINES)
    x, w = (x + 1) / 2, w / 2
    tables = {"reflection": np.array([[_white(r, c) for c in fine] for r in fine])}
    tables["reflection_average"] = np.array([sum(2 * w * x * [_white(r, c) for c in x]) for r in fine])
    on_grid = [[entries(View(r, c)) for c in coarse] for r in coarse]
    on_nodes = [[entries(View(r, c)) for c in x] for r in coarse]
    for name in ("glass", "passed", "gloss"):
        tables[name] = np.array([[row[name] for row in rows] for rows in on_grid]).transpose(0, 2, 1)
    for name in ("glass", "inner"):
        nodes = np.array([[row[name] for row in rows] for rows in on_nodes])
        tables[f"{name}_average"] = (nodes * (2 * w * x)[:, np.newaxis]).sum(axis=1)
    views = [[View(r, c) for c in coarse] for r in coarse]
    tables["schlick"] = np.array([[v.mean((1 - v.cos) ** 5 * v.above) for v in row] for row in views])
    single: dict[str, Any] = {name: table.astype(np.float32) for name, table in tables.items()}
    np.savez_compressed(PATH, **single)


def _white(rough: float, cos: float) -> float:
    view = View(rough, cos)
    return view.mean(view.reflected)


if __name__ == "__main__":
    main()
