"""One path told vertex by vertex: every event with its numbers, for every integrator and every end."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support import scenes as make
from support.rooms import MIRROR, half_transparent

from pt_engine.render.replay import Replay, replay
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import LightData

UP = np.eye(4)
LADDER = ["normals", "direct_bsdf", "direct_emitter", "direct_mis", "path", "path_active", "path_fixed"]
AT = (100.0, -50.0, 20.0)  # the scene's place: told in true world coordinates
CENTRE, CORNER = (4, 4), (0, 0)


def square(material):
    """A square of edge 1 in a picture of edge 2, under a lamp and a sky."""
    x, y, z = AT
    lamp = LightData("AREA", "lamp", make.translation(x, y, z + 5), 300.0, size=(1.0, 1.0))
    camera = make.orthographic((x, y, z + 3), AT, 2.0)
    return make.scene([(make.quad(1.0), make.translation(*AT), material)], camera, [lamp], make.world(0.5))


SCENES = {
    "diffuse": square(make.diffuse(0.6, "grey paint")),
    "mirror": square(MIRROR),
    "veil": square(half_transparent(0.5)),
    "lamp": square(make.emission(3.0)),
}


@cache
def prepared(name):
    return prepare(SCENES[name])


def story(name, pixel=CENTRE, sample=0, **more) -> Replay:
    settings = RenderSettings(8, 8, **{"pixel_filter": "BOX", "filter_width": 1.0, "max_depth": 4, **more})
    return replay(prepared(name), settings, *pixel, sample)


def kinds(told: Replay) -> list[str]:
    return [event.what for event in told.events]


@pytest.mark.parametrize("integrator", LADDER)
@pytest.mark.parametrize("pixel", [CENTRE, CORNER], ids=["hit", "sky"])
@pytest.mark.parametrize("name", SCENES)
def test_every_path_can_be_told(integrator, pixel, name):
    """Whatever it meets or does not: text for each, and contributions that add up to the film's sample."""
    for sample in range(4):
        told = story(name, pixel, sample, integrator=integrator)
        lines = list(told.lines())
        assert lines[0].startswith(f"pixel {pixel[0]},{pixel[1]}  sample {sample}")
        assert lines[-1].startswith("radiance")
        assert told.events[0].what == "camera ray"
        if integrator != "normals":
            parts = [e.contribution for e in told.events if e.contribution is not None]
            np.testing.assert_allclose(sum(parts, np.zeros(3)), told.radiance, rtol=1e-5, atol=1e-7)
    if pixel == CORNER and integrator != "normals":
        assert "the ray leaves the scene" in kinds(told)
        np.testing.assert_allclose(told.radiance, 0.5)


def test_a_hit_is_named_and_placed_in_the_world():
    events = {event.what: event for event in story("diffuse").events}
    hit = events["scatters at"].numbers
    assert hit["material"] == "grey paint"
    assert hit["object"] == "object 0"
    assert hit["position"][2] == pytest.approx(AT[2], abs=1e-5)
    assert np.abs(hit["position"][:2] - AT[:2]).max() < 0.5
    np.testing.assert_allclose(hit["normal"], (0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(hit["wi"], (0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(events["camera ray"].numbers["direction"], (0, 0, -1), atol=1e-6)
    assert events["camera ray"].numbers["origin"][2] == pytest.approx(AT[2] + 3, abs=1e-3)


def test_densities_and_weights_are_told():
    """MIS weight p²/(p² + q²) of the numbers beside it; Le/pdf and pdf of the emitter sample."""
    found = [e for s in range(8) for e in story("diffuse", sample=s).events if e.what == "found an emitter"]
    assert found
    for event in found:
        p, q = float(event.numbers["pdf BSDF"]), float(event.numbers["pdf emitter"])
        assert event.numbers["mis"] == pytest.approx(
            p * p / (p * p + q * q) if np.isfinite(p) else 1.0, rel=1e-4
        )
        expected = event.numbers["beta"] * event.numbers["Le"] * event.numbers["mis"]
        np.testing.assert_allclose(event.contribution, expected, rtol=1e-4)
    emitter = next(e for e in story("diffuse").events if e.what == "emitter sample").numbers
    assert {"wo", "distance", "pdf emitter", "Le/pdf", "shadow_ray"} <= set(emitter)
    assert emitter["shadow_ray"] in ("visible", "blocked", "no light from there")


def test_the_throughput_is_told_as_it_is_at_the_time():
    """β = 1 where the camera's path is shaded; after a bounce it is the product of the weights so far."""
    for sample in range(8):
        beta = np.ones(3)
        for event in story("diffuse", sample=sample, max_depth=6).events:
            if event.what == "shaded":
                np.testing.assert_allclose(event.numbers["beta"], beta, rtol=1e-5)
            elif event.what == "BSDF sample":
                beta = beta * event.numbers["weight"]


def test_lobes_are_told_in_words():
    words = {
        e.numbers["lobe"]
        for s in range(12)
        for e in story("veil", sample=s).events
        if e.what == "BSDF sample"
    }
    assert words == {"diffuse", "Dirac, transmitted, passed through"}
    words = {e.numbers["lobe"] for e in story("mirror").events if e.what == "BSDF sample"}
    assert words == {"Dirac"}


def test_the_same_path_is_told_the_same_way():
    assert list(story("diffuse", sample=5).lines()) == list(story("diffuse", sample=5).lines())
    assert list(story("diffuse", sample=5).lines()) != list(story("diffuse", sample=6).lines())
    assert list(story("diffuse", sample=5).lines()) != list(story("diffuse", sample=5, seed=1).lines())


def test_the_window_is_respected():
    """Pixels are those of the full image; outside of the border nothing was rendered."""
    inside = story("diffuse", CENTRE, border=(3, 3, 6, 6))
    np.testing.assert_array_equal(inside.radiance, story("diffuse", CENTRE).radiance)
    for pixel in ((2, 4), (6, 4), (4, 2), (4, 6)):
        with pytest.raises(ValueError, match="outside"):
            story("diffuse", pixel, border=(3, 3, 6, 6))
    for pixel in ((-1, 0), (8, 0), (0, 8)):
        with pytest.raises(ValueError, match="outside"):
            story("diffuse", pixel)


def test_replaying_leaves_the_scene_as_it_was():
    scene = prepared("veil")
    before = dict(scene.rays), scene.alpha
    story("veil")
    assert (dict(scene.rays), scene.alpha) == before
