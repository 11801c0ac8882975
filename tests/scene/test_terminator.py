"""Shadow rays that start where the curved surface would be: where that is, what it mends, and adds never."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_within_standard_errors
from support.motion import moving, standing_at

from pt_engine.emitters.lights import LightSample
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import LightData
from pt_engine.scene.terminator import Terminator, height
from pt_engine.scene.wave import Rays

UP = np.eye(4)
WHITE = make.diffuse(1.0, "white")
CAMERA = make.orthographic((0, -5, 0), (0, 0, 0), 2.2)
TILT = 1.3  # of the sun, off the zenith, toward +x
SUN = LightData("SUN", "sun", make.looking((np.sin(TILT), 0.0, np.cos(TILT)), (0, 0, 0)), np.pi)


def ball(rings=4, cutoff=0.1, smooth=True, lights=(), sky=None, material=WHITE):
    """A unit sphere of few triangles."""
    placed = [(make.sphere(1.0, rings, smooth), UP, material)]
    return with_cutoff(make.scene(placed, CAMERA, lights, sky), cutoff)


def with_cutoff(snapshot, *cutoff):
    instances = replace(snapshot.instances, terminator=np.array(cutoff, np.float32))
    return replace(snapshot, instances=instances)


def seen(scene, n=48):
    """The points that a parallel camera along +y sees, and where in the picture they are."""
    x, z = (
        a.ravel()
        for a in np.meshgrid((np.arange(n) + 0.5) / n * 2.2 - 1.1, (np.arange(n) + 0.5) / n * 2.2 - 1.1)
    )
    zero = np.zeros_like(x)
    o = np.stack([x, zero - 5, z]).astype(np.float32)
    d = np.broadcast_to(np.array([[0], [1], [0]], np.float32), o.shape).copy()
    rays = Rays(o, d, np.full(o.shape[1], 1e30, np.float32))
    found = scene.intersect(rays)
    lanes = np.flatnonzero(found.hits.prim >= 0)
    return scene.surface(rays, found, lanes), lanes


def test_height_over_a_sphere():
    """Corners on the unit sphere, nᵢ = xᵢ: b = Σ bᵢ bⱼ |xᵢ − xⱼ|² = 1 − |p|², tangent planes at 1 − xᵢ·p.

    The interpolated normal is p itself. In float32; h is of the order of 0.1.
    """
    scene = prepare(ball())
    si, _ = seen(scene)
    corners = scene.layer("position", "").corners(si.prim, si.instance)
    planes = np.stack([1 - (x * si.p).sum(axis=0) for x in corners])
    h = np.maximum(planes.min(axis=0), (1 - (si.p**2).sum(axis=0)) / 2)
    np.testing.assert_allclose(height(scene, si, si.ng, None), si.p * h, atol=2e-6)
    assert h.max() > 0.05


@pytest.mark.parametrize("share", [1.0, 0.75, 0.25, 0.0])
def test_the_lift_fades_in_from_the_cutoff_on(share):
    """A ray at ng·ω = (1 − share) c, n·ω > c: 2 − (ng·ω + c)/c = share of the height, and the bound."""
    cutoff = 0.2
    scene = prepare(ball(cutoff=cutoff))
    si, _ = seen(scene)
    si.ns = (si.p / np.sqrt((si.p**2).sum(axis=0))).astype(np.float32)
    along = np.cross(np.cross(si.ng, si.ns, axis=0), si.ng, axis=0)  # down the triangle, where n leans
    some = np.flatnonzero(np.linalg.norm(along, axis=0) > 0.3)
    si, along = si.take(some), along[:, some] / np.linalg.norm(along[:, some], axis=0)
    cosine = (1 - share) * cutoff
    wo = (cosine * si.ng + np.sqrt(1 - cosine**2) * along).astype(np.float32)
    o = si.p.copy()
    scene.terminator.lift(scene, si, wo, o, np.full(si.size, 1e30, np.float32))
    lifted = np.linalg.norm(o - si.p - si.bound * si.ng * (share > 0), axis=0)
    expected = share * np.linalg.norm(height(scene, si, si.ng, None), axis=0)
    assert expected.max() > 0.01 or share == 0
    np.testing.assert_allclose(lifted, expected, atol=3e-6)


def test_nothing_moves_on_flat_meshes_nor_without_an_offset():
    for snapshot in (ball(smooth=False), replace_none(ball()), ball(cutoff=0.0), ball(cutoff=float("nan"))):
        scene = prepare(snapshot)
        found = Terminator.of(snapshot, np.zeros(1, np.bool_))
        assert found is None or found.widest == 0
        assert ("position", "") not in scene.layers
        assert scene.features["curved shadow terminators"].startswith("off")
    assert prepare(ball()).features["curved shadow terminators"] == "on"


def test_without_an_offset_only_others_hide_light_below_the_triangle():
    """A sun between the horizons of a lone square lights it by n·ω; another square below takes it away."""
    lean, sun = 0.8, LightData("SUN", "sun", make.looking((0.0, np.cos(0.3), -np.sin(0.3)), (0, 0, 0)), np.pi)
    square, camera = leaning(lean), make.orthographic((0, 0, 5), (0, 0, 0), 1.0)
    below = make.quad(8.0), make.translation(0, 0, -0.1), WHITE
    for objects, expected in (
        ([(square, UP, WHITE)], np.sin(lean - 0.3)),
        ([(square, UP, WHITE), below], 0.0),
    ):
        image = picture(with_cutoff(make.scene(objects, camera, [sun]), *[0.0] * len(objects)), 8).image()
        np.testing.assert_allclose(image[..., :3], expected, atol=1e-4)


def leaning(angle):
    """A square whose normals lean toward +y."""
    square = make.quad(2.0)
    normal = np.float32([0, np.sin(angle), np.cos(angle)])
    normals = np.broadcast_to(normal, square.vertices.shape).copy()
    return replace(square, normals=normals, normal_index=square.triangles)


def replace_none(snapshot):
    return replace(snapshot, instances=replace(snapshot.instances, terminator=None))


def picture(snapshot, size=48, **more):
    settings = {"samples": 4, "max_depth": 2, "pixel_filter": "BOX", "sampler": "independent", "threads": 1}
    return render(prepare(snapshot), RenderSettings(size, size, **(settings | more)))


def test_a_coarse_sphere_has_the_shadow_of_a_round_one():
    """L = max(n·ω, 0) for a white sphere under a sun of irradiance π: steps of triangles without the offset.

    Of the pixels that n says are lit, the share that is black. The sun stands a little behind the sphere, so
    that no triangle lies in its direction.
    """
    dark, toward = {}, np.array([np.sin(TILT), 0.1, np.cos(TILT)]) / np.hypot(1, 0.1)
    sun = replace(SUN, matrix=make.looking(toward, (0, 0, 0)))
    for cutoff in (0.0, 0.1):
        image = picture(ball(rings=3, cutoff=cutoff, lights=[sun]), samples=1).image()[..., 0]
        scene = prepare(ball(rings=3))
        si, lanes = seen(scene)
        n = si.p / np.sqrt((si.p**2).sum(axis=0))
        lit = toward @ n > 0.05
        dark[cutoff] = float((image.ravel()[lanes][lit] == 0).mean())
    assert dark[0.0] > 0.05
    assert dark[0.1] < 0.1 * dark[0.0]


@pytest.mark.parametrize("kind", ["diffuse", "translucent"])
def test_each_sample_is_what_it_was_or_nothing(kind):
    """V ∈ {0, 1} whatever the ray: no contribution grows, so the furnace's bound is the BSDF's alone."""
    material = WHITE if kind == "diffuse" else make.shader("BsdfTranslucent", Color=make.WHITE)
    scene = prepare(ball(cutoff=1.0, material=material, sky=make.world(1.0)))
    si, _ = seen(scene)
    si.ns = (si.p / np.sqrt((si.p**2).sum(axis=0))).astype(np.float32)
    rng = np.random.default_rng(5)
    wo = rng.normal(size=si.p.shape)
    wo = (wo / np.sqrt((wo**2).sum(axis=0))).astype(np.float32)
    asked = rng.random(wo.shape).astype(np.float32) + np.float32(0.1)
    far = rng.choice(np.array([1e30, 0.5, 3.0], np.float32), si.size)
    zero = np.zeros(si.size, np.float32)
    light = LightSample(wo, far, asked, zero, False, 0)
    found = scene.unoccluded(si, light, asked.copy(), 8, None)  # no path is followed: nothing is transparent
    kept = (found != 0).all(axis=0)
    assert 0.1 < kept.mean() < 0.9
    np.testing.assert_array_equal(found, asked * kept)


@pytest.mark.parametrize("integrator", ["direct_emitter", "direct_mis", "path"])
@pytest.mark.parametrize("inside", [False, True])
def test_white_furnace(integrator, inside):
    """A white sphere of few triangles under a white sky never shines: ∫ f n·ω V dω ≤ 1 for every V.

    Seen from outside, and from within through a hole. Pixels by their own standard errors: 5 of them are
    exceeded by chance in 1 of 6,000 such pictures.
    """
    shell = make.sphere(1.0, 3)
    if inside:
        shell = replace_triangles(shell, (shell.vertices[shell.triangles][:, :, 1] > -0.2).all(axis=1))
    snapshot = with_cutoff(make.scene([(shell, UP, WHITE)], CAMERA, sky=make.world(1.0)), 1.0)
    film = picture(snapshot, 24, samples=256, integrator=integrator, max_depth=32).film
    image, error = film.image()[..., :3].reshape(-1), np.sqrt(film.variance_of_mean()).reshape(-1)
    assert (image <= 1 + 5 * error + 1e-5).all()
    assert error.max() < 0.1  # so that the bound says something


@pytest.mark.parametrize("cutoff", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("lean", [0.3, 0.8])
def test_a_uniform_sky_lights_what_the_triangles_see(lean, cutoff):
    """∫ max(n·ω, 0)/π over ng·ω > 0 is (1 + cos δ)/2: between the horizons, δ apart, nothing shines.

    Such a sky is found by BSDF samples alone, which keep the triangles, whatever the offset.
    """
    camera = make.orthographic((0, 0, 5), (0, 0, 0), 1.0)
    snapshot = with_cutoff(make.scene([(leaning(lean), UP, WHITE)], camera, sky=make.world(1.0)), cutoff)
    assert_within_standard_errors(
        make.rendered(snapshot, 8, samples=256, max_depth=2), (1 + np.cos(lean)) / 2
    )


def replace_triangles(mesh, keep):
    assert mesh.normal_index is not None
    slots = mesh.material_slot[keep]
    return replace(
        mesh, triangles=mesh.triangles[keep], normal_index=mesh.normal_index[keep], material_slot=slots
    )


def test_a_moving_ball_is_lifted_where_it_is():
    """A slice is the scene that stands still at its time, bit for bit; two share the mesh (see `alone`)."""
    path = [make.translation(-0.3, 0, 0), make.translation(0.3, 0, 0.1) @ np.diag([1, 0.8, 1.2, 1.0])]
    floor = make.quad(8.0), make.translation(0, 0, -1.4), WHITE
    top = make.quad(0.1), make.translation(0, 0, 4), WHITE  # the scene's box is the same at all times
    ball, other = make.sphere(1.0, 3), make.translation(0, 3, 0)
    stage = make.scene([(ball, UP, WHITE), floor, top, (ball, other, WHITE)], CAMERA, [SUN])
    stage.instances.mesh[3] = 0
    snapshot = moving(with_cutoff(stage, 0.1, 0.0, 0.0, 0.0), {0: path})
    slice_ = prepare(snapshot).slices.at(0.3)
    slice_.slices = None
    settings = RenderSettings(24, 24, samples=2, threads=1, max_depth=3)
    found, expected = (
        render(s, settings).image() for s in (slice_, prepare(standing_at(snapshot, slice_.time)))
    )
    assert found[..., :3].std() > 0.01
    np.testing.assert_array_equal(found, expected)
