"""Settings, panels and pictures: the engine's parts that need no render."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from support.engine_scene import engine_scene

from pt_engine.blender import (
    compatibility,
    cycles_panels,
    light_group_panels,
    motion_panels,
    panels,
    panorama_panel,
    registration,
)
from pt_engine.blender.export.panorama import EDGES
from pt_engine.blender.picture import Picture
from pt_engine.blender.properties import integrator_number
from pt_engine.blender.refusal import Refusal
from pt_engine.blender.settings import settings_of
from pt_engine.blender.words import count, coverage_lines, doubts, duration, estimated_error, shortened
from pt_engine.nodes.coverage import Coverage
from pt_engine.render.integrator import INTEGRATORS


@pytest.fixture
def scene():
    return engine_scene()


def test_settings_follow_the_scene(scene):
    scene.pt_engine.samples = 7
    scene.pt_engine.seed = 3
    scene.render.film_transparent = True
    settings = settings_of(scene, 64, 48)
    assert (settings.width, settings.height, settings.border) == (64, 48, None)
    assert (settings.samples, settings.seed, settings.threads) == (7, 3, 1)
    assert settings.film_transparent
    scene.render.threads_mode = "AUTO"
    assert settings_of(scene, 64, 48).threads == 0


@pytest.mark.parametrize(
    ("kind", "width", "expected"),
    [
        ("BLACKMAN_HARRIS", 2.0, ("BLACKMAN_HARRIS", 2.0)),
        ("GAUSSIAN", 2.5, ("GAUSSIAN", 2.5)),
        ("BOX", 2.5, ("BOX", 1.0)),  # as in Cycles, a box is always one pixel wide
    ],
)
def test_the_pixel_filter_is_the_files_own(scene, kind, width, expected):
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = kind, width
    settings = settings_of(scene, 64, 48)
    assert (settings.pixel_filter, settings.filter_width) == expected
    scene.pt_engine.pixel_filter, scene.pt_engine.filter_width = "GAUSSIAN", 3.0
    settings = settings_of(scene, 64, 48)
    assert (settings.pixel_filter, settings.filter_width) == ("GAUSSIAN", 3.0)


def test_a_region_smaller_than_a_pixel_is_refused(scene):
    render = scene.render
    render.use_border = True
    render.border_min_x, render.border_max_x = 0.5, 0.501
    with pytest.raises(Refusal, match="smaller than a pixel"):
        settings_of(scene, 64, 48)


def test_the_ladder_is_in_the_menu_and_the_default_is_path(scene):
    assert {"normals", "direct_bsdf", "direct_emitter", "direct_mis", "path"} <= set(INTEGRATORS)
    assert scene.pt_engine.integrator == "path"
    for name in INTEGRATORS:
        scene.pt_engine.integrator = name
        assert scene.pt_engine.integrator == name
    numbers = [integrator_number(name) for name in INTEGRATORS]
    assert len(set(numbers)) == len(numbers)


def test_a_file_remembers_its_integrator_whatever_else_is_registered(scene, tmp_path, monkeypatch):
    """A .blend stores a number, not a name: it must not depend on the order of the registry."""
    scene.pt_engine.integrator = "direct_mis"
    path = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    before = dict(INTEGRATORS)
    monkeypatch.setattr("pt_engine.blender.properties.INTEGRATORS", dict(reversed(before.items())))
    bpy.ops.wm.open_mainfile(filepath=path)
    assert bpy.context.scene.pt_engine.integrator == "direct_mis"


def test_an_integrator_that_is_not_here_is_named_as_the_cause(scene, monkeypatch):
    scene.pt_engine.integrator = "direct_mis"
    fewer = {name: cls for name, cls in INTEGRATORS.items() if name != "direct_mis"}
    monkeypatch.setattr("pt_engine.blender.properties.INTEGRATORS", fewer)
    monkeypatch.setattr("pt_engine.blender.settings.INTEGRATORS", fewer)
    with pytest.raises(Refusal, match="not known here"):
        settings_of(scene, 64, 48)


def test_every_property_says_what_it_does(scene):
    for prop in scene.pt_engine.bl_rna.properties:
        if prop.identifier not in ("rna_type", "name"):
            assert len(prop.description) > 10, prop.identifier


def test_the_panel_shows_the_target_error_in_per_cent_of_what_is_stored(scene):
    own = scene.pt_engine
    own.target_error = 0.025
    assert own.target_percent == pytest.approx(2.5)
    own.target_percent = 1.5
    assert own.target_error == pytest.approx(0.015)
    assert settings_of(scene, 64, 48).target_error == pytest.approx(0.015)


def test_the_override_panel_has_nothing_that_is_not_rendered():
    """Samples of a view layer are Cycles'; material and world are replaced here, too."""
    shown = {panel.__name__ for panel in compatibility.panels()}
    assert "VIEWLAYER_PT_override" not in shown
    own = next(row for row in cycles_panels.PANELS if row[1] == "override")
    assert [path.rpartition(".")[2] for path in own[3]] == ["material_override", "world_override"]


def test_every_panel_property_exists(scene):
    for _, _, _, rows in panels.PROPERTY_PANELS:
        for owner, prop in rows:
            assert hasattr(getattr(scene, owner), prop), (owner, prop)


def test_every_panorama_has_its_lens_in_the_panel(scene):
    """The projections that are rendered, and no property that Blender does not have."""
    camera = scene.camera.data
    known = {e.identifier for e in camera.bl_rna.properties["panorama_type"].enum_items}
    assert set(panorama_panel.LENSES) <= known & set(EDGES)
    assert all(hasattr(camera, name) for lens in panorama_panel.LENSES.values() for name in lens)


def test_every_setting_kept_with_cycles_exists(scene):
    """Of an object, a world, a material and a view layer."""
    context = SimpleNamespace(
        object=scene.camera,
        world=bpy.data.worlds.new("World"),
        material=bpy.data.materials.new("Material"),
        view_layer=scene.view_layers[0],
    )
    for _, _, _, settings in cycles_panels.PANELS:
        for path in settings:
            assert cycles_panels.owner_of(context, path)[0] is not None, path
    assert cycles_panels.owner_of(SimpleNamespace(object=None), "object.cycles.motion_steps")[0] is None


def test_every_class_has_a_name_of_its_own():
    """Blender forgets the first of two."""
    names = [made.__name__ for part in registration.PARTS for made in getattr(part, "CLASSES", ())]
    assert len(set(names)) == len(names)


def test_blenders_own_panels_come_and_go_with_the_engine(scene):
    def shown():
        return {
            panel.__name__
            for panel in bpy.types.Panel.__subclasses__()
            if compatibility.ENGINE in getattr(panel, "COMPAT_ENGINES", ())
            and not panel.__name__.startswith("PTENGINE")
        }

    assert set(compatibility.OF_EEVEE) <= shown()
    assert {"RENDER_PT_format", "RENDER_PT_output", "DATA_PT_camera", "DATA_PT_spot"} <= shown()
    assert "CYCLES_RENDER_PT_sampling" not in shown()
    registration.unregister()
    assert not shown()
    assert not hasattr(bpy.types.Scene, "pt_engine")
    registration.register()
    assert set(compatibility.OF_EEVEE) <= shown()


class FakeEngine:
    """Counts what a picture asks of Blender."""

    def __init__(self):
        self.updates = 0
        self.ended = None

    def begin_result(self, x, y, width, height, layer="", view=""):
        engine = self

        class Rect:
            def foreach_set(self, values):
                engine.values = values

        combined = type("Pass", (), {"name": "Combined", "rect": Rect()})()
        return type("Result", (), {"layers": [type("Layer", (), {"passes": [combined]})()]})()

    def update_result(self, result):
        self.updates += 1

    def end_result(self, result, cancel=False):
        self.ended = cancel


class FakeProgress:
    def __init__(self, elapsed, samples=1):
        self.elapsed, self.samples = elapsed, samples

    def image(self):
        return np.zeros((2, 3, 4), np.float32)


def test_a_watched_picture_is_shown_at_once_then_at_growing_intervals():
    engine = FakeEngine()
    with Picture(engine, "Layer", (3, 2)) as picture:
        picture.watched = True
        picture.show_progress(FakeProgress(0.01, samples=0))
        assert engine.updates == 0  # the first pass is not complete
        for millisecond in range(20, 60_000, 20):
            picture.show_progress(FakeProgress(millisecond / 1000))
            if millisecond == 20:
                assert engine.updates == 1
    assert 8 < engine.updates < 20
    assert engine.values.shape == (24,)
    assert engine.ended is False


def test_a_picture_is_ended_even_when_the_render_fails():
    engine = FakeEngine()
    with pytest.raises(ValueError, match="x"), Picture(engine, "Layer", (3, 2)):
        raise ValueError("x")
    assert engine.ended is True


def test_findings_are_told_once_for_all_their_materials():
    coverage = [Coverage(f"M{n}", f"Group/Hair {n % 2}", "ignored", "looks flat") for n in range(8)]
    coverage.append(Coverage("M0", "Diffuse", "exact"))
    lines = coverage_lines(coverage)
    assert lines == [
        "M0, M2, M4 and 1 more: Hair 0 ignored: looks flat",
        "M1, M3, M5 and 1 more: Hair 1 ignored: looks flat",
    ]
    assert shortened(["a", "b", "c"], 2) == ["a", "b", "and 1 more"]


def test_words():
    assert [duration(s) for s in (3.21, 247, 3753, float("inf"))] == ["3.2 s", "4:07", "1:02:33", "?"]
    assert [count(n) for n in (12, 1234, 2.5e6, 3e9)] == ["12", "1.23 k", "2.5 M", "3 G"]
    assert estimated_error({"relmse": 0.01, "relmse_ci95": [0.0081, 0.0121]}).startswith(
        "10.00% relative RMS"
    )
    assert estimated_error({"relmse": None}) == ""
    assert doubts({"fireflies": 1.05}) == doubts({"fireflies": None}) == doubts(None) == []
    assert doubts({"fireflies": 3.76})[0].endswith("uncertain by 3.8 ×")


@pytest.mark.parametrize("part", [light_group_panels, motion_panels], ids=["light groups", "motion blur"])
def test_panels_draw_what_blender_has(scene, part):
    """Every property and operator that they show exists: drawn onto a layout that looks them up."""
    context = SimpleNamespace(
        scene=scene, engine="PT_ENGINE", view_layer=bpy.context.view_layer, world=scene.world,
        object=bpy.data.objects["Cube"],
    )  # fmt: skip
    for panel in part.CLASSES:
        assert panel.poll(context)
        panel.draw(SimpleNamespace(layout=Layout(), owner=getattr(panel, "owner", None)), context)


class Layout:
    """Stands in for Blender's; what it is asked to show must be there."""

    def row(self, **_):
        return self

    column = row

    def separator(self):
        pass

    def prop(self, owner, name, **_):
        assert hasattr(owner, name), name

    def prop_search(self, owner, name, source, names, **_):
        assert hasattr(owner, name), name
        assert hasattr(source, names), names

    def template_list(self, kind, identifier, owner, name, active_owner, active, **_):
        assert hasattr(owner, name), name
        assert hasattr(active_owner, active), active

    def template_curve_mapping(self, owner, name):
        assert hasattr(owner, name), name

    def operator(self, name, **_):
        module, call = name.split(".")
        known = getattr(getattr(bpy.ops, module), call).get_rna_type()  # a KeyError where there is none
        return SimpleNamespace(**dict.fromkeys(known.properties.keys()))

    def menu(self, name, **_):
        assert hasattr(bpy.types, name), name
