"""Lambert, its transmitting twin, Oren-Nayar, and what lets light straight through."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import bsdf_checks as checks
from support.bsdf_checks import direction, f32, repeat, uniforms
from support.chi2 import chi2_sphere, integrate_sphere, significance

from pt_engine.bsdfs import diffuse, oren_nayar, translucent, transparent
from pt_engine.bsdfs.base import Lobe

ROUGH = oren_nayar.Params(f32(0.8), f32(0.9, 0.5, 0.1))
MODELS = [(diffuse, diffuse.Params()), (translucent, translucent.Params()), (oren_nayar, ROUGH)]


@pytest.mark.parametrize(("model", "params"), MODELS)
def test_samples_follow_the_density(model: ModuleType, params: tuple) -> None:
    p = checks.chi2(model, params, direction(0.4))
    assert p > significance(len(MODELS))


@pytest.mark.parametrize(("model", "params"), MODELS)
def test_weight_is_value_over_pdf(model: ModuleType, params: tuple) -> None:
    checks.check_weight_is_value_over_pdf(model, params, direction(0.3), rtol=1e-5)


@pytest.mark.parametrize(("model", "params"), [*MODELS, (transparent, transparent.Params())])
def test_hostile_numbers_stay_finite_and_lanes_apart(model: ModuleType, params: tuple) -> None:
    # Fujii's t = s/max(cosθi, cosθo) grows up to 2¹² where both graze (the sampler's least cosine)
    checks.check_finite(model, params, weight_bound=2.0**12)
    checks.check_lanes_are_independent(model, params)


@pytest.mark.parametrize("model", [diffuse, translucent])
def test_lambert_reflects_all(model: ModuleType) -> None:
    assert checks.directional_albedo(model, model.Params(), direction(0.2), choices=1) == 1.0


@pytest.mark.parametrize("roughness", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("cos", [0.02, 0.3, 0.7, 1.0])
def test_white_oren_nayar_preserves_energy(roughness: float, cos: float) -> None:
    """∫ f cosθo = E(θi) + (1 − E(θi)) = 1, up to rounding in float32 of (1 − E)/(1 − Ē): 1e-4."""
    params = oren_nayar.Params(f32(roughness), f32(1.0, 1.0, 1.0))
    wi = direction(cos)
    albedo = integrate_sphere(
        lambda wo: oren_nayar.eval_pdf(params, repeat(wi, wo.shape[1]), wo)[0][0], resolution=(10, 10)
    )
    assert albedo == pytest.approx(1.0, abs=1e-4)


def test_dark_oren_nayar_loses_energy_and_roughness_0_is_lambert() -> None:
    wi, wo = repeat(direction(0.5), 3), np.concatenate([direction(c, 2.0) for c in (0.1, 0.5, 0.9)], axis=1)
    params = oren_nayar.Params(f32(0.0), f32(0.5, 0.5, 0.5))
    np.testing.assert_allclose(
        oren_nayar.eval_pdf(params, wi, wo)[0][0], diffuse.eval_pdf(diffuse.Params(), wi, wo)[1], rtol=1e-6
    )
    dark = oren_nayar.Params(f32(1.0), f32(0.1, 0.5, 1.0))
    albedo = checks.directional_albedo(oren_nayar, dark, direction(0.5), choices=1)
    assert albedo[0] < albedo[1] < albedo[2]


@settings(max_examples=50, deadline=None)
@given(st.floats(0, 1), st.floats(0.001, 1), st.floats(0.001, 1), st.floats(0, 7))
def test_oren_nayar_is_reciprocal(roughness: float, cos_i: float, cos_o: float, phi: float) -> None:
    """f(wi, wo) = f(wo, wi), the value being f·cosθo. t divides a rounded difference by a cosine ≥ 0.001."""
    params = oren_nayar.Params(f32(roughness), f32(0.9, 0.5, 0.1))
    wi, wo = direction(cos_i), direction(cos_o, phi)
    there, back = (oren_nayar.eval_pdf(params, a, b)[0] / b[2] for a, b in ((wi, wo), (wo, wi)))
    np.testing.assert_allclose(there, back, rtol=2e-5, atol=1e-4 * float(there.max()))


def test_transparent_goes_straight_on_for_certain() -> None:
    wi = repeat(direction(0.3, 1.0), 4)
    s = transparent.sample(transparent.Params(), wi, *uniforms(4))
    assert np.array_equal(s.wo, -wi)
    assert (s.pdf == 1).all()
    assert (s.weight == 1).all()
    assert s.lobe == Lobe.DELTA | Lobe.TRANSMIT | Lobe.TRANSPARENT
    value, pdf = transparent.eval_pdf(transparent.Params(), wi, -wi)
    assert not value.any()
    assert not pdf.any()


def test_frameless_samples_are_cosine_distributed_about_the_normal() -> None:
    """`sample_about` against `eval_pdf_about`, in the space of the normal."""
    normal = direction(0.3, 1.0)

    def draw(u0: np.ndarray, u1: np.ndarray, u2: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        s, cos = diffuse.sample_about(diffuse.Params(), repeat(normal, len(u1)), u1, u2)
        np.testing.assert_array_equal(s.pdf, diffuse.eval_pdf_about(diffuse.Params(), cos)[1])
        assert (s.weight == 1).all()
        return s.wo, s.pdf > 0

    def pdf(wo: np.ndarray) -> np.ndarray:
        return diffuse.eval_pdf_about(diffuse.Params(), (normal * wo).sum(axis=0))[1]

    assert chi2_sphere(draw, pdf, n=100_000, pole=tuple(normal[:, 0])) > significance(1)
