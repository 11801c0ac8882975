"""Multiple scattering between facets, made up for by tables; and the tables themselves."""

from __future__ import annotations

import numpy as np
import pytest
from support import bsdf_checks as checks
from support.bsdf_checks import direction, f32

from pt_engine.bsdfs import conductor, dielectric, energy, make_tables, specular

WHITE = f32(1.0, 1.0, 1.0)


@pytest.mark.parametrize("rough", [0.05, 0.3, 0.55, 0.8, 1.0])
@pytest.mark.parametrize("cos", [0.1, 0.4, 0.75, 1.0])
def test_white_metal_in_a_white_furnace_vanishes(rough: float, cos: float) -> None:
    """Gain · E = 1 up to linear interpolation between 32 × 32 nodes: 1 %, mostly at grazing."""
    alpha, wi = f32(rough * rough), direction(cos)
    single = checks.directional_albedo(conductor, conductor.Params(alpha, None), wi, choices=1)
    gain = energy.reflection_gain(alpha, None, f32(cos), np.ones((1, 1), np.float32))
    assert single * gain[:, 0] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("rough", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("eta", [1.1, 1.5, 2.0])
@pytest.mark.parametrize("cos", [0.2, 0.6, 1.0])
def test_white_glass_in_a_white_furnace_vanishes(rough: float, eta: float, cos: float) -> None:
    """1.5 %: linear interpolation between 16³ nodes (as Cycles)."""
    alpha, wi = f32(rough * rough), direction(cos)
    single = checks.directional_albedo(dielectric, dielectric.Params(alpha, f32(eta)), wi, rows=96)
    gain = energy.glass_gain(alpha, f32(eta), f32(cos), np.ones((1, 1), np.float32))
    assert single * gain[:, 0] == pytest.approx(1.0, abs=0.015)


def test_colored_metal_gains_less_than_white_and_never_loses() -> None:
    gain = energy.reflection_gain(f32(0.6), None, f32(0.5), f32(0.1, 0.5, 1.0))
    assert 1 < gain[0, 0] < gain[1, 0] < gain[2, 0]


@pytest.mark.parametrize("rough", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("cos", [0.2, 0.7])
def test_gloss_albedo_is_close_to_the_lobes(rough: float, cos: float) -> None:
    """F0 + (1 − F0) s estimates what the gloss, with its gain, reflects: within 0.04, as rough as it is."""
    alpha, eta = f32(rough * rough), f32(1.5)
    lobe = checks.directional_albedo(specular, specular.Params(alpha, None, eta), direction(cos), choices=1)
    albedo = 0.04 + 0.96 * energy.gloss(alpha, None, eta, f32(cos))[0]
    assert albedo == pytest.approx(float(lobe[0]), abs=0.04)


def test_a_lane_looks_up_the_same_bits_alone_and_in_company() -> None:
    rng = np.random.default_rng(1)
    rough, eta, cos = rng.random((3, 50), np.float32) * np.array([[1], [2], [1]], np.float32) + 0.01
    average = np.full((1, 1), 0.7, np.float32)
    for k in (0, 7, 49):
        one = slice(k, k + 1)
        pairs = [
            (
                energy.reflection_gain(rough, None, cos, average)[0],
                energy.reflection_gain(rough[one], None, cos[one], average)[0],
            ),
            (
                energy.glass_gain(rough, eta, cos, average)[0],
                energy.glass_gain(rough[one], eta[one], cos[one], average)[0],
            ),
            (energy.gloss(rough, None, eta, cos), energy.gloss(rough[one], None, eta[one], cos[one])),
        ]
        for many, alone in pairs:
            assert many.dtype == np.float32
            assert many[k] == alone[0]


@pytest.mark.parametrize(("i", "j", "k"), [(3, 5, 9), (12, 2, 4), (8, 15, 12)])
def test_tables_are_what_their_script_makes(i: int, j: int, k: int) -> None:
    """Spot checks, to float32's rounding."""
    tables = energy._tables()
    rows = make_tables.entries(make_tables.View(i / 15, j / 15))
    for name in ("glass", "passed", "gloss"):
        assert tables[name][i, k, j] == pytest.approx(rows[name][k], rel=1e-5)
    view = make_tables.View(i / 31, j / 31)
    assert tables["reflection"][i, j] == pytest.approx(view.mean(view.reflected), rel=1e-5)
