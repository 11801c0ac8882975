"""Thin films: against the sum over wavelengths that they stand for, and on every model that can bear one."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest
from support import bsdf_checks as checks
from support.bsdf_checks import direction, f32
from support.chi2 import significance

from pt_engine.bsdfs import conductor, dielectric, film_sensitivity, fresnel, specular, thin_film
from pt_engine.bsdfs.thin_film import Film

COSINES = np.linspace(0.05, 1, 20, dtype=np.float32)
OIL = {"film_thickness": f32(420.0), "film_ior": f32(1.4)}
GOLD = {"eta": f32(0.143, 0.375, 1.442), "k": f32(3.983, 2.386, 1.603)}
COPPER = {"color": f32(0.9, 0.6, 0.4), "edge_tint": f32(1.0, 0.8, 0.7)}
CASES = [
    (conductor, conductor.Params(f32(0.3), f32(0.1), **GOLD, **OIL), 0.5),
    (conductor, conductor.Params(f32(0.3), None, **COPPER, **OIL), 0.8),
    (specular, specular.Params(f32(0.4), None, f32(1.5), f32(1.0, 0.5, 2.0), **OIL), 0.3),
    (dielectric, dielectric.Params(f32(0.3), f32(1.5), **OIL), 0.6),
    (dielectric, dielectric.Params(f32(0.4), f32(1 / 1.5), None, f32(0.2, 0.5, 1.0), **OIL), 0.8),
]


# ------------------------------------------------------------------------- interference


def by_wavelength(cos: np.ndarray, n: complex, film: float, thickness: float) -> np.ndarray:
    """(3, N) Airy's amplitude (r12 + r23 e^{2iβ})/(1 + r12 r23 e^{2iβ}) squared, under each sensitivity.

    Fresnel's amplitudes by complex cosines, β = 2π d n₂ cosθ₂/λ, at the wave numbers of the table.
    """
    k = np.arange(film_sensitivity.FIRST, film_sensitivity.FIRST + len(film_sensitivity.X))
    wave = film_sensitivity.STEP * k / 1000.0
    xyz = np.array([film_sensitivity.X, film_sensitivity.Y, film_sensitivity.Z]) / wave**2
    weights = np.array(film_sensitivity.XYZ_TO_REC709) @ xyz
    weights /= weights.sum(axis=1, keepdims=True)
    c1 = cos.astype(np.complex128)[:, None]
    sine2 = 1 - c1**2
    c2, c3 = np.sqrt(1 - sine2 / film**2), np.sqrt(1 - sine2 / n**2)
    beta = 2 * np.pi * thickness * film * c2 * wave
    total = np.zeros((len(cos), len(wave)))
    for a, b, c in ((c1, film * c2, n * c3), (film * c1, c2, None)):
        r12 = (a - b) / (a + b)
        r23 = (b - c) / (b + c) if c is not None else (n * c2 - film * c3) / (n * c2 + film * c3)
        turn = np.exp(2j * beta)
        total += 0.5 * np.abs((r12 + r23 * turn) / (1 + r12 * r23 * turn)) ** 2
    return np.stack([total @ w for w in weights])


@pytest.mark.parametrize("thickness", [100.0, 350.0, 1500.0, 2000.0])
@pytest.mark.parametrize("ior", [1.2, 1.33, 2.0])
def test_film_on_glass_is_airys_sum_over_wavelengths(ior: float, thickness: float) -> None:
    """0.003 at 20° and more from grazing: the table is interpolated between nodes 19 nm apart (an error of
    (2π·19/500)²/8 = 0.7 % of each term), and terms beyond the third are left out."""
    ours = thin_film.over_dielectric(COSINES, f32(1.5), Film(f32(thickness), f32(ior)))
    theirs = by_wavelength(COSINES, 1.5, ior, thickness)
    np.testing.assert_allclose(ours[:, 7:], theirs[:, 7:], atol=3e-3)


@pytest.mark.parametrize("thickness", [100.0, 350.0, 1500.0])
@pytest.mark.parametrize("metal", [0.2 + 3.5j, 2.8 + 3.4j, 1.4 + 0.5j])
def test_film_on_metal_is_airys_sum_over_wavelengths(metal: complex, thickness: float) -> None:
    """0.01: as above, with amplitudes of metal near 1; the fourth term is up to 2·0.8·(0.14)⁴·… < 1e-3."""
    index = f32(metal.real, metal.real, metal.real), f32(metal.imag, metal.imag, metal.imag)
    ours = thin_film.over_conductor(COSINES, *index, Film(f32(thickness), f32(1.33)))
    theirs = by_wavelength(COSINES, metal, 1.33, thickness)
    np.testing.assert_allclose(ours[:, 7:], theirs[:, 7:], atol=0.01)


def test_film_of_no_thickness_is_not_there() -> None:
    """Towards 0 nm the film fades: to rounding of 1 − (1 − r12²)(1 − r23²)…"""
    film = Film(f32(1e-4), f32(1.8))
    bare = fresnel.dielectric(COSINES, f32(1.5))[0]
    np.testing.assert_allclose(thin_film.over_dielectric(COSINES, f32(1.5), film)[0], bare, rtol=1e-4)
    gold = fresnel.conductor(COSINES, GOLD["eta"], GOLD["k"])
    ours = thin_film.over_conductor(COSINES, GOLD["eta"], GOLD["k"], film)
    np.testing.assert_allclose(ours, gold, rtol=1e-4)


def test_metal_by_two_colours_keeps_them_without_a_film() -> None:
    """Gulbrandsen's index has the colour at normal incidence, and the F82 curve within is the one outside."""
    b = fresnel.f82_slope(COPPER["color"], COPPER["edge_tint"])
    bare = np.minimum(fresnel.f82(COSINES, COPPER["color"], b), 1)
    ours = thin_film.over_f82(COSINES, COPPER["color"], b, Film(f32(1e-4), f32(1.8)))
    np.testing.assert_allclose(ours, bare, rtol=2e-3)


def test_total_reflection_stays_total() -> None:
    """From glass, beyond the critical angle of what lies under the film, nothing passes, film or not."""
    cos = np.linspace(0, 0.7, 15, dtype=np.float32)
    film = Film(f32(500.0), f32(1.2 / 1.5))
    f = thin_film.over_dielectric(cos, f32(1 / 1.5), film)
    np.testing.assert_allclose(f, 1, atol=1e-5)


@pytest.mark.parametrize("eta", [0.5, 1.0, 1.5, 3.0])
def test_reflectance_stays_within_bounds(eta: float) -> None:
    film = Film(np.geomspace(0.1, 1e5, 400, dtype=np.float32), f32(1.7))
    for cos in (0.0, 1e-6, 0.3, 1.0):
        for f in (
            thin_film.over_dielectric(np.full(400, cos, np.float32), f32(eta), film),
            thin_film.over_conductor(np.full(400, cos, np.float32), GOLD["eta"], GOLD["k"], film),
        ):
            assert f.dtype == np.float32
            assert np.isfinite(f).all()
            assert (f >= 0).all()
            assert (f <= 1).all()


# ------------------------------------------------------------------------- on the models


@pytest.mark.parametrize(("model", "params", "cos"), CASES)
def test_samples_follow_the_density(model: ModuleType, params: tuple, cos: float) -> None:
    assert checks.chi2(model, params, direction(cos, 0.7)) > significance(len(CASES))


@pytest.mark.parametrize(("model", "params", "cos"), CASES)
def test_weight_is_value_over_pdf(model: ModuleType, params: tuple, cos: float) -> None:
    """2e-3: as without a film; its colours vary over degrees, not over rounding's 1e-6."""
    checks.check_weight_is_value_over_pdf(model, params, direction(cos, 0.7), rtol=2e-3)


@pytest.mark.parametrize(("model", "params", "cos"), CASES[:2])
def test_reciprocal(model: ModuleType, params: tuple, cos: float) -> None:
    """Both ways the half vector is the same, hence the film's colour."""
    wi, wo = direction(cos, 0.4), direction(0.7, 2.0)
    there, back = (model.eval_pdf(params, a, b)[0] / b[2] for a, b in ((wi, wo), (wo, wi)))
    np.testing.assert_allclose(there, back, rtol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("thickness", "ior"), [(0.0, 1.33), (0.5, 100.0), (300.0, 1e-5), (1e6, 1.0)])
def test_hostile_numbers_stay_finite(thickness: float, ior: float) -> None:
    film = {"film_thickness": f32(thickness), "film_ior": f32(ior)}
    for alpha in (0.0, 0.3):
        for eta in (1e-2, 1.5):
            checks.check_finite(
                dielectric,
                dielectric.Params(f32(alpha), f32(eta), **film),
                3.001,
                length_error=1e-5 * max(1.0, 1.0 / eta),
            )
        checks.check_finite(specular, specular.Params(f32(alpha), None, f32(1.5), None, **film))
        checks.check_finite(conductor, conductor.Params(f32(alpha), **GOLD, **film))
        white = {"color": f32(0.0, 0.5, 1.0), "edge_tint": f32(0.0, 1.0, 0.5)}
        checks.check_finite(conductor, conductor.Params(f32(alpha), **white, **film))


@pytest.mark.parametrize(("model", "params", "cos"), CASES)
def test_lanes_are_independent(model: ModuleType, params: tuple, cos: float) -> None:
    checks.check_lanes_are_independent(model, params)


def test_lanes_with_and_without_a_film_keep_apart() -> None:
    """Thickness by lane: those of at most 0.1 nm reflect as if there were no film."""
    thickness = np.array([0.0, 300.0, 0.1, 800.0], np.float32)
    mixed = specular.Params(f32(0.3), None, f32(1.5), None, thickness, f32(1.33))
    cos = np.full(4, 0.4, np.float32)
    f = specular.facets(mixed)(cos)
    bare = specular.facets(specular.Params(f32(0.3), None, f32(1.5)))(cos)
    np.testing.assert_array_equal(f[:, [0, 2]], np.broadcast_to(bare, (3, 4))[:, [0, 2]])
    coated = thin_film.over_dielectric(cos, f32(1.5), Film(thickness, f32(1.33)))
    np.testing.assert_array_equal(f[:, [1, 3]], coated[:, [1, 3]])
