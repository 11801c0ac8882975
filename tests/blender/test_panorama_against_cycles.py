"""Panoramic cameras, pixel by pixel against Cycles.

The world shines with the direction of the ray and a box about the camera with its position, so every pixel
tells its ray's direction. Near and far clip parts of the box's faces and corners away, which shows how
far rays are followed. Cycles' first sample goes through the pixel's centre; so do our rays here.
"""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from mathutils import Vector  # noqa: E402
from support.bpy_scenes import add, cube, empty_scene, export  # noqa: E402
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.shared_scenes import read_exr  # noqa: E402
from support.ztest import compare  # noqa: E402

from pt_engine.scene.geometry import SKY  # noqa: E402
from pt_engine.scene.prepare import prepare  # noqa: E402
from pt_engine.scene.wave import Rays  # noqa: E402

pytestmark = pytest.mark.slow  # physics that no Python changes

SIZE = (31, 22)
FIRST = 0.5 + 0.5 / 1022  # its filter table has 1024 entries, the 512th for the middle
EYE = (3.0, -2.0, 1.0)
EDGES = 2  # pixels on the border of the box or the image circle, which rounding may decide


def emission_of(tree, kind, output, shader, end):
    """The vector `output` of a node, times 0.1 plus 0.5, shines."""
    source, scaled = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeVectorMath")
    scaled.operation = "MULTIPLY_ADD"
    scaled.inputs[1].default_value, scaled.inputs[2].default_value = (0.1,) * 3, (0.5,) * 3
    shine, out = tree.nodes.new("ShaderNode" + shader), tree.nodes.new("ShaderNode" + end)
    tree.links.new(source.outputs[output], scaled.inputs[0])
    tree.links.new(scaled.outputs[0], shine.inputs["Color"])
    tree.links.new(shine.outputs[0], out.inputs["Surface"])


@pytest.fixture
def scene():
    scene = empty_scene()
    made, sky = bpy.data.materials.new("Position"), bpy.data.worlds.new("Direction")
    for owner in (made, sky):
        if owner.node_tree is None:
            owner.use_nodes = True
        owner.node_tree.nodes.clear()
    emission_of(made.node_tree, "NewGeometry", "Position", "Emission", "OutputMaterial")
    emission_of(sky.node_tree, "TexCoord", "Generated", "Background", "OutputWorld")
    scene.world = sky
    box = cube(size=2.0)
    box.materials.append(made)
    add(box, "Box", location=EYE)
    scene.camera.location, scene.camera.rotation_euler = EYE, (1.1, 0.3, -0.6)
    camera = scene.camera.data
    camera.type, camera.clip_start, camera.clip_end = "PANO", 1.2, 1.5
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    scene.render.pixel_aspect_y = 1.3
    return scene


def ours(scene):
    """(height, width, 3) what our rays through the pixels' centres find, top row first."""
    made = prepare(export(size=SIZE))
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]]
    raster = (np.stack([x.ravel(), y.ravel()]) + FIRST).astype(np.float32)
    rays = Rays(*made.camera.at_resolution(*SIZE).rays(raster))
    found = made.intersect(rays)
    position = rays.o + made.origin32 + np.minimum(found.hits.t, 100) * rays.d
    colour = np.where(found.surface == SKY, rays.d, position) * 0.1 + 0.5
    return (colour * (rays.tfar > 0)).T.reshape(SIZE[1], SIZE[0], 3)[::-1]


def cycles(scene, folder):
    """(height, width, 3) Cycles' picture of one sample per pixel, top row first."""
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    form = scene.render.image_settings
    form.file_format, form.color_mode, form.color_depth = "OPEN_EXR", "RGB", "32"
    scene.render.filepath = str(folder / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    return read_exr(scene.render.filepath)[..., :3]


def colours(pair):
    """Both images without alpha."""
    return pair[0][..., :3], pair[1][..., :3]


FIT = {"sensor_width": 30.0, "sensor_height": 20.0, "shift_x": 0.1, "shift_y": -0.05}
CASES = {
    "equirectangular": {"panorama_type": "EQUIRECTANGULAR"},
    "equirectangular part": {
        "panorama_type": "EQUIRECTANGULAR",
        "longitude_min": -2.0,
        "longitude_max": 2.5,
        "latitude_min": -0.5,
        "latitude_max": 1.2,
        "shift_x": 0.1,
        "shift_y": 0.05,
    },
    "cube face": {"panorama_type": "EQUIANGULAR_CUBEMAP_FACE", "shift_x": 0.1},
    "mirror ball": {"panorama_type": "MIRRORBALL"},
    "mirror ball shifted": {"panorama_type": "MIRRORBALL", "shift_x": 0.1, "shift_y": -0.2},
    "equidistant": {"panorama_type": "FISHEYE_EQUIDISTANT", "fisheye_fov": 3.0},
    "equidistant twice round": {"panorama_type": "FISHEYE_EQUIDISTANT", "fisheye_fov": 9.0, **FIT},
    "equisolid": {"panorama_type": "FISHEYE_EQUISOLID"},
    "equisolid all around": {
        "panorama_type": "FISHEYE_EQUISOLID",
        "fisheye_lens": 9.0,
        "fisheye_fov": 2 * np.pi,
    },
    "equisolid past all around": {
        "panorama_type": "FISHEYE_EQUISOLID",
        "fisheye_lens": 9.0,
        "fisheye_fov": 9.0,
    },
    **{
        f"equisolid {fit}": {"panorama_type": "FISHEYE_EQUISOLID", "sensor_fit": fit, **FIT}
        for fit in ("AUTO", "HORIZONTAL", "VERTICAL")
    },
    "polynomial": {"panorama_type": "FISHEYE_LENS_POLYNOMIAL"},
    "polynomial crooked": {
        "panorama_type": "FISHEYE_LENS_POLYNOMIAL",
        "sensor_fit": "VERTICAL",
        "fisheye_fov": 2.0,
        "fisheye_polynomial_k0": 0.1,
        "fisheye_polynomial_k1": -0.12,
        "fisheye_polynomial_k2": 0.002,
        "fisheye_polynomial_k3": -1e-4,
        "fisheye_polynomial_k4": 2e-6,
        **FIT,
    },
    "cylinder": {"panorama_type": "CENTRAL_CYLINDRICAL"},
    "cylinder part": {
        "panorama_type": "CENTRAL_CYLINDRICAL",
        "central_cylindrical_range_u_min": -1.0,
        "central_cylindrical_range_u_max": 2.0,
        "central_cylindrical_range_v_min": -0.6,
        "central_cylindrical_range_v_max": 1.8,
        "central_cylindrical_radius": 1.5,
        "shift_y": 0.1,
    },
}


def set_camera(scene, settings):
    for key, value in settings.items():
        setattr(scene.camera.data, key, value)


@pytest.mark.parametrize("name", CASES)
def test_each_pixel_looks_where_cycles_looks(scene, name, tmp_path):
    set_camera(scene, CASES[name])
    theirs = cycles(scene, tmp_path)
    difference = np.abs(ours(scene) - theirs).max(axis=-1)
    wrong = np.argwhere(difference > 3e-6)
    assert len(wrong) <= EDGES, f"{len(wrong)} pixels differ, by up to {difference.max()}, so {wrong[:5]}"
    assert np.ptp(theirs[..., 0]) > 0.1


def test_outside_of_the_circle_the_film_is_black_and_opaque(scene, tmp_path):
    """Even a transparent film; its exposure multiplies colours, never alpha."""
    set_camera(scene, {"panorama_type": "FISHEYE_EQUIDISTANT", "fisheye_fov": 4.0})
    scene.render.film_transparent, scene.cycles.film_exposure = True, 1.7
    theirs, mine = by_cycles(64, SIZE, tmp_path), by_engine(64, SIZE)
    for image in (theirs[0], mine[0]):
        np.testing.assert_array_equal(image[:3, :3], np.broadcast_to([0, 0, 0, 1], (3, 3, 4)))
        assert {0.0, 1.0} <= set(np.unique(image[..., 3]))
    found = compare(colours(mine), colours(theirs), grid=(8, 6))
    assert found.agrees(0.01), str(found)


NARROW = {
    "clip_start": 0.01,
    "clip_end": 100.0,
    "longitude_min": -1.2,
    "longitude_max": 1.2,
    "latitude_min": -0.9,
    "latitude_max": 0.9,
}


@pytest.mark.parametrize("kind", ["EQUIRECTANGULAR", "FISHEYE_EQUIDISTANT", "MIRRORBALL"])
def test_blur_is_that_of_cycles(scene, kind, tmp_path):
    """A small box out of focus shows the aperture: three blades, turned and squeezed: no two sides alike."""
    camera = scene.camera
    camera.location = Vector(EYE) - camera.rotation_euler.to_matrix() @ Vector((0.6, 0.5, -1.2))
    bpy.data.objects["Box"].scale = (0.15, 0.15, 0.15)
    scene.world = None
    set_camera(scene, {"panorama_type": kind, "fisheye_fov": 2.4, **NARROW})
    dof = camera.data.dof
    dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 8.0, 0.04
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 3, 0.4, 1.5
    size, samples = (48, 36), 1024
    mine, theirs = by_engine(samples, size), by_cycles(samples, size, tmp_path)
    found = compare(colours(mine), colours(theirs), grid=(24, 18))
    assert found.agrees(0.02), str(found)
    assert found.noise < 0.15  # else nothing could differ
