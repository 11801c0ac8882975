"""Adaptive subdivision: the export dices what the modifier marks, as finely as the camera sees."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, empty_scene, export, mesh  # noqa: E402

from pt_engine.blender.export import dicing  # noqa: E402

BLENDER_5 = bpy.app.version >= (5, 0, 0)
of_modifier = pytest.mark.skipif(not BLENDER_5, reason="the modifier has the settings since Blender 5")


@pytest.fixture(name="modifier")
def _modifier():
    """A square of edge 2, subdivided, under a parallel camera of 40 pixels for 4 metres: 0.1 m each."""
    scene = empty_scene()
    camera = scene.camera
    camera.data.type, camera.data.ortho_scale = "ORTHO", 4
    camera.location = (0, 0, 5)
    scene.render.resolution_x = scene.render.resolution_y = 40
    scene.render.resolution_percentage = 100
    square = mesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)])
    owner = add(square, "Square", scale=(2, 2, 1))
    modifier = owner.modifiers.new("Subdivision", "SUBSURF")
    modifier.subdivision_type, modifier.levels = "SIMPLE", 1
    if BLENDER_5:
        modifier.use_adaptive_subdivision = True
    else:
        owner.cycles.use_adaptive_subdivision, scene.cycles.feature_set = True, "EXPERIMENTAL"
    scene.cycles.preview_dicing_rate = 2.0
    return modifier


def cells(snapshot):
    """Length of the longest leg of any triangle, in the object."""
    p = snapshot.meshes[0].vertices[snapshot.meshes[0].triangles].astype(float)
    return np.sort(np.linalg.norm(np.roll(p, -1, axis=1) - p, axis=2), axis=1)[:, 1].max()


def test_cells_are_as_wide_as_the_rate_in_pixels(modifier):
    """2 pixels of 0.1 m are 0.1 in an object of scale 2; halving by √½ ends above 1/√2 of it."""
    if BLENDER_5:
        modifier.adaptive_space, modifier.adaptive_pixel_size = "PIXEL", 1.0
    assert 0.1 / np.sqrt(2) < cells(export()) <= 0.1 + 1e-6


@of_modifier
def test_cells_are_as_long_as_the_object_says(modifier):
    """An edge length in the object's space, times the scene's rate of 2."""
    modifier.adaptive_space, modifier.adaptive_object_edge_length = "OBJECT", 0.15
    assert 0.3 / np.sqrt(2) < cells(export()) <= 0.3 + 1e-6


@pytest.mark.parametrize(
    "off", [pytest.param("use_adaptive_subdivision", marks=of_modifier), "show_viewport"]
)
def test_without_the_switch_nothing_is_diced(modifier, off):
    setattr(modifier, off, False)
    assert len(export().meshes[0].triangles) == (8 if off == "use_adaptive_subdivision" else 2)


@pytest.mark.skipif(BLENDER_5, reason="Blender 5 has the switch on the modifier")
@pytest.mark.parametrize(("switch", "features"), [(False, "EXPERIMENTAL"), (True, "SUPPORTED")])
def test_without_the_object_s_switch_or_the_scene_s_nothing_is_diced(modifier, switch, features):
    modifier.id_data.cycles.use_adaptive_subdivision = switch
    bpy.context.scene.cycles.feature_set = features
    assert len(export().meshes[0].triangles) == 8


def test_what_memory_does_not_hold_is_diced_coarser_and_named(modifier, monkeypatch):
    monkeypatch.setattr(dicing, "MAX_TRIANGLES", 100)
    snapshot = export()
    assert len(snapshot.meshes[0].triangles) <= 100
    assert any(
        what == "adaptive subdivision" and "coarse" in effect for _, what, effect in snapshot.unsupported
    )
