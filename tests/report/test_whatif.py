"""Effects taken out one at a time: what is missing costs nothing, what is there has its closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.motion import moving
from support.rooms import GLASS, MIRROR, ROUGH, half_transparent, room

from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.report import whatif as measuring
from pt_engine.report.caustics import without_caustics
from pt_engine.report.effects import EFFECTS, each_material, hard_shadows, matte, nodes, opaque
from pt_engine.report.page import whatif_page
from pt_engine.report.tables import whatif_lines
from pt_engine.report.whatif import whatif
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import LightData

SETTINGS = RenderSettings(16, 16, threads=1, max_depth=3, pixel_filter="BOX")
BY_NAME = {effect.name: effect for effect in EFFECTS}


def plain(lamp=None, sky=None, material=None):
    """A floor, seen from above."""
    camera = make.orthographic((0, 0, 3), (0, 0, 0), 1.0)
    objects = [(make.quad(4), np.eye(4), material or make.diffuse(0.5))]
    return make.scene(objects, camera, [lamp] if lamp else [], sky)


@pytest.fixture(autouse=True)
def _fixed_samples(monkeypatch):
    """As many on any machine, whatever its pace."""
    monkeypatch.setattr(measuring, "samples_within", lambda *_: 64)


def effects_of(snapshot, settings=SETTINGS, seconds=0.05):
    return {row["name"]: row for row in whatif(snapshot, settings, seconds)["effects"]}


def test_what_a_scene_has_not_costs_nothing_and_says_why():
    snapshot = plain(LightData("POINT", "p", make.translation(0, 0, 2), 10.0))
    told = []
    result = whatif(snapshot, replace(SETTINGS, max_depth=2), 0.02, told.append)
    assert told == ["the whole scene"]  # nothing else was rendered
    for row in result["effects"]:
        assert (row["present"], row["seconds"], row["difference"], row["energy"]) == (False, 0, 0, 0)
        assert row["why"]
    lines = "\n".join(whatif_lines(result))
    assert "depth of field: 0 s, 0 difference (the camera has no aperture)" in lines


def test_what_is_called_missing_makes_no_difference_when_it_is_taken_out_all_the_same():
    """Bit by bit, for every effect of the list; and the list has all that a render can be without."""
    snapshot = plain(LightData("POINT", "p", make.translation(0, 0, 2), 10.0))
    scene, settings = prepare(snapshot), replace(SETTINGS, max_depth=2, samples=4)
    whole = render(scene, settings).image()
    for effect in EFFECTS:
        assert effect.missing(snapshot, scene, settings), effect.name
        changed, how = effect.without(snapshot, settings)
        if effect.name != "bounces from the 2nd on":
            np.testing.assert_array_equal(render(prepare(changed), how).image(), whole, effect.name)
    told = {row["name"] for row in whatif(snapshot, settings, 0.02)["effects"]}
    listed = ("soft shadows", "depth of field", "motion blur", "world light", "glossy bounces", "refraction")
    more = ("caustics", "transparency", "bump and displacement", "volumes", "bounces from the 2nd on")
    assert told >= {*listed, *more}


def row_of(name, seconds_with, seconds_without, difference):
    return {
        **measuring.nothing(name, ""),
        "present": True,
        "seconds": seconds_with - sum(seconds_without) / 2,
        "seconds_with": seconds_with,
        "seconds_without": seconds_without,
        "difference": difference,
    }


def test_seconds_have_the_interval_that_renders_of_the_same_tell():
    """Pairs differ by 1 and 2 %; Student's t of two is 4.303: 1 s of 10 is told, 0.1 s is not."""
    rows = [row_of("dear", 10.0, [8.955, 9.045], 0.1), row_of("cheap", 10.0, [9.801, 9.999], 0.1)]
    dear, cheap = measuring.with_intervals(rows)
    sigma = np.sqrt(((0.09 / 9) ** 2 + (0.198 / 9.9) ** 2) / 2 / 2)
    half = 4.303 * sigma * np.hypot(10, 9 / np.sqrt(2))
    assert dear["seconds_ci95"][1] - dear["seconds"] == pytest.approx(half)
    assert dear["seconds_known"]
    assert dear["difference_per_second"] == pytest.approx(0.1)
    assert not cheap["seconds_known"]
    assert cheap["difference_per_second"] == pytest.approx(0.1 / cheap["seconds_ci95"][1])
    assert any("> " in line for line in whatif_lines({"seconds": 10.0, "samples": 4, "effects": [cheap]}))


def test_what_noise_hides_is_told_by_the_most_that_it_may_be(tmp_path):
    """Never as `< 0.00%`, nor as a bar; and noise that is all of an effect's is no number of times."""
    faint = row_of("faint", 1.0, [1.0, 1.0], 0.0) | {"beyond_noise": False, "difference_high": 1e-7}
    strong = row_of("strong", 1.0, [1.0, 1.0], 0.3) | {"noise": np.inf}
    rows = measuring.with_intervals([faint, strong])
    told = whatif_lines({"seconds": 10.0, "samples": 4, "effects": rows})
    (line,) = (line for line in told if line.startswith("faint"))
    assert "< 0.01%" in line
    assert " all " in next(line for line in told if line.startswith("strong"))
    result = {"file": "a", "command": "", "samples": 4, "seconds": 10.0, "complete": True, "effects": rows}
    whatif_page(tmp_path / "w.html", result | {"settings": {}, "versions": {}})
    text = (tmp_path / "w.html").read_text(encoding="utf-8")
    assert text.count("<svg ") == 2
    assert text.count(">faint<") == 2  # in the table, and among the seconds
    assert text.count(">strong<") == 3


def test_world_light_is_all_of_a_scene_that_has_no_other():
    """A = R, B = 0: energy 100 %, difference √(E R²)/E R = 1 for a uniform floor under a uniform sky."""
    row = effects_of(plain(sky=make.world(1.0)))["world light"]
    assert row["energy"] == pytest.approx(1, abs=1e-3)
    assert row["difference"] == pytest.approx(1, abs=0.01)


def test_bounces_that_no_path_takes_cost_nothing():
    """A floor alone under a lamp: a ray that leaves it meets nothing, whatever the depth."""
    rows = effects_of(plain(LightData("POINT", "p", make.translation(0, 0, 2), 10.0)))
    row = rows["bounces from the 2nd on"]
    assert row["why"] == "no path is that long"
    assert (row["seconds"], row["difference"]) == (0, 0)


def test_bounces_of_a_closed_box_are_the_neumann_series():
    """Le = 1 in a box of albedo a: L = Σ aᵏ; depth 2 leaves 1 + a of 1 + a + a² + a³."""
    a = 0.5
    inside = make.scene(
        [(make.box(2.0, inward=True), np.eye(4), make.shining_diffuse(a, 1.0))],
        make.perspective((0, 0, 0), (0, 1, 0)),
    )
    rows = effects_of(inside, replace(SETTINGS, max_depth=4, rr_depth=9))
    whole = 1 + a + a**2 + a**3
    assert rows["bounces from the 2nd on"]["energy"] == pytest.approx((a**2 + a**3) / whole, abs=0.01)
    assert rows["bounces from the 3rd on"]["energy"] == pytest.approx(a**3 / whole, abs=0.01)
    assert not rows["bounces from the 4th on"]["present"]


@pytest.mark.parametrize(
    "lamp",
    [
        LightData("AREA", "a", make.looking((0, 0, 4), (0, 0, 0)), 60.0, size=(0.2, 0.2)),
        LightData("AREA", "a", make.looking((0, 0, 4), (0, 0, 0)), 60.0, size=(0.2, 0.2), normalize=False),
        LightData("POINT", "p", make.translation(0, 0, 4), 60.0, radius=0.1),
        LightData("SUN", "s", np.eye(4), 2.0, angle=0.01),
    ],
    ids=["area", "area-radiance", "point", "sun"],
)
def test_hard_lamps_shine_as_soft_ones_do_where_nothing_is_in_the_way(lamp):
    """Far from a small lamp the irradiance does not depend on its size: to (0.1/4)² ≈ 6e-4."""
    soft, hard = (
        make.rendered(s, 8, samples=256).image()[..., :3].mean()
        for s in (plain(lamp), hard_shadows(plain(lamp)))
    )
    assert hard == pytest.approx(soft, rel=0.01)


def test_hard_shadows_change_the_picture():
    lamp = LightData("AREA", "a", make.looking((0.5, -0.5, 3.0), (0, 0, 0)), 60.0, size=(1.5, 1.5))
    row = effects_of(room(make.diffuse(0.5), lamp))["soft shadows"]
    assert row["difference"] > 0.02


def test_depth_of_field_of_a_flat_field_makes_no_difference():
    """Everything shines alike: in or out of focus it is the same, to the last bits of float32."""
    snapshot = plain(sky=make.world(1.0), material=make.emission(1.0))
    camera = replace(snapshot.camera, aperture_radius=0.1, focus_distance=1.0)
    row = effects_of(replace(snapshot, camera=camera))["depth of field"]
    assert row["present"]
    assert row["difference"] < 1e-5


def test_motion_blur_is_seen_where_something_moves_and_taken_out_whole():
    """A shining quad crosses the view; without blur it stands in the middle of the shutter."""
    camera = make.orthographic((0, 0, 3), (0, 0, 0), 2.0)
    still = make.scene([(make.quad(1), np.eye(4), make.emission(1.0))], camera)
    path = [make.translation(x, 0, 0) for x in (-1.0, 1.0)]
    row = effects_of(moving(still, {0: path}))["motion blur"]
    assert row["present"]
    assert row["difference"] > 0.2
    assert row["energy"] < 0.01
    assert effects_of(still)["motion blur"]["why"] == "nothing moves while the shutter is open"


def test_matte_replaces_glossy_and_nothing_else():
    graph = nodes(matte)(ROUGH)
    assert [node.kind for node in graph.nodes] == ["BsdfDiffuse"]
    assert graph.nodes[0].inputs["Color"] == ROUGH.nodes[0].inputs["Color"]
    assert nodes(matte)(make.diffuse(0.3)) == make.diffuse(0.3)
    assert effects_of(room(make.diffuse(0.5)))["glossy bounces"]["why"]


def test_glossy_bounces_and_refraction_are_seen():
    """Two edges: the balls show the sky, and no caustic's noise hides it."""
    for material, name in ((MIRROR, "glossy bounces"), (GLASS, "refraction")):
        row = effects_of(room(material, sky=make.world(0.5)), replace(SETTINGS, max_depth=2))[name]
        assert row["beyond_noise"]
        assert row["difference"] > 0.02


def test_an_opaque_veil_is_what_it_was_mixed_with():
    """Half transparent Lambert of 0.7 becomes Lambert of 0.7."""
    lamp = LightData("POINT", "p", make.translation(0, 0, 2), 10.0)
    veiled = each_material(plain(lamp, material=half_transparent(0.5)), opaque)
    whole = plain(lamp, material=make.diffuse(0.7))
    a, b = (make.rendered(s, 8, samples=4, max_depth=2).image()[..., :3] for s in (veiled, whole))
    np.testing.assert_allclose(a, b, rtol=1e-5)


def test_without_caustics_directly_seen_mirrors_stay_and_diffuse_ones_lose_light():
    """Direct view of the mirror is no caustic; light that it throws on the floor is."""
    scene = prepare(room(MIRROR))
    settings = replace(SETTINGS, samples=256, max_depth=4, sampler="independent")
    one_bounce = replace(settings, max_depth=2)
    np.testing.assert_array_equal(
        render(without_caustics(scene), one_bounce).image(), render(scene, one_bounce).image()
    )
    with_, without = (render(s, settings).image()[..., :3] for s in (scene, without_caustics(scene)))
    assert with_.mean() > without.mean()


def test_caustics_are_taken_out_of_every_moment_of_a_moving_scene():
    """What moves is a camera that gets nowhere: the light is that of the scene which stands still."""
    still = room(MIRROR)
    scene = prepare(moving(still, cameras=(still.camera, still.camera)))
    assert scene.slices is not None
    settings = replace(SETTINGS, samples=64, max_depth=4)
    one, other = (render(without_caustics(s), settings).image() for s in (scene, prepare(still)))
    np.testing.assert_array_equal(one, other)


def test_every_effect_leaves_the_given_snapshot_alone():
    snapshot = room(GLASS, LightData("AREA", "a", np.eye(4), 1.0), make.world(1.0))
    before = (snapshot.materials, snapshot.lights, snapshot.camera, snapshot.world)
    for effect in EFFECTS:
        effect.without(snapshot, SETTINGS)
    assert before == (snapshot.materials, snapshot.lights, snapshot.camera, snapshot.world)
