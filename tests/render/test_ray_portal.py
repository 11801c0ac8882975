"""Ray portals: rays leave elsewhere, in another direction, and no light is sampled through them."""

from __future__ import annotations

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_within_standard_errors

from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, LightData, Link, Node

INTEGRATORS = ["path", "path_active", "path_fixed"]
BLUE = (0.1, 0.2, 0.7)


def portal(shift=None, direction=(0.0, 0.0, 0.0), color=(1.0, 1.0, 1.0), clear_share=None):
    """A portal that moves rays by `shift`, mixed with Transparent by `clear_share`."""
    inputs = {"Color": make.rgba(color), "Direction": direction}
    nodes = [Node("NewGeometry", "here", {})]
    if shift is not None:
        move = {"Vector": Link(0, "Position"), "Vector_001": shift}
        nodes.append(Node("VectorMath", "there", move, {"operation": "ADD"}))
        inputs["Position"] = Link(1, "Vector")
    nodes.append(Node("BsdfRayPortal", "portal", inputs))
    last = len(nodes) - 1
    if clear_share is not None:
        clear = Node("BsdfTransparent", "clear", {"Color": make.WHITE})
        factors = {"Fac": clear_share, "Shader": Link(last, "BSDF"), "Shader_001": Link(last + 1, "BSDF")}
        nodes += [clear, Node("MixShader", "mix", factors)]
        last += 2
    return Graph("portal", tuple(nodes), {"Surface": Link(last, "BSDF")})


def looking_down(objects, samples=1, size=0.5, sky=None, lights=(), **options):
    """A picture of what is below a parallel camera at (0, 0, 3)."""
    snapshot = make.scene(objects, make.orthographic((0, 0, 3), (0, 0, 0), size), list(lights), sky)
    return make.rendered(snapshot, 2, samples=samples, **options)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_rays_go_on_elsewhere(integrator):
    """Straight on 20 to the right, tinted: not the sheet below but the one over there is seen."""
    objects = [
        (make.quad(2.0), np.eye(4), portal((20.0, 0.0, 0.0), color=(0.5, 0.5, 0.25))),
        (make.quad(2.0), make.translation(0, 0, -1), make.emission((9.0, 9.0, 9.0))),
        (make.quad(2.0), make.translation(20, 0, -1), make.emission((1.0, 2.0, 4.0))),
    ]
    image = looking_down(objects, integrator=integrator).image()
    np.testing.assert_allclose(image[..., :3], np.broadcast_to([0.5, 1.0, 1.0], (2, 2, 3)), rtol=1e-6)


def test_a_portal_is_no_bumped_surface():
    """A sheet askew to the axes, which are the portal's frame, changes nothing of a sky of radiance 1."""
    askew = np.eye(4)
    askew[:3, :3] = [[2 / 3, -1 / 3, 2 / 3], [2 / 3, 2 / 3, -1 / 3], [-1 / 3, 2 / 3, 2 / 3]]
    for turn in (askew, askew @ np.diag([1, -1, -1, 1])):
        image = looking_down([(make.quad(8.0), turn, portal())], sky=make.world(1.0)).image()
        np.testing.assert_allclose(image[..., :3], 1.0, rtol=1e-6)


def test_rays_go_on_in_another_direction():
    """To the right: a sheet that stands there at a right angle. The direction's length does not matter."""
    side = make.translation(5, 0, 0) @ np.array([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1.0]])
    objects = [
        (make.quad(2.0), np.eye(4), portal(direction=(7.0, 0.0, 0.0))),
        (make.quad(2.0), side, make.emission(BLUE)),
    ]
    image = looking_down(objects).image()
    np.testing.assert_allclose(image[..., :3], np.broadcast_to(BLUE, (2, 2, 3)), rtol=1e-6)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_light_comes_through_a_portal_in_full(integrator):
    """A Lambert floor under portals and a square light: L = ρ F, F the square's form factor (Howell B-3).

    No emitter is sampled through a portal, so the light counts in full where a scattered ray finds it. One
    that leads 5 up brings the light 5 nearer.
    """
    albedo, half = 0.5, 4.0
    for graph, height in ((portal(), 12), (portal((0.0, 0.0, 5.0)), 7)):
        objects = [
            (make.quad(60.0), make.translation(0, 0, 6), graph),
            (make.quad(2 * half), make.translation(0, 0, 12), make.emission(1.0)),
            (make.quad(60.0), np.eye(4), make.diffuse(albedo)),
        ]
        result = looking_down(objects, samples=1024, size=0.02, integrator=integrator, max_depth=3)
        x = half / height / np.hypot(1, half / height)
        assert_within_standard_errors(result, albedo * 4 / np.pi * x * np.arctan(x), relative=1e-4)


@pytest.mark.parametrize(("clear_share", "light"), [(None, 0.0), (0.4, 1.0), (0.4, 0.0)])
def test_shadow_rays_pass_only_where_it_is_transparent_too(clear_share, light):
    """A point lamp behind: as in Cycles a mix lets its light straight through, the portal's share as well."""
    color = (light, light, light)
    objects = [
        (make.quad(60.0), make.translation(0, 0, 4), portal(color=color, clear_share=clear_share)),
        (make.quad(60.0), np.eye(4), make.diffuse(0.5)),
    ]
    height, power = 5.0, 100.0
    lamp = LightData("POINT", "lamp", make.translation(0, 0, height), power)
    lit = 0.0 if clear_share is None else clear_share + (1 - clear_share) * light
    result = looking_down(objects, samples=4, size=0.02, lights=[lamp], max_depth=2)
    expected = lit * 0.5 / np.pi * power / (4 * np.pi) / height**2
    np.testing.assert_allclose(result.image()[..., :3], expected, rtol=1e-4)


def test_facing_portals_end_with_the_transparent_depth():
    """A ray that goes round and round passes as many as transparent surfaces, then is lost."""
    objects = [
        (make.quad(2.0), np.eye(4), portal((0.0, 0.0, 1.0))),
        (make.quad(2.0), make.translation(0, 0, -1), make.emission(1.0)),
    ]
    sky = make.world(1.0)
    for depth in (0, 3, 8):
        image = looking_down(objects, sky=sky, transparent_depth=depth).image()
        assert (image[..., :3] == 0).all()


def test_the_film_is_clear_where_the_sky_shows_through():
    """A camera's ray stays one: alpha is 1 − mean of the portal's colour."""
    objects = [(make.quad(2.0), np.eye(4), portal((9.0, 0.0, 0.0), color=(0.2, 0.4, 0.6)))]
    image = looking_down(objects, sky=make.world(1.0), film_transparent=True).image()
    np.testing.assert_allclose(image[..., 3], 0.6, rtol=1e-6)
    assert (image[..., :3] == 0).all()


def test_two_portals_on_one_surface_lead_two_ways():
    """Half of the samples see each: the mean of both sheets."""
    nodes = (
        *portal((20.0, 0.0, 0.0)).nodes,
        Node(
            "BsdfRayPortal",
            "other",
            {"Color": make.WHITE, "Position": (-20.0, 0.0, 0.0), "Direction": (0, 0, -1)},
        ),
        Node("CombineXYZ", "where", {"X": -20.0, "Y": 0.0, "Z": 0.0}),
    )
    nodes[3].inputs["Position"] = Link(4, "Vector")
    mix = Node("MixShader", "mix", {"Fac": 0.5, "Shader": Link(2, "BSDF"), "Shader_001": Link(3, "BSDF")})
    graph = Graph("two ways", (*nodes, mix), {"Surface": Link(5, "Shader")})
    objects = [
        (make.quad(2.0), np.eye(4), graph),
        (make.quad(2.0), make.translation(20, 0, -1), make.emission((2.0, 0.0, 0.0))),
        (make.quad(2.0), make.translation(-20, 0, -1), make.emission((0.0, 4.0, 0.0))),
    ]
    result = looking_down(objects, samples=2048)
    assert_within_standard_errors(result, np.array([1.0, 2.0, 0.0]))


def test_scenes_without_one_know_of_none():
    camera = make.orthographic((0, 0, 3), (0, 0, 0), 1.0)
    plain = make.scene([(make.quad(), np.eye(4), make.diffuse(0.5))], camera)
    assert prepare(plain).features["ray portals"].startswith("off: ")
    assert not prepare(plain).tracks_history
    with_one = make.scene([(make.quad(), np.eye(4), portal())], camera)
    assert prepare(with_one).features["ray portals"] == "on"
