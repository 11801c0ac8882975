"""The camera's frame projects every point to where Blender's own projection has it."""

import itertools
import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from bpy_extras.object_utils import world_to_camera_view  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402
from support.bpy_scenes import add, empty_scene, export  # noqa: E402

from pt_engine.blender.export import ExportError  # noqa: E402
from pt_engine.blender.export.panorama import EDGES  # noqa: E402
from pt_engine.cameras.panoramic import PROJECTIONS  # noqa: E402

POINTS = np.random.default_rng(1).uniform(-3, 3, (40, 3))
CASES = list(
    itertools.product(("AUTO", "HORIZONTAL", "VERTICAL"), ((320, 200), (200, 320)), ("PERSP", "ORTHO"))
)


def projected(camera, point):
    """Image coordinates in [0, 1]² by our frame, and the depth along the view axis."""
    x, y, z = np.linalg.solve(camera.matrix, [*point, 1.0])[:3]
    left, right, bottom, top = camera.frame
    if camera.kind == "PERSP":
        x, y = x / -z, y / -z
    return (x - left) / (right - left), (y - bottom) / (top - bottom), -z


@pytest.fixture
def scene():
    scene = empty_scene()
    scene.camera.matrix_world = (
        Matrix.Translation((1, -9, 2)) @ Matrix.Rotation(1.3, 4, "X") @ Matrix.Rotation(0.2, 4, "Y")
    )
    return scene


@pytest.mark.parametrize(("fit", "size", "kind"), CASES)
def test_frame_projects_as_blender_does(scene, fit, size, kind):
    camera = scene.camera.data
    camera.type, camera.sensor_fit, camera.lens = kind, fit, 37.0
    camera.sensor_width, camera.sensor_height, camera.ortho_scale = 30.0, 21.0, 5.0
    camera.shift_x, camera.shift_y = 0.13, -0.21
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = 1.0, 1.7
    exported = export().camera
    for point in POINTS:
        expected = world_to_camera_view(scene, scene.camera, Vector(point))
        np.testing.assert_allclose(projected(exported, point), expected, rtol=2e-5, atol=2e-5)


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_frame_is_that_of_blenders_projection_matrix(scene, kind):
    camera = scene.camera.data
    camera.type, camera.shift_x = kind, 0.1
    scene.render.resolution_x, scene.render.resolution_y = 300, 170
    left, right, bottom, top = export().camera.frame
    matrix = scene.camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=300, y=170)
    width, height = 2 / matrix[0][0], 2 / matrix[1][1]
    offset = (matrix[0][2], matrix[1][2]) if kind == "PERSP" else (-matrix[0][3], -matrix[1][3])
    assert (right - left, top - bottom) == pytest.approx((width, height), rel=1e-5)
    assert (right + left, top + bottom) == pytest.approx((offset[0] * width, offset[1] * height), abs=1e-5)


def test_percentage_rounds_the_size_down(scene):
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 101, 51, 50
    left, right, bottom, top = export().camera.frame
    assert (right - left) / (top - bottom) == pytest.approx(50 / 25)


def test_size_replaces_the_render_settings(scene):
    left, right, bottom, top = export(size=(40, 10)).camera.frame
    assert (right - left) / (top - bottom) == pytest.approx(4)


def test_scale_of_the_camera_object_does_not_count(scene):
    before = export().camera
    scene.camera.matrix_world = scene.camera.matrix_world @ Matrix.Diagonal((3, 0.5, 2, 1))
    after = export().camera
    np.testing.assert_allclose(after.matrix, before.matrix, atol=1e-6)
    assert after.frame == before.frame


def test_aperture_is_half_the_lens_over_the_f_stop(scene):
    dof = scene.camera.data.dof
    assert export().camera.aperture_radius == 0.0
    dof.use_dof, dof.aperture_fstop, dof.focus_distance = True, 2.8, 4.0
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 6, 0.3, 2.0
    camera = export().camera
    assert camera.aperture_radius == pytest.approx(0.050 / (2 * 2.8), rel=1e-6)
    assert camera.focus_distance == 4.0
    assert (camera.blades, camera.blade_rotation, camera.aperture_ratio) == (6, pytest.approx(0.3), 2.0)
    scene.camera.data.type = "ORTHO"
    assert export().camera.aperture_radius == pytest.approx(1 / (2 * 2.8), rel=1e-6)


def test_focus_object_is_measured_along_the_view_axis(scene):
    target = add(None, "Target", location=(3, 5, -1))
    scene.camera.data.dof.use_dof, scene.camera.data.dof.focus_object = True, target
    matrix = np.array(scene.camera.matrix_world)
    expected = abs(matrix[:3, 2] @ (matrix[:3, 3] - (3, 5, -1)))
    assert export().camera.focus_distance == pytest.approx(expected, rel=1e-5)


def test_panorama_has_the_frame_of_its_projection(scene):
    """Sensor 30 mm on 10 mm focal length, moved by a tenth of the width; see the tests of cameras/."""
    camera = scene.camera.data
    camera.type, camera.panorama_type = "PANO", "FISHEYE_EQUISOLID"
    camera.fisheye_fov, camera.fisheye_lens, camera.sensor_width, camera.shift_x = 2.0, 10.0, 30.0, 0.1
    scene.render.resolution_x, scene.render.resolution_y = 300, 100
    snapshot = export()
    assert (snapshot.camera.kind, snapshot.camera.panorama) == ("PANO", "FISHEYE_EQUISOLID")
    assert snapshot.camera.fisheye_fov == 2.0
    assert snapshot.camera.frame == pytest.approx((-1.2, 1.8, -0.5, 0.5), rel=1e-6)
    assert not snapshot.unsupported


def test_every_projection_of_blender_is_known(scene):
    camera = scene.camera.data
    camera.type = "PANO"
    for item in camera.bl_rna.properties["panorama_type"].enum_items:
        camera.panorama_type = item.identifier
        snapshot = export()
        assert snapshot.camera.panorama == item.identifier in PROJECTIONS
        assert not snapshot.unsupported


def test_a_projection_of_a_newer_blender_is_named(scene, monkeypatch):
    scene.camera.data.type, scene.camera.data.panorama_type = "PANO", "MIRRORBALL"
    monkeypatch.delitem(EDGES, "MIRRORBALL")
    snapshot = export()
    assert snapshot.camera.panorama == "EQUIRECTANGULAR"
    assert any("MIRRORBALL" in what for _, what, _ in snapshot.unsupported)


def test_without_camera_there_is_a_clear_error(scene):
    scene.camera = None
    with pytest.raises(ExportError, match="has no camera"):
        export()


def test_field_of_view_is_the_panels(scene):
    scene.render.resolution_x, scene.render.resolution_y = 64, 64
    scene.camera.data.angle = math.radians(80)
    assert export().camera.frame[1] == pytest.approx(math.tan(math.radians(40)), rel=1e-5)
