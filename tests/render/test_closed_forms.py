"""Whole renders whose answer is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_within_standard_errors

from pt_engine.scene.snapshot import LightData

pytestmark = pytest.mark.slow  # physics that no Python changes

ALBEDO = 0.8
UP = np.eye(4)
DOWN = np.diag([1.0, -1.0, -1.0, 1.0])  # a lamp there shines along +Z


def lit_plane(lamp: LightData | None = None, sky=None, objects=(), spot: float = 0.02):
    """A tiny patch of a large Lambert plane around the origin, seen from above."""
    plane = (make.quad(200.0), UP, make.diffuse(ALBEDO))
    camera = make.orthographic((0, 0, 50.0), (0, 0, 0), spot)
    return make.scene([plane, *objects], camera, [lamp] if lamp else [], sky)


def lamp_at(height: float, **more) -> LightData:
    return LightData(name="lamp", matrix=make.translation(0, 0, height), **more)


@pytest.mark.parametrize("integrator", ["direct_emitter", "direct_mis", "path"])
def test_point_light_over_a_plane(integrator):
    """E = I / h² with I = Φ / (4π) for a lamp of Φ watts; L = ρ E / π."""
    h, power = 2.0, 100.0
    snapshot = lit_plane(lamp_at(h, kind="POINT", power=power))
    expected = ALBEDO / np.pi * power / (4 * np.pi) / h**2
    # the patch is 0.02 wide: cos³ falls by less than 2e-5 at its edge
    result = make.rendered(snapshot, 4, samples=4, integrator=integrator, max_depth=2)
    assert_within_standard_errors(result, expected, relative=1e-4)


@pytest.mark.parametrize("integrator", ["direct_emitter", "direct_bsdf", "direct_mis", "path"])
def test_sphere_light_over_a_plane(integrator):
    """E = π L (r/h)² for a sphere of radiance L at distance h: L = Φ / (4 π² r²) from Φ watts."""
    h, r, power = 2.0, 0.5, 100.0
    snapshot = lit_plane(lamp_at(h, kind="POINT", power=power, radius=r))
    radiance = power / (4 * np.pi**2 * r**2)
    result = make.rendered(snapshot, 8, samples=256, integrator=integrator, max_depth=2)
    assert_within_standard_errors(result, ALBEDO * radiance * (r / h) ** 2, relative=1e-4)


@pytest.mark.parametrize("integrator", ["direct_emitter", "direct_bsdf", "direct_mis", "path"])
def test_rectangle_light_over_a_plane(integrator):
    """View factor of a parallel a×b rectangle centred above a point (Howell's catalogue B-3, four times)."""
    h, a, b, power = 1.5, 1.0, 2.0, 50.0
    snapshot = lit_plane(lamp_at(h, kind="AREA", shape="RECTANGLE", size=(a, b), power=power))
    x, y = a / 2 / h, b / 2 / h
    quarter = (
        x / np.hypot(1, x) * np.arctan(y / np.hypot(1, x))
        + y / np.hypot(1, y) * np.arctan(x / np.hypot(1, y))
    ) / (2 * np.pi)
    radiance = power / (np.pi * a * b)
    result = make.rendered(snapshot, 8, samples=256, integrator=integrator, max_depth=2)
    assert_within_standard_errors(result, ALBEDO * radiance * 4 * quarter, relative=1e-4)


@pytest.mark.parametrize("angle", [0.0, 0.2])
def test_sun_on_a_tilted_plane(angle):
    """E = E⊥ cosθ for any disc above the horizon; L = ρ E / π."""
    tilt = 0.6
    direction = np.array([np.sin(tilt), 0, np.cos(tilt)])
    lamp = LightData("SUN", "sun", make.looking(direction, (0, 0, 0)), power=3.0, angle=angle)
    result = make.rendered(lit_plane(lamp), 8, samples=64, integrator="path", max_depth=2)
    assert_within_standard_errors(result, ALBEDO / np.pi * 3.0 * np.cos(tilt), relative=1e-4)


@pytest.mark.parametrize("integrator", ["direct_emitter", "direct_bsdf", "direct_mis", "path"])
def test_mesh_light_over_a_plane(integrator):
    """A square of two emissive triangles: the rectangle's view factor again, L given."""
    h, a, radiance = 1.0, 1.0, 7.0
    lamp = (make.quad(a), make.translation(0, 0, h), make.emission(radiance))
    x = a / 2 / h
    factor = 4 * (2 * x / np.hypot(1, x) * np.arctan(x / np.hypot(1, x))) / (2 * np.pi)
    camera = make.orthographic((0, 0, 0.5), (0, 0, 0), 0.02)
    snapshot = make.scene([(make.quad(200.0), UP, make.diffuse(ALBEDO)), lamp], camera)
    result = make.rendered(snapshot, 8, samples=256, integrator=integrator, max_depth=2)
    assert_within_standard_errors(result, ALBEDO * radiance * factor, relative=1e-4)


@pytest.mark.parametrize("integrator", ["direct_emitter", "direct_bsdf", "direct_mis", "path"])
def test_plane_under_a_constant_sky(integrator):
    """Unblocked hemisphere: L = ρ L_sky."""
    result = make.rendered(lit_plane(sky=make.world(2.0)), 8, samples=64, integrator=integrator, max_depth=2)
    assert_within_standard_errors(result, ALBEDO * 2.0)


@pytest.mark.parametrize("albedo", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("integrator", ["path", "path_active", "path_fixed"])
def test_closed_box_radiance_is_the_neumann_series(albedo, integrator):
    """Uniform emitter Le in a closed box of reflectance a: L = Le Σ aᵏ, truncated after max_depth edges."""
    walls = (make.box(2.0, inward=True), UP, make.shining_diffuse(albedo, 1.0))
    snapshot = make.scene([walls], make.perspective((0.1, 0.2, -0.3), (0.5, 0.4, 0.2), 1.0))
    for max_depth in (1, 2, 5, 20):
        expected = sum(albedo**k for k in range(max_depth))
        result = make.rendered(snapshot, 12, samples=48, integrator=integrator, max_depth=max_depth)
        assert_within_standard_errors(result, expected)


def test_closed_box_without_truncation_sums_the_geometric_series():
    """L = Le / (1 − a): roulette alone ends the paths."""
    walls = (make.box(2.0, inward=True), UP, make.shining_diffuse(0.8, 1.0))
    snapshot = make.scene([walls], make.perspective((0.1, 0.2, -0.3), (0.5, 0.4, 0.2), 1.0))
    result = make.rendered(snapshot, 16, samples=64, max_depth=400)
    assert_within_standard_errors(result, 5.0)


FURNACE = {
    "lambert": make.diffuse(1.0),
    "oren-nayar": make.shader("BsdfDiffuse", Color=make.WHITE, Roughness=0.7),
    "mirror": make.shader("BsdfGlossy", props={"distribution": "GGX"}, Color=make.WHITE, Roughness=0.0),
    "glass": make.shader("BsdfGlass", Color=make.WHITE, Roughness=0.0, IOR=1.5),
    "transparent": make.shader("BsdfTransparent", Color=make.WHITE),
    "rough glossy": make.shader(
        "BsdfGlossy", props={"distribution": "MULTI_GGX"}, Color=make.WHITE, Roughness=0.5
    ),
    "plastic": make.shader("PtRoughPlastic", Color=make.WHITE, Roughness=0.0, IOR=1.5),
    "rough glass": make.shader(
        "BsdfGlass", props={"distribution": "MULTI_GGX"}, Color=make.WHITE, Roughness=0.5, IOR=1.5
    ),
}
# multiscatter GGX restores the energy from a table: within half a per cent; Oren–Nayar's closed form likewise
TABLE_ERROR = {"rough glossy": 0.005, "rough glass": 0.01, "oren-nayar": 0.005}


@pytest.mark.parametrize("name", FURNACE)
def test_white_furnace_sphere_vanishes(name):
    """A lossless sphere under a constant sky cannot be seen: L = L_sky everywhere."""
    ball = (make.sphere(1.0, 48), UP, FURNACE[name])
    snapshot = make.scene([ball], make.perspective((0, -6, 0), (0, 0, 0), 0.12), sky=make.world(1.0))
    result = make.rendered(snapshot, 16, samples=64, max_depth=60)
    assert_within_standard_errors(result, 1.0, relative=TABLE_ERROR.get(name, 2e-4))


def test_orthographic_area_of_a_disc():
    """A sphere of radius r covers π r² of the picture's plane."""
    r = 0.7
    ball = (make.sphere(r, 256, smooth=False), UP, make.emission(1.0))
    snapshot = make.scene([ball], make.orthographic((0, -5, 0), (0, 0, 0), 2.0))
    result = make.rendered(snapshot, 32, samples=64, integrator="path", max_depth=1)
    # a polyhedron of 256 rings inside the sphere: area smaller by about (π/256)²/4
    assert_within_standard_errors(result, np.pi * r**2 / 4.0, relative=2e-4)
