"""Irradiance on a plane that faces +Z, against the textbook."""

import numpy as np
import pytest
from support.lamps import irradiance, lamp, lights, placed, triangles, white


def assert_irradiance(scene, expected, position=(0.0, 0.0, 0.0), rounding=2e-5):
    value, error = irradiance(scene, position=position)
    assert abs(value - expected) <= 4.5 * error + rounding * expected


@pytest.mark.parametrize("x", [0.0, 1.0, 5.0])
def test_point(x):
    """E = Φ cosθ / (4π d²)."""
    d2 = 4.0 + x * x
    assert_irradiance(lights(lamp("POINT")), 100.0 / (4 * np.pi * d2) * 2.0 / np.sqrt(d2), (x, 0, 0))


@pytest.mark.parametrize("radius", [1e-4, 0.1, 1.0, 1.9])
@pytest.mark.parametrize("x", [0.0, 1.0])
def test_sphere_above_the_horizon_lights_like_a_point(radius, x):
    """E = π L r² cosθ / d² with L = Φ / (4π² r²), whatever the radius, while it is all above the plane."""
    d2 = 4.0 + x * x
    scene = lights(lamp("POINT", radius=radius))
    assert_irradiance(scene, 100.0 / (4 * np.pi * d2) * 2.0 / np.sqrt(d2), (x, 0, 0))


def test_inside_a_sphere():
    """E = π L."""
    assert_irradiance(lights(lamp("POINT", radius=3.0)), 100.0 / (4 * np.pi * 9.0))


def test_point_strength_without_normalisation():
    """I = Φ / π without size, L = Φ / π with."""
    assert_irradiance(lights(lamp("POINT", normalize=False)), 100.0 / np.pi / 4.0)
    assert_irradiance(lights(lamp("POINT", radius=0.5, normalize=False)), 100.0 * 0.25 / 4.0)


@pytest.mark.parametrize("z", [0.2, 0.6, 0.75, 0.8, 0.95])
def test_spot_profile(z):
    """E = I s²(3 − 2s) cosθ / d², s = clamp((cosθ − cos ½size) / ((1 − cos ½size) blend)); half at s = ½."""
    size, blend = 1.6, 0.5
    edge = np.cos(0.5 * size)
    s = np.clip((z - edge) / ((1 - edge) * blend), 0.0, 1.0)
    x = 2.0 * np.sqrt(1.0 - z * z) / z
    expected = 100.0 / (4 * np.pi) * s * s * (3 - 2 * s) * z / (4.0 + x * x)
    assert_irradiance(lights(lamp("SPOT", spot_size=size, spot_blend=blend)), expected, (x, 0, 0), 1e-4)


def test_stretched_spot_has_an_elliptic_beam():
    """Scaled by 2 along x, the beam reaches tan ½size · 2 there and tan ½size along y."""
    scene = lights(lamp("SPOT", placed(scale=(2, 1, 1)), spot_size=0.8, spot_blend=0.0))
    reach = 2.0 * np.tan(0.4)
    for fraction in (0.95, 1.05):
        for position in ((2 * fraction * reach, 0.0, 0.0), (0.0, fraction * reach, 0.0)):
            assert (irradiance(scene, 10, position)[0] > 0.0) == (fraction < 1.0)


@pytest.mark.parametrize("angle", [0.0, 0.0093, 0.5, 1.5])
def test_sun(angle):
    """E cosθ, with or without size, while the disc is above the horizon: ∫ L cos dω = L π sin²α cosθ."""
    assert_irradiance(lights(lamp("SUN", placed(tilt=0.6), power=3.0, angle=angle)), 3.0 * np.cos(0.6))


def corner_view_factor(a, b):
    """Of a parallel rectangle a × b at height 1 from under its corner (Howell B-3)."""
    p, q = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
    return (a / p * np.arctan(b / p) + b / q * np.arctan(a / q)) / (2 * np.pi)


@pytest.mark.parametrize(
    ("x", "y", "height"), [(2.0, 1.0, 2.0), (0.1, 0.1, 2.0), (8.0, 1.0, 0.3), (100.0, 100.0, 1.0)]
)
def test_parallel_rectangle(x, y, height):
    """E = π L F, L = Φ / (π x y), F four corners' view factors."""
    scene = lights(lamp("AREA", placed(z=height), shape="RECTANGLE", size=(x, y)))
    factor = 4 * corner_view_factor(0.5 * x / height, 0.5 * y / height)
    assert_irradiance(scene, 100.0 / (x * y) * factor)


@pytest.mark.parametrize(("radius", "height"), [(0.5, 2.0), (2.0, 1.0), (0.01, 2.0)])
def test_parallel_disk(radius, height):
    """E = π L r² / (r² + h²)."""
    scene = lights(lamp("AREA", placed(z=height), shape="DISK", size=(2 * radius,) * 2))
    assert_irradiance(scene, 100.0 / (np.pi * radius**2) * radius**2 / (radius**2 + height**2))


def test_ellipse_far_away():
    """E → L A / d² with L A = Φ / π; A / d² = 2e-5 is the error."""
    scene = lights(lamp("AREA", placed(z=100.0), shape="ELLIPSE", size=(0.5, 0.2)))
    assert_irradiance(scene, 100.0 / np.pi / 1e4, rounding=1e-4)


@pytest.mark.parametrize("spread", [0.05, 0.5, 1.5, 3.0])
@pytest.mark.parametrize("shape", ["SQUARE", "DISK"])
def test_spread_keeps_the_power(spread, shape):
    """E below the middle of a lamp that is wider than its spread is that of an infinite one: Φ / A.

    2π ∫₀^α L (tan α − tan θ) / (tan α − α) cosθ sinθ dθ = π L. Below a half spread of 0.05 Cycles takes
    3 (tan α − tan θ) / α³, which is 0.4 α² too much at most.
    """
    size = 200.0 if spread < 2.0 else 2000.0
    scene = lights(lamp("AREA", placed(z=10.0), shape=shape, size=(size, size), spread=spread))
    area = size**2 * (1.0 if shape == "SQUARE" else np.pi / 4)
    assert_irradiance(scene, 100.0 / area, rounding=1.2e-3 if spread < 0.1 else 1e-3)


def test_parallel_beam():
    """E = Φ / A inside the footprint, 0 outside."""
    scene = lights(lamp("AREA", shape="RECTANGLE", size=(2.0, 1.0), spread=0.0))
    assert_irradiance(scene, 50.0, (0.9, 0.4, 0.0))
    assert_irradiance(scene, 0.0, (0.9, 0.6, 0.0))


def test_area_lamps_shine_to_one_side_and_mirrored_ones_to_the_other():
    """Along the local −Z: below, unless z is mirrored. A scale along x and y enlarges, the power stays."""
    assert irradiance(lights(lamp("AREA", placed(scale=(1, 1, -1)))), 100)[0] == 0.0
    large = lights(lamp("AREA", placed(scale=(2, -3, 1))))
    assert_irradiance(large, 100.0 / 6.0 * 4 * corner_view_factor(0.5, 0.75))


def test_constant_environment():
    """E = π L."""
    assert_irradiance(lights(environment=white(2.0)), 2.0 * np.pi)


def test_triangles():
    """Lambert's formula: E = ½ Σ L Σ_edges γ (a × b)/|a × b| · n, here with all triangles above the plane."""
    emitters = triangles()
    expected = 0.0
    for corners, radiance in zip(emitters.vertices.astype(np.float64), emitters.radiance[:, 0], strict=True):
        total = 0.0
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            normal = np.cross(a, b)
            gamma = np.arctan2(np.sqrt(normal @ normal), a @ b)
            total += gamma * normal[2] / np.sqrt(normal @ normal)
        expected += 0.5 * radiance * abs(total)
    assert_irradiance(lights(triangles=emitters), expected)
