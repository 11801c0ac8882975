"""Where images are looked for, and what is said of those that are not there or not all there."""

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")
pytest.importorskip("OpenImageIO")
from support import image_cases, image_files  # noqa: E402
from support.bpy_scenes import empty_scene  # noqa: E402

from pt_engine.blender.export.image_files import sequence_file, tile_path  # noqa: E402
from pt_engine.blender.export.images import ImageTable  # noqa: E402
from pt_engine.textures.images import TextureStore  # noqa: E402


@pytest.fixture(autouse=True)
def scene():
    return empty_scene()


def exported(image):
    """(data, all images, what is listed) of one image."""
    unsupported = []
    table = ImageTable(unsupported)
    return table.images[table.index(image)], table.images, unsupported


def saved_library(folder):
    """A .blend in a folder of its own that holds one image by a relative path."""
    folder.mkdir()
    image_files.write(folder / "wood.png", image_files.pattern(4, 4, 3))
    image = image_cases.loaded(folder / "wood.png")
    image.use_fake_user = True
    path = folder / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), relative_remap=False)
    image.filepath = "//wood.png"
    bpy.ops.wm.save_mainfile()
    return path


def linked(path, folder):
    """The library's image, linked into a new file elsewhere."""
    empty_scene()
    folder.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    with bpy.data.libraries.load(str(path), link=True) as (_, target):
        target.images = ["wood.png"]
    return bpy.data.images["wood.png"]


def test_a_library_s_paths_start_at_the_library(tmp_path):
    path = saved_library(tmp_path / "library")
    data, _, unsupported = exported(linked(path, tmp_path / "scene"))
    assert data.encoded.tobytes() == (tmp_path / "library" / "wood.png").read_bytes()
    assert unsupported == []


def test_an_image_of_a_lost_library_is_named(tmp_path):
    path = saved_library(tmp_path / "library")
    image = linked(path, tmp_path / "scene")
    image.use_fake_user = True
    texture = bpy.data.textures.new("user", "IMAGE")
    texture.image, texture.use_fake_user = image, True
    bpy.ops.wm.save_mainfile()
    path.rename(tmp_path / "library" / "moved.blend")
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene" / "scene.blend"))
    ((where, what, effect),) = exported(bpy.data.images["wood.png"])[2]
    assert where == "Image wood.png"
    assert what == "not in its library"
    assert "placeholder" in effect
    assert "library.blend" in effect


def test_files_are_read_anew_for_each_export(tmp_path):
    path = image_files.write(tmp_path / "a.png", image_files.pattern(4, 4, 3))
    image = image_cases.loaded(path)
    assert image.size[0] == 4
    image_files.write(path, image_files.pattern(8, 6, 3, seed=1))
    data, images, _ = exported(image)
    texture = TextureStore(images).texture(0, "Linear", "REPEAT", False)
    assert data.encoded.tobytes() == path.read_bytes()
    assert (texture.grid.texels.width, texture.grid.texels.height) == (6, 8)


def test_tiles_that_are_not_exact_are_named(tmp_path):
    deep = image_files.write(tmp_path / "deep.1001.png", image_files.pattern(4, 4, 4), "uint16")
    image = image_cases.loaded(deep)
    image.source, image.filepath = "TILED", str(tmp_path / "deep.<UDIM>.png")
    image.pack()
    _, _, unsupported = exported(image)
    assert [effect for _, _, effect in unsupported] == ["alpha and filter as if it were not packed"]
    grid = bpy.data.images.new("Grid", 8, 8, tiled=True)
    with bpy.context.temp_override(edit_image=grid):
        bpy.ops.image.tile_fill(width=8, height=8, generated_type="UV_GRID")
    _, _, unsupported = exported(grid)
    assert [what for _, what, _ in unsupported] == ["a generated pattern"]


@pytest.mark.parametrize(
    ("path", "number", "expected"),
    [
        ("//film.0001.png", 12, "//film.0012.png"),
        ("/a1/shot2_v3.exr", 10, "/a1/shot2_v10.exr"),
        ("C:\\film\\x099y.png", 100, "C:\\film\\x100y.png"),
        ("/a/none.png", 5, "/a/none5.png"),
        ("/a/007", 8, "/a/008"),
    ],
)
def test_the_last_digits_of_the_name_are_the_frame(path, number, expected):
    assert sequence_file(path, number) == expected


def test_tokens_of_tiles():
    image = bpy.data.images.new("T", 1, 1, tiled=True)
    image.filepath = "/a/t_<UVTILE>_<UDIM>.png"
    assert tile_path(image, 1023) == "/a/t_u3_v3_1023.png"


def test_pixels_of_bytes_stay_bytes():
    image = bpy.data.images.new("P", 3, 2, alpha=True)
    image.pixels.foreach_set(np.full(24, 0.5, np.float32))
    data, _, _ = exported(image)
    assert data.pixels.dtype == np.uint8
    assert (data.pixels == 128).all()
