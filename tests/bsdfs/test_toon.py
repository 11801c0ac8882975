"""Toon, about the normal and about the mirror direction."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import simpson
from support import bsdf_checks as checks
from support.bsdf_checks import direction, f32, repeat
from support.chi2 import chi2_sphere, integrate_sphere, significance

from pt_engine.bsdfs import toon, toon_glossy

MODELS = {"diffuse": toon, "glossy": toon_glossy}
# size, smooth, cosine, azimuth of the viewer
LOBES = [(0.5, 0.0, 0.7, 1.0), (0.2, 0.3, 0.9, 0.0), (0.9, 0.9, 0.3, 2.0), (0.1, 0.0, 0.1, 0.5)]


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(("size", "smooth", "cos", "phi"), LOBES)
def test_samples_follow_the_density(
    model: ModuleType, size: float, smooth: float, cos: float, phi: float
) -> None:
    """The cone is drawn evenly; what of it falls below the horizon counts as lost.

    The grid's pole is the cone's axis and the rim an edge of its cells, as the density jumps there.
    """
    params, wi = model.Params(f32(size), f32(smooth)), direction(cos, phi)
    axis = (0.0, 0.0, 1.0) if model is toon else tuple(float(x) for x in (wi * [[-1], [-1], [1]])[:, 0])

    def draw(u0: np.ndarray, u1: np.ndarray, u2: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        s = model.sample(params, repeat(wi, len(u0)), u0, u1, u2)
        return s.wo, s.wo[2] > 0

    def pdf(wo: np.ndarray) -> np.ndarray:
        return model.eval_pdf(params, repeat(wi, wo.shape[1]), wo)[1]

    cap = 2 * float(toon.cone_of(params).rim[0])
    p = chi2_sphere(draw, pdf, n=100_000, pole=axis, cap=cap)
    assert p > significance(2 * len(LOBES))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(("size", "smooth", "cos", "phi"), LOBES)
def test_weight_is_value_over_pdf(
    model: ModuleType, size: float, smooth: float, cos: float, phi: float
) -> None:
    """1e-4: near the edge, where the light falls to 0, an angle's rounding is much of what is left."""
    checks.check_weight_is_value_over_pdf(
        model, model.Params(f32(size), f32(smooth)), direction(cos, phi), 1e-4
    )


@pytest.mark.parametrize(("size", "smooth"), [(0.4, 0.0), (0.3, 0.5), (0.8, 0.7), (1.0, 0.0)])
def test_a_white_disk_reflects_what_its_edge_leaves(size: float, smooth: float) -> None:
    """∫ I sinθ dθ / (1 − cos θmax) over [0, θmax], by Simpson's rule; 1 for a hard edge."""
    most = min(size + smooth, 1.0) * np.pi / 2
    theta = np.linspace(0, most, 4001)
    edge = (
        np.ones_like(theta)
        if smooth == 0
        else np.clip(1 - (theta - size * np.pi / 2) / (smooth * np.pi / 2), 0, 1)
    )
    expected = simpson(edge * np.sin(theta), x=theta) / (1 - np.cos(most))
    params = toon.Params(f32(size), f32(smooth))
    assert checks.directional_albedo(toon, params, direction(0.4), choices=1)[0] == pytest.approx(
        expected, abs=1e-4
    )


def test_glossy_toon_is_lost_below_the_horizon() -> None:
    """A cone of a right angle about a mirror direction at grazing has half its light below."""
    params, wi = toon_glossy.Params(f32(1.0), f32(0.0)), direction(1e-4)
    total = integrate_sphere(
        lambda wo: toon_glossy.eval_pdf(params, repeat(wi, wo.shape[1]), wo)[0][0], resolution=(10, 10)
    )
    assert total == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(("size", "smooth"), [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (-1.0, 2.0), (0.3, 1e-30)])
def test_hostile_numbers_stay_finite_and_lanes_apart(model: ModuleType, size: float, smooth: float) -> None:
    params = model.Params(f32(size), f32(smooth))
    checks.check_finite(model, params)
    checks.check_lanes_are_independent(model, params)
