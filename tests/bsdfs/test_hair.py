"""Blender's Hair BSDF: one reflected or one transmitted lobe."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from support import bsdf_checks as checks
from support.bsdf_checks import direction, f32, repeat, uniforms
from support.chi2 import significance

from pt_engine.bsdfs import hair_reflection, hair_transmission
from pt_engine.bsdfs.hair_lobe import Params

MODELS = {"reflection": hair_reflection, "transmission": hair_transmission}
# βu, βv, offset, lean, cosine, azimuth
CASES = [
    (0.1, 1.0, 0.0, None, 0.9, 0.3),
    (0.4, 0.3, 0.2, None, 0.6, 1.2),
    (1.0, 0.6, -0.3, 0.4, 0.3, 2.5),
]


def params(beta_u: float, beta_v: float, offset: float, lean: float | None) -> Params:
    return Params(f32(beta_u), f32(beta_v), f32(offset), None if lean is None else f32(lean))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize("case", CASES)
def test_samples_follow_the_density(model: ModuleType, case: tuple) -> None:
    p = checks.chi2(model, params(*case[:4]), direction(*case[4:]))
    assert p > significance(2 * len(CASES))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize("case", CASES)
def test_weight_is_value_over_pdf(model: ModuleType, case: tuple) -> None:
    """1e-4: the sampler itself evaluates."""
    checks.check_weight_is_value_over_pdf(model, params(*case[:4]), direction(*case[4:]), rtol=1e-4)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize(("beta", "offset"), [(0.0, -3.0), (0.0, 0.0), (0.2, 1.5), (1.0, 0.0)])
def test_hostile_numbers_stay_finite(model: ModuleType, beta: float, offset: float) -> None:
    for lean in (None, -1.0, 0.5):
        checks.check_finite(model, params(beta, beta, offset, lean))


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_lanes_are_independent(model: ModuleType) -> None:
    checks.check_lanes_are_independent(model, params(*CASES[2][:4]))


@pytest.mark.parametrize("beta_v", [0.2, 0.5, 0.8, 1.0])
def test_reflection_keeps_what_stays_before_the_hair(beta_v: float) -> None:
    """Seen from above across the hair: sin(π/4β) of the azimuth lies within ±π/2, all of it for β ≤ 1/2.

    Within 1e-3: midpoints of 96² cells; the lobe along the hair is narrow enough to lose nothing.
    """
    p = params(0.05, beta_v, 0.0, None)
    albedo = checks.directional_albedo(hair_reflection, p, direction(1.0), rows=96, choices=1)
    kept = np.sin(min(np.pi / 4 / beta_v, np.pi / 2))
    assert albedo[0] == pytest.approx(kept, abs=1e-3)


def test_transmission_loses_nothing_from_above() -> None:
    p = params(0.3, 0.4, 0.0, None)
    albedo = checks.directional_albedo(hair_transmission, p, direction(1.0), rows=96, choices=1)
    assert albedo[0] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("offset", [-0.2, 0.0, 0.3])
def test_reflection_peaks_at_the_tilted_mirror_angle(offset: float) -> None:
    """θo = 2·offset − θi along the hair, φ = 0: the smallest lobe finds it to its width."""
    p = Params(f32(1e-3), f32(1e-3), f32(offset))
    wi = direction(0.8)
    theta = np.arcsin(wi[0, 0])
    s = hair_reflection.sample(p, repeat(wi, 200), *uniforms(200))
    found = np.median(np.arcsin(s.wo[0]))
    assert found == pytest.approx(2 * offset - theta, abs=2e-3)


def test_each_stays_on_its_side() -> None:
    wi = repeat(direction(0.3, 1.4), 2000)
    for model, side in ((hair_reflection, 1), (hair_transmission, -1)):
        s = model.sample(params(0.5, 1.0, 0.0, 0.3), wi, *uniforms(2000))
        assert (side * s.wo[2][s.weight[0] > 0] > 0).all()
