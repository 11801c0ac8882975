"""From snapshot to scene: nothing at all renders, materials in use are listed, history is kept if read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.estimates import assert_same_mean
from support.rooms import MIRROR, ROUGH, half_transparent

from pt_engine.nodes.coverage import APPROXIMATE
from pt_engine.render.integrator import INTEGRATORS
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import Graph, LightData, Link, Node

UP = np.eye(4)
CAMERA = make.perspective((0, -5, 0), (0, 0, 0))
GREY = make.diffuse(0.5)
HOLLOW = make.mesh(np.zeros((0, 3)), np.zeros((0, 3)))
LADDER = ["normals", "direct_bsdf", "direct_emitter", "direct_mis", "path", "path_active", "path_fixed"]


@pytest.mark.parametrize("integrator", LADDER)
@pytest.mark.parametrize("objects", [[], [(HOLLOW, UP, GREY)]], ids=["none", "hollow"])
def test_without_a_triangle_there_is_the_sky(integrator, objects):
    """L = L_sky in every pixel, exactly; the normals integrator has nothing to show."""
    snapshot = make.scene(objects, CAMERA, [LightData("POINT", "p", UP, 10.0)], make.world((0.25, 0.5, 2.0)))
    image = make.rendered(snapshot, 5, samples=3, integrator=integrator).image()
    assert (image[..., :3] == ((0, 0, 0) if integrator == "normals" else (0.25, 0.5, 2.0))).all()
    assert (image[..., 3] == 1).all()


@pytest.mark.parametrize("integrator", LADDER)
def test_without_a_triangle_or_a_sky_there_is_darkness(integrator):
    result = make.rendered(make.scene([], CAMERA), 5, samples=3, integrator=integrator)
    assert (result.image()[..., :3] == 0).all()
    assert (result.film.counts() == 3).all()


def test_without_a_triangle_a_transparent_film_is_empty():
    snapshot = make.scene([], CAMERA, sky=make.world(1.0))
    assert (make.rendered(snapshot, 5, samples=2, film_transparent=True).image() == 0).all()


def test_a_hidden_world_of_only_lamps_keeps_them_visible_as_asked():
    """A lamp that the camera may see, with nothing else in the scene: its disc has the sphere's radiance."""
    h, r, power = 4.0, 1.0, 100.0
    lamp = LightData("POINT", "ball", make.translation(0, h - 5, 0), power, radius=r, visibility=63)
    snapshot = make.scene([], make.perspective((0, -5, 0), (0, 0, 0), 0.01), [lamp])
    image = make.rendered(snapshot, 4, samples=1).image()
    np.testing.assert_allclose(image[..., :3], power / (4 * np.pi**2 * r**2), rtol=1e-5)


def test_emissive_triangles_are_numbered_and_placed():
    materials = [GREY, make.emission(2.0), GREY]
    objects = [(make.box(), make.translation(5 * k, 0, 0), m) for k, m in enumerate(materials)]
    scene = prepare(make.scene(objects, CAMERA))
    assert scene.emissive_prim.tolist() == list(range(12, 24))
    assert scene.lights.description.counts["triangle"] == 12


def test_used_materials_are_those_on_triangles():
    """Not the stand-in for empty slots, nor a material of nobody; and coverage speaks of these only."""
    odd = make.shader("BsdfNothingKnown", "odd")
    snapshot = make.scene([(make.quad(), UP, GREY)], CAMERA)
    snapshot = replace(snapshot, materials=(*snapshot.materials, odd))
    scene = prepare(snapshot)
    assert scene.used_materials.tolist() == [1]
    assert {c.material for c in scene.coverage} == {"diffuse"}


def test_what_the_exporter_could_not_give_is_in_the_coverage():
    snapshot = replace(make.scene([], CAMERA), unsupported=(("Smoke", "volume", "left out"),))
    entries = [c for c in prepare(snapshot).coverage if c.material == "Smoke"]
    assert [(c.node, c.state, c.effect) for c in entries] == [("volume", "ignored", "left out")]


def test_groups_are_programs_on_flat_or_smooth_geometry():
    """Equal programs share one; those of Dirac lobes alone come last: next-event estimation skips them."""
    objects = [
        (make.quad(), UP, MIRROR),
        (make.quad(), UP, make.diffuse(0.1, "a")),
        (make.quad(), UP, make.diffuse(0.9, "b")),
        (make.sphere(1, 6), UP, make.diffuse(0.9, "b")),
        (make.quad(), UP, make.emission(1.0)),
        (make.quad(), UP, ROUGH),
    ]
    scene = prepare(make.scene(objects, CAMERA))
    batches = scene.materials.batches
    dirac = [batches[g.batch].delta_only for g in scene.groups]
    assert dirac == sorted(dirac)
    assert scene.smooth_groups == dirac.count(False)
    diffuse_groups = [g for g in scene.groups if batches[g.batch].kinds == ("diffuse",)]
    assert sorted(g.smooth for g in diffuse_groups) == [False, True]
    assert scene.dead == len(scene.groups)


# ------------------------------------------------------------------ rays remember where they came from


def trick(what: str) -> Graph:
    """A lamp that shines only on rays of one kind, as artists use it."""
    nodes = (
        Node("LightPath", "path", {}),
        Node("Emission", "glow", {"Color": make.WHITE, "Strength": Link(0, what)}),
    )
    return Graph(f"lamp for {what}", nodes, {"Surface": Link(1, "Emission")})


def under(lamp: Graph, floor: Graph, sky: Graph | None = None):
    """A lamp 1 above a floor; the camera between looks down at a small patch."""
    objects = [(make.quad(40.0), UP, floor), (make.quad(2.0), make.translation(0, 0, 1), lamp)]
    return make.scene(objects, make.orthographic((0, 0, 0.5), (0, 0, 0), 0.02), sky=sky)


@pytest.mark.parametrize("integrator", ["direct_bsdf", "direct_emitter", "direct_mis", "path"])
def test_a_lamp_for_diffuse_rays_lights_a_diffuse_floor(integrator):
    """As if it shone for all: the floor is lit by diffuse rays alone, however they are sampled."""
    floor = make.diffuse(0.8)
    some = under(trick("Is Diffuse Ray"), floor)
    everyone = under(make.emission(1.0), floor)
    assert_same_mean(
        make.rendered(some, 8, samples=128, integrator=integrator, max_depth=2),
        make.rendered(everyone, 8, samples=128, seed=1, max_depth=2),
    )


def test_a_lamp_for_the_camera_lights_nothing():
    snapshot = under(trick("Is Camera Ray"), make.diffuse(0.8))
    assert make.rendered(snapshot, 8, samples=16).image()[..., :3].max() == 0
    seen = replace(snapshot, camera=make.orthographic((0, 0, 5), (0, 0, 0), 0.02))
    assert (make.rendered(seen, 4, samples=2).image()[..., :3] == 1).all()


def test_a_lamp_for_glossy_rays_is_seen_in_a_mirror():
    """L = ρ Le in an ideal mirror: the ray that finds the lamp is glossy, reflected and singular."""
    for what in ("Is Glossy Ray", "Is Reflection Ray", "Is Singular Ray"):
        image = make.rendered(under(trick(what), MIRROR), 4, samples=2).image()
        np.testing.assert_allclose(image[..., :3], 0.9, rtol=1e-4, err_msg=what)
    image = make.rendered(under(trick("Is Diffuse Ray"), MIRROR), 4, samples=2).image()
    assert (image[..., :3] == 0).all()


@pytest.mark.parametrize("integrator", ["direct_bsdf", "direct_emitter", "path"])
def test_a_lamp_may_shine_by_the_rays_depth(integrator):
    """Strength = Ray Depth is 1 after one bounce, however the lamp is found, and 0 to the camera."""
    floor = make.diffuse(0.8)
    assert_same_mean(
        make.rendered(under(trick("Ray Depth"), floor), 8, samples=128, integrator=integrator, max_depth=2),
        make.rendered(under(make.emission(1.0), floor), 8, samples=128, seed=1, max_depth=2),
    )


def test_history_is_kept_only_where_somebody_asks():
    """A material or the world that reads the path, or transparency; but not one that nobody has."""
    for snapshot, kept in (
        (under(make.emission(1.0), GREY), False),
        (under(trick("Is Diffuse Ray"), GREY), True),
        (under(make.emission(1.0), GREY, trick_world()), True),
        (under(make.emission(1.0), half_transparent(0.5)), True),
        (under(make.emission(1.0), half_transparent(0.0)), False),
    ):
        assert prepare(snapshot).tracks_history == kept, snapshot.materials[-1].name
    unused = under(make.emission(1.0), GREY)
    unused = replace(unused, materials=(*unused.materials, trick("Is Diffuse Ray"), half_transparent(0.5)))
    assert not prepare(unused).tracks_history


def trick_world() -> Graph:
    nodes = (
        Node("LightPath", "path", {}),
        Node("Background", "sky", {"Color": make.WHITE, "Strength": Link(0, "Is Camera Ray")}),
    )
    return Graph("sky for the camera", nodes, {"Surface": Link(1, "Background")})


def test_a_sky_for_the_camera_lights_nothing():
    """White behind, black on the floor: the usual way to a white background."""
    square = (make.quad(1.0), UP, make.diffuse(0.8))
    snapshot = make.scene([square], make.orthographic((0, 0, 3), (0, 0, 0), 2.0), sky=trick_world())
    image = make.rendered(snapshot, 16, samples=8).image()[..., :3]
    assert (image[0] == 1).all()
    close = replace(snapshot, camera=make.orthographic((0, 0, 3), (0, 0, 0), 0.9))
    assert (make.rendered(close, 8, samples=8).image()[..., :3] == 0).all()


def test_every_integrator_of_the_ladder_is_tested_on_nothing():
    assert set(LADDER) <= set(INTEGRATORS)


@pytest.mark.parametrize(("kind", "size", "named"), [("POINT", 0.0, 0), ("POINT", 0.2, 1), ("AREA", 0.0, 1)])
def test_lamps_for_few_bounces_are_approximate_where_rays_meet_them(kind, size, named):
    lamp = LightData(kind, "few", make.translation(0, 0, 3), 10.0, radius=size, max_bounces=1)
    made = prepare(make.scene([(make.quad(2.0), UP, GREY)], CAMERA, [lamp]))
    assert [c.state for c in made.coverage if c.node == "max bounces"] == [APPROXIMATE] * named
