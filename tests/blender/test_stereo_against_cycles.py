"""Stereoscopic and multi-view renders, pixel by pixel against Cycles.

A box about the camera shines with its own positions, so a pixel tells where its ray ends: with eyes 0.8 m
apart in a box of 4 m an error of a thousandth of the distance between them shows. One sample through each
pixel's centre, as in `test_panorama_against_cycles`.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import shining  # noqa: E402
from support.bpy_scenes import add, cube, empty_scene  # noqa: E402
from support.shared_scenes import read_exr  # noqa: E402

from pt_engine.blender import final, registration  # noqa: E402
from pt_engine.blender.record import Session  # noqa: E402
from pt_engine.scene.prepare import prepare  # noqa: E402

pytestmark = pytest.mark.slow  # physics that no Python changes

SIZE = (31, 22)
EYE = (3.0, -2.0, 1.0)


@pytest.fixture
def scene():
    registration.register()
    scene = empty_scene()
    box = cube(size=4.0)
    box.materials.append(shining("NewGeometry", "Position"))
    add(box, "Box", location=(10, 10, 10))  # all of it at positive coordinates
    scene.camera.location, scene.camera.rotation_euler = (10.3, 10.2, 9.9), (1.2, 0.1, 0.4)
    scene.camera.data.clip_start = 0.05
    stereo = scene.camera.data.stereo
    stereo.interocular_distance, stereo.convergence_distance = 0.8, 2.5
    settings = scene.render
    settings.use_multiview = True
    settings.resolution_x, settings.resolution_y = SIZE
    settings.use_compositing = settings.use_sequencer = False
    form = settings.image_settings
    form.file_format, form.color_mode, form.color_depth = "OPEN_EXR", "RGB", "32"
    form.views_format = "INDIVIDUAL"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling = 1, False
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 0.01  # Cycles' first sample is in the middle; ours are all nearly there
    scene.pt_engine.pixel_filter, scene.pt_engine.filter_width = "GAUSSIAN", 0.01
    scene.pt_engine.samples = 1
    return scene


def views(scene, engine, folder, suffixes):
    """(views, height, width, 3) as Blender writes them."""
    scene.render.engine = engine
    scene.render.filepath = str(folder / f"{engine}.exr")
    bpy.ops.render.render(write_still=True)
    return np.stack([read_exr(folder / f"{engine}{suffix}.exr")[..., :3] for suffix in suffixes])


def check(scene, folder, suffixes=("_L", "_R"), tolerance=2e-3):
    """Positions agree, to some centimetres at most on edges of the box."""
    theirs, ours = (views(scene, engine, folder, suffixes) for engine in ("CYCLES", "PT_ENGINE"))
    far = np.abs(ours - theirs).max(axis=-1)
    assert np.quantile(far, 0.98) < tolerance
    assert np.quantile(np.abs(ours[0] - ours[1]), 0.98) > 5 * tolerance  # the views do differ
    return ours


@pytest.mark.parametrize("mode", ["OFFAXIS", "PARALLEL", "TOE"])
@pytest.mark.parametrize("pivot", ["LEFT", "CENTER"])
def test_eyes_that_stand_still(scene, tmp_path, mode, pivot):
    scene.camera.data.stereo.convergence_mode = mode
    scene.camera.data.stereo.pivot = pivot
    check(scene, tmp_path)


@pytest.mark.parametrize("kind", ["PERSP", "EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT"])
@pytest.mark.parametrize("merge", [False, True])
@pytest.mark.parametrize("mode", ["TOE", "PARALLEL"])
def test_eyes_that_turn_with_the_ray(scene, tmp_path, kind, merge, mode):
    camera = scene.camera.data
    if kind != "PERSP":
        camera.type, camera.panorama_type = "PANO", kind
    camera.stereo.use_spherical_stereo, camera.stereo.convergence_mode = True, mode
    camera.stereo.use_pole_merge = merge
    camera.stereo.pole_merge_angle_from, camera.stereo.pole_merge_angle_to = 0.3, 0.9
    check(scene, tmp_path, tolerance=2e-3 if kind == "PERSP" else 6e-3)  # a panorama's pixels are larger


def test_views_with_cameras_of_their_own(scene, tmp_path, monkeypatch):
    """Both are of one prepared scene."""
    prepared = []
    monkeypatch.setattr(final, "prepare", lambda *given: prepared.append(given) or prepare(*given))
    scene.render.views_format = "MULTIVIEW"
    for name, place in (("eye_L", (9.0, 10.0, 10.0)), ("eye_R", (11.0, 9.0, 10.5))):
        camera = bpy.data.objects.new(name, scene.camera.data)
        camera.location = place
        scene.collection.objects.link(camera)
    scene.camera = bpy.data.objects["eye_L"]
    check(scene, tmp_path)
    assert len(prepared) == 1
    assert list(Session.last.layers) == ["ViewLayer, left", "ViewLayer, right"]


def test_a_custom_camera_is_refused(scene, tmp_path):
    if "CUSTOM" not in bpy.types.Camera.bl_rna.properties["type"].enum_items:
        pytest.skip("this Blender has no custom cameras")
    scene.camera.data.type = "CUSTOM"
    scene.render.engine = "PT_ENGINE"
    with pytest.raises(RuntimeError, match="OSL shader"):
        bpy.ops.render.render()
