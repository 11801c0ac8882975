"""Shadowing of bumped diffuse surfaces: none without bumps, GGX's with them, nothing through the surface."""

import numpy as np
from support.hits import unit

from pt_engine.scene.bump_shadow import bump_shadow

UP = unit([[0, 0, 1]])


def directions(n=500):
    rng = np.random.default_rng(3)
    w = rng.normal(size=(n, 3))
    w[:, 2] = np.abs(w[:, 2])
    return unit(w)


def test_the_smooth_normal_shadows_nothing():
    wo = directions()
    np.testing.assert_allclose(bump_shadow(UP, UP, wo), 1, atol=1e-6)


def test_bumps_shadow_as_microfacets_do():
    """δ = 60°: α² = tan² 60°/8 = 3/8; at θ = 45° G₁ = 2/(1 + √(1 + 3/8))."""
    bumped = unit([[np.sin(np.pi / 3), 0, 0.5]])
    wo = unit([[0.6, 0.8, 1.0]])
    np.testing.assert_allclose(bump_shadow(UP, bumped, wo), 2 / (1 + np.sqrt(1 + 3 / 8)), rtol=1e-5)


def test_no_light_through_the_surface():
    """Above the bumped normal's plane but below the smooth one's: 0; mirrored to both other sides alike."""
    bumped, wo = unit([[1, 0, 1]]), unit([[1, 0, -0.2]])
    assert bump_shadow(UP, bumped, wo)[0] == 0
    assert bump_shadow(UP, bumped, unit([[-1, 0, 0.2]]))[0] == 0
    assert bump_shadow(UP, bumped, unit([[1, 0, 0.2]]))[0] > 0


def test_factors_are_between_0_and_1():
    rng = np.random.default_rng(4)
    n, m, w = (unit(rng.normal(size=(2000, 3))) for _ in range(3))
    shadow = bump_shadow(n, m, w)
    assert np.isfinite(shadow).all()
    assert shadow.min() >= 0
    assert shadow.max() <= 1 + 1e-6
