"""Lamps in their panels' units, images as they are in the file, random numbers as Cycles has them."""

import io

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_nodes import shining  # noqa: E402
from support.bpy_scenes import add, cube, empty_scene, export  # noqa: E402

from pt_engine.blender.export.images import ImageTable  # noqa: E402
from pt_engine.scene.snapshot import Visibility  # noqa: E402
from pt_engine.scene.snapshot_io import load_snapshot, save_snapshot  # noqa: E402


@pytest.fixture(autouse=True)
def scene():
    return empty_scene()


def lamp(kind, **settings):
    data = bpy.data.lights.new(kind.title(), kind)
    for key, value in settings.items():
        setattr(data, key, value)
    return add(data)


def test_point_light():
    lamp("POINT", energy=50.0, exposure=1.0, color=(1, 0.5, 0.25), shadow_soft_size=0.3).location = (1, 2, 3)
    (light,) = export().lights
    assert (light.kind, light.power, light.color) == ("POINT", 100.0, (1, 0.5, 0.25))
    assert light.radius == pytest.approx(0.3)
    assert light.matrix[:3, 3].tolist() == [1, 2, 3]
    assert light.visibility == Visibility.ALL & ~Visibility.CAMERA
    assert light.normalize
    assert light.cast_shadow


def test_temperature_tints_the_colour():
    owner = lamp("POINT", color=(0.5, 0.5, 0.5), use_temperature=True, temperature=3000.0)
    (light,) = export().lights
    np.testing.assert_allclose(light.color, 0.5 * np.array(owner.data.temperature_color), rtol=1e-6)
    assert light.color[0] > light.color[2]


def test_spot_sun_and_area():
    lamp("SPOT", spot_size=1.0, spot_blend=0.25, use_soft_falloff=True)
    lamp("SUN", energy=3.0, angle=0.2)
    lamp("AREA", shape="RECTANGLE", size=2.0, size_y=0.5, spread=1.5, normalize=False)
    lamp("AREA", shape="DISK", size=2.0, size_y=0.5)
    spot, sun, rectangle, disk = export().lights
    assert (spot.spot_size, spot.spot_blend, spot.soft_falloff) == (1.0, 0.25, True)
    assert (sun.power, sun.angle) == (3.0, pytest.approx(0.2))
    assert (rectangle.shape, rectangle.size, rectangle.spread) == ("RECTANGLE", (2.0, 0.5), 1.5)
    assert not rectangle.normalize
    assert (disk.shape, disk.size) == ("DISK", (2.0, 2.0))


def test_instanced_lamps_are_lamps():
    source = bpy.data.collections.new("Source")
    source.objects.link(bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT")))
    for x in range(3):
        empty = add(None, f"Place {x}", location=(x, 0, 0))
        empty.instance_type, empty.instance_collection = "COLLECTION", source
    assert sorted(light.matrix[0, 3] for light in export().lights) == [0, 1, 2]


def test_a_portal_gives_no_light():
    owner = lamp("AREA")
    owner.data.cycles.is_portal = True
    snapshot = export()
    assert snapshot.lights == ()
    assert not snapshot.unsupported  # it would only guide the sampling


def image_file(path, pixels, kind="PNG"):
    """A file of the given (h, w, 4) pixels, and the image that Blender loads from it."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("Temporary", width, height, alpha=True)
    image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), kind
    image.save()
    bpy.data.images.remove(image)
    return bpy.data.images.load(str(path))


def export_image(image):
    unsupported = []
    table = ImageTable(unsupported)
    assert table.index(image) == table.index(image) == 0
    return table.images[0], unsupported


def test_files_travel_as_their_bytes(tmp_path):
    path = tmp_path / "checker.png"
    image = image_file(path, np.random.default_rng(0).random((4, 5, 4)))
    image.colorspace_settings.name, image.alpha_mode = "Non-Color", "CHANNEL_PACKED"
    data, unsupported = export_image(image)
    assert data.encoded.tobytes() == path.read_bytes()
    assert (data.suffix, data.colorspace, data.alpha_mode) == (".png", "Non-Color", "CHANNEL_PACKED")
    assert unsupported == []


def test_packed_files_need_no_file(tmp_path):
    path = tmp_path / "packed.png"
    image = image_file(path, np.ones((4, 4, 4)))
    content = path.read_bytes()
    image.pack()
    path.unlink()
    data, _ = export_image(image)
    assert data.encoded.tobytes() == content


def test_painted_images_travel_as_pixels():
    image = bpy.data.images.new("Painted", 3, 2, alpha=True)
    pixels = np.random.default_rng(1).integers(0, 256, (2, 3, 4)).astype(np.float32) / 255
    image.pixels.foreach_set(pixels.ravel())
    data, _ = export_image(image)
    np.testing.assert_array_equal(data.pixels, np.rint(pixels * 255))
    assert data.pixels.dtype == np.uint8
    assert (data.encoded, data.colorspace) == (None, "sRGB")


def test_float_images_are_linear_already():
    image = bpy.data.images.new("Float", 2, 2, float_buffer=True)
    image.pixels.foreach_set(np.full(16, 3.5, np.float32))
    data, _ = export_image(image)
    assert data.pixels.max() == 3.5
    assert data.colorspace == "scene_linear"


def test_a_missing_file_says_so(tmp_path):
    image = image_file(tmp_path / "gone.png", np.ones((2, 2, 4)))
    (tmp_path / "gone.png").unlink()
    data, unsupported = export_image(image)
    assert data.encoded is data.pixels is None
    assert "gone.png" in data.problem
    assert unsupported == []  # the nodes that show it say so: nothing is listed twice


def test_tiles_of_a_udim_are_images_of_their_own(tmp_path):
    image = image_file(tmp_path / "tile.1001.png", np.ones((2, 2, 4)))
    image.source, image.filepath = "TILED", str(tmp_path / "tile.<UDIM>.png")
    image.tiles.new(1002)  # of which there is no file
    unsupported = []
    table = ImageTable(unsupported)
    udim = table.images[table.index(image)]
    (first, k), (second, missing) = udim.tiles
    assert (first, second) == (1001, 1002)
    assert table.images[k].encoded.tobytes() == (tmp_path / "tile.1001.png").read_bytes()
    assert "tile.1002.png" in table.images[missing].problem
    assert unsupported == [
        (f"Image {image.name}, tile 1002", table.images[missing].problem, "rendered magenta")
    ]


def test_the_frame_of_a_sequence(scene, tmp_path):
    for frame in (1, 2, 3):
        image_file(tmp_path / f"s{frame:03}.png", np.full((2, 2, 4), frame / 4))
    image = bpy.data.images.load(str(tmp_path / "s001.png"))
    image.source = "SEQUENCE"
    material = bpy.data.materials.new("Film")
    if material.node_tree is None:
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    texture = nodes.new("ShaderNodeTexImage")
    texture.image, texture.image_user.frame_duration, texture.image_user.use_auto_refresh = image, 3, True
    links.new(texture.outputs[0], nodes["Principled BSDF"].inputs[0])
    data = cube()
    data.materials.append(material)
    add(data)
    scene.frame_set(3)
    (exported,) = export().images
    assert exported.encoded.tobytes() == (tmp_path / "s003.png").read_bytes()


def test_random_of_an_object_is_that_of_cycles(scene, tmp_path):
    """Cycles renders Object Info's Random as light; we export the number."""
    data = cube()
    data.materials.append(shining("ObjectInfo", "Random", "Strength"))
    add(data, "Würfel.007")
    scene.camera.location = (0, 0, 3)
    render = scene.render
    render.engine, render.resolution_x, render.resolution_y, scene.cycles.samples = "CYCLES", 4, 4, 1
    render.image_settings.file_format, render.filepath = "OPEN_EXR", str(tmp_path / "random.exr")
    render.image_settings.color_depth, scene.cycles.use_denoising = "32", False
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(render.filepath)
    assert export().instances.random[0] == pytest.approx(image.pixels[0], rel=1e-5)


def test_an_exported_scene_survives_its_file(tmp_path):
    add(cube())
    lamp("AREA")
    snapshot = export()
    first, second = io.BytesIO(), io.BytesIO()
    save_snapshot(snapshot, first)
    first.seek(0)
    save_snapshot(load_snapshot(first), second)
    assert first.getvalue() == second.getvalue()
