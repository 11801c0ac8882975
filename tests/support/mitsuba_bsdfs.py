"""Mitsuba's BSDFs as a second opinion, evaluated direction by direction in its scalar variant."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[np.float64]


def mitsuba() -> Any:
    """The module in its scalar variant; skips the test where it is not installed."""
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("scalar_rgb")
    return mi


def evaluate(plugin: dict[str, Any], wi: Array, wo: Array) -> tuple[Array, Array]:
    """f·|cosθo| (3, n) and pdf (n,) of a plugin, for local directions (3, n)."""
    mi = mitsuba()
    bsdf, context, si = mi.load_dict(plugin), mi.BSDFContext(), mi.SurfaceInteraction3f()
    values, densities = [], []
    for a, b in zip(wi.T, wo.T, strict=True):
        si.wi = [float(x) for x in a]
        out = [float(x) for x in b]
        values.append([float(x) for x in bsdf.eval(context, si, out)])
        densities.append(float(bsdf.pdf(context, si, out)))
    return np.array(values).T, np.array(densities)


def smith_g1(distribution: str, w: Array, alpha: tuple[float, float]) -> Array:
    """Masking of one direction as Mitsuba has it: exact for GGX, Walter's rational fit for Beckmann."""
    tan = np.sqrt((alpha[0] * w[0]) ** 2 + (alpha[1] * w[1]) ** 2) / np.abs(w[2])
    if distribution == "ggx":
        return 2.0 / (1.0 + np.sqrt(1.0 + tan * tan))
    a = 1.0 / np.maximum(tan, 1e-30)
    fit = (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a)
    return np.where(a < 1.6, fit, 1.0)


def correlated_over_separable(distribution: str, wi: Array, wo: Array, alpha: tuple[float, float]) -> Array:
    """G2/(G1 G1): Mitsuba masks wi and wo independently, this engine (and Cycles) by height."""
    g1, g2 = smith_g1(distribution, wi, alpha), smith_g1(distribution, wo, alpha)
    return 1.0 / (g1 + g2 - g1 * g2)  # 1/G1 − 1 = Λ
