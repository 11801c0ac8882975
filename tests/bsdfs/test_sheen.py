"""Sheen (fibres, Zeltner et al.) and velvet (Ashikhmin)."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from support import bsdf_checks as checks
from support.bsdf_checks import direction, f32, repeat
from support.chi2 import chi2_sphere, integrate_sphere, significance

from pt_engine.bsdfs import sheen, velvet

MODELS = {"sheen": sheen, "velvet": velvet}
ROUGHNESS = [0.0, 0.05, 0.2, 0.55, 1.0]
LOBES = [
    (0.06, 0.02, 0.0),
    (0.2, 0.1, 1.0),
    (0.3, 0.6, 2.0),
    (0.7, 0.9, 0.5),
    (1.0, 0.3, 4.0),
    (1.0, 1.0, 0.0),
]


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(("roughness", "cos", "phi"), LOBES)
def test_samples_follow_the_density(model: ModuleType, roughness: float, cos: float, phi: float) -> None:
    """All samples count: velvet's weight may vanish where its density does not."""
    params, wi = model.Params(f32(roughness)), direction(cos, phi)

    def draw(u0: np.ndarray, u1: np.ndarray, u2: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        s = model.sample(params, repeat(wi, len(u0)), u0, u1, u2)
        return s.wo, s.pdf > 0

    p = chi2_sphere(draw, lambda wo: model.eval_pdf(params, repeat(wi, wo.shape[1]), wo)[1], n=100_000)
    assert p > significance(2 * len(LOBES))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(("roughness", "cos", "phi"), LOBES)
def test_weight_is_value_over_pdf(model: ModuleType, roughness: float, cos: float, phi: float) -> None:
    """1e-3: near the rim of a narrow lobe l² is a difference of products of float32 directions."""
    checks.check_weight_is_value_over_pdf(model, model.Params(f32(roughness)), direction(cos, phi), 1e-3)


@pytest.mark.parametrize("roughness", ROUGHNESS)
@pytest.mark.parametrize("cos", [0.01, 0.1, 0.5, 1.0])
def test_sheen_reflects_its_albedo_and_no_more_than_all(roughness: float, cos: float) -> None:
    """∫ f·cosθo = R, as the cosine lobe is only bent; integrated to 1e-5."""
    params, wi = sheen.Params(f32(roughness)), direction(cos, 0.4)
    albedo = float(sheen.albedo(params, wi[2])[0])
    assert 0 <= albedo < 1
    assert float(sheen.sample(params, wi, *f32(0.5, 0.3, 0.2)).weight[0, 0]) == albedo
    total = integrate_sphere(lambda wo: sheen.eval_pdf(params, repeat(wi, wo.shape[1]), wo)[0][0], (10, 10))
    assert total == pytest.approx(albedo, abs=2e-5)


@pytest.mark.parametrize("sigma", ROUGHNESS)
@pytest.mark.parametrize("cos", [1e-4, 0.03, 0.3, 1.0])
def test_velvet_reflects_no_more_than_all(sigma: float, cos: float) -> None:
    params, wi = velvet.Params(f32(sigma)), direction(cos)
    total = integrate_sphere(lambda wo: velvet.eval_pdf(params, repeat(wi, wo.shape[1]), wo)[0][0], (10, 10))
    assert total <= 1 + 1e-5


@pytest.mark.parametrize("sigma", [0.3, 1.0])
def test_velvet_is_reciprocal(sigma: float) -> None:
    """f(wi, wo) = f(wo, wi)."""
    params, wi, wo = velvet.Params(f32(sigma)), direction(0.3, 1.0), direction(0.6, 3.0)
    there, back = (velvet.eval_pdf(params, a, b)[0] / b[2] for a, b in ((wi, wo), (wo, wi)))
    np.testing.assert_allclose(there, back, rtol=1e-5)


@pytest.mark.parametrize("roughness", ROUGHNESS)
def test_hostile_numbers_stay_finite_and_lanes_apart(roughness: float) -> None:
    """Velvet's weight is 2π D G/(4 cosθi) ≤ π D cosθh/cosθd < 2/σ² · 2 cot θh where its density is not 0."""
    checks.check_finite(sheen, sheen.Params(f32(roughness)), length_error=1e-5)
    checks.check_finite(velvet, velvet.Params(f32(roughness)), weight_bound=1e6)
    for model in MODELS.values():
        checks.check_lanes_are_independent(model, model.Params(f32(roughness)))


def test_rough_and_smooth_lanes_keep_apart() -> None:
    """Lanes without a lobe (a smooth sheen seen from above) neither reflect nor spoil their neighbours."""
    params, wi = sheen.Params(np.array([0.0, 0.6], np.float32)), repeat(direction(0.9), 2)
    s = sheen.sample(params, wi, *np.full((3, 2), 0.3, np.float32))
    assert s.weight[0, 0] == s.pdf[0] == 0
    assert s.weight[0, 1] == sheen.albedo(sheen.Params(f32(0.6)), f32(0.9))[0]
