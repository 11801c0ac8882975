"""The Principled's layers: which exist, what they add up to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import bsdf_checks as checks
from support.bsdf_checks import direction, f32

from pt_engine.bsdfs import (
    conductor,
    dielectric,
    diffuse,
    oren_nayar,
    principled,
    specular,
)

FRONT = f32(0.0)


def reflectance(layers: principled.Layers, cos: float) -> np.ndarray:
    """What all layers reflect and transmit toward the viewer at `cos`."""
    wi, total = direction(cos, 0.3), np.zeros(3)
    for layer in layers.closures:
        # Oren-Nayar peaks at grazing: there its own albedo of 1 per unit weight bounds it
        if layer.bsdf is oren_nayar:
            albedo = np.ones(1)
        else:
            albedo = checks.directional_albedo(layer.bsdf, layer.params, wi, rows=48, choices=8)
        total += layer.weight.mean(axis=-1) * albedo
    return total


def made(cos: float, **sockets: object) -> principled.Layers:
    given = principled.inputs(**sockets)
    return principled.layers(given, f32(cos), f32(cos), FRONT)


@settings(max_examples=40, deadline=None)
@given(
    st.floats(0, 1), st.floats(0, 1), st.floats(1, 2.5), st.floats(0, 1), st.floats(0, 1),
    st.floats(0, 1), st.floats(0, 1), st.floats(0.1, 1), st.floats(0, 1),
)  # fmt: skip
def test_energy_is_conserved(
    metallic: float,
    roughness: float,
    ior: float,
    level: float,
    transmission: float,
    coat: float,
    coat_roughness: float,
    cos: float,
    subsurface: float,
) -> None:
    """A white surface of any make reflects at most all. 3 %: the tables' interpolation, and layers take
    albedos at the viewer's side alone, as Cycles does."""
    layers = made(
        cos, base_color=(1.0, 1.0, 1.0), metallic=metallic, roughness=roughness, ior=ior,
        specular_ior_level=level, transmission_weight=transmission, coat_weight=coat,
        coat_roughness=coat_roughness, subsurface_weight=subsurface,
    )  # fmt: skip
    assert reflectance(layers, cos).max() <= 1.03


@pytest.mark.parametrize("roughness", [0.0, 0.3, 0.7, 1.0])
@pytest.mark.parametrize("cos", [0.2, 0.6, 1.0])
@pytest.mark.parametrize(
    "sockets", [{}, {"metallic": 1.0}, {"transmission_weight": 1.0}, {"coat_weight": 1.0}]
)
def test_white_surface_keeps_its_light(roughness: float, cos: float, sockets: dict[str, float]) -> None:
    """White plastic, metal, glass and coated plastic lose nothing: within 3 % (see above)."""
    layers = made(cos, base_color=(1.0, 1.0, 1.0), roughness=roughness, **sockets)
    np.testing.assert_allclose(reflectance(layers, cos), 1.0, atol=0.03)


def models(**sockets: object) -> list[object]:
    return [layer.bsdf for layer in made(0.5, **sockets).closures]


def test_closures_exist_only_if_no_constant_rules_them_out() -> None:
    assert models() == [specular, diffuse]
    assert models(metallic=1.0) == [conductor]
    assert models(transmission_weight=1.0) == [dielectric]
    assert models(ior=1.0) == [diffuse]
    assert models(specular_ior_level=0.0) == [diffuse]
    assert models(base_color=(0.0, 0.0, 0.0)) == [specular]
    assert models(coat_weight=0.5, metallic=0.5) == [specular, conductor, specular, diffuse]
    assert models(diffuse_roughness=0.5) == [specular, oren_nayar]
    assert models(diffuse_roughness=0.5, subsurface_weight=0.5) == [specular, diffuse, oren_nayar]
    assert models(metallic=np.array([1.0, 1.0, 1.0], np.float32)) == [conductor, specular, diffuse]


def test_lanes_agree_with_constants() -> None:
    """Per-lane inputs of equal values give the same weights; which lobes exist was decided beforehand."""
    sockets = {"metallic": 0.3, "roughness": 0.4, "transmission_weight": 0.2, "coat_weight": 0.6}
    constant = principled.inputs(base_color=(0.9, 0.5, 0.1), coat_tint=(0.8, 0.9, 1.0), **sockets)
    n = 5
    lanes = principled.Inputs(*(value + np.zeros(n, np.float32) for value in constant))
    cos = np.linspace(0.1, 1, n).astype(np.float32)
    inside = np.array([0, 1, 0, 1, 0], np.float32)
    which = principled.lobes(constant)
    a = principled.layers(constant, cos, cos, inside, which)
    b = principled.layers(lanes, cos, cos, inside, which)
    for one, other in zip(a.closures, b.closures, strict=True):
        assert one.weight.dtype == other.weight.dtype == np.float32
        np.testing.assert_array_equal(
            np.broadcast_to(one.weight, (3, n)), np.broadcast_to(other.weight, (3, n))
        )
    np.testing.assert_array_equal(a.emission, b.emission)


def test_coat_dims_emission_and_colours_it() -> None:
    """At normal incidence a coat of index 1.5 takes 4 % and its tint what it says."""
    layers = made(1.0, coat_weight=1.0, coat_roughness=0.0, coat_tint=(1.0, 0.5, 0.25))
    np.testing.assert_allclose(layers.emission[:, 0], np.array([1.0, 0.5, 0.25]) * 0.96, atol=2e-3)


def test_glass_is_entered_and_left() -> None:
    """From behind the index is inverted; the colour is halved between the two faces."""
    given = principled.inputs(transmission_weight=1.0, ior=1.5, base_color=(0.25, 1.0, 1.0))
    (layer,) = principled.layers(given, f32(0.5, 0.5)[:, 0], f32(0.5), np.array([0, 1], np.float32)).closures
    np.testing.assert_allclose(layer.params.eta, [1.5, 1 / 1.5], rtol=1e-6)
    assert layer.params.transmission_tint[0, 0] == pytest.approx(0.5)
