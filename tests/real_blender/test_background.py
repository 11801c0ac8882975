"""The extension in a real Blender without a window: installed from its zip, enabled, rendering."""

import json
import zipfile

import numpy as np
import pytest
from support.exr import layers, pixels

MODULE = "bl_ext.user_default.pt_engine"


def test_the_zip_is_valid_and_holds_the_engine_alone(blender):
    assert blender("--command", "extension", "validate", blender.zip).returncode == 0
    names = zipfile.ZipFile(blender.zip).namelist()
    assert {name.split("/")[0] for name in names} == {
        "__init__.py", "LICENSE", "blender_manifest.toml", "pt_engine", "wheels",
    }  # fmt: skip
    assert not [name for name in names if "__pycache__" in name or name.endswith(".pyc")]


def test_it_can_be_disabled_and_enabled_again(blender):
    done = blender.python(
        "import bpy, addon_utils\n"
        f"assert {MODULE!r} in bpy.context.preferences.addons\n"
        f"addon_utils.disable({MODULE!r})\n"
        "assert not hasattr(bpy.context.scene, 'pt_engine')\n"
        f"assert addon_utils.enable({MODULE!r})\n"
        "bpy.context.scene.render.engine = 'PT_ENGINE'\n"
        "assert bpy.context.scene.pt_engine.integrator == 'path'\n"
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_one_frame_from_the_command_line(blender, blend):
    done = blender("-b", blend, "-E", "PT_ENGINE", "-o", "//out_", "-F", "OPEN_EXR", "-f", "1")
    assert done.returncode == 0, done.stdout + done.stderr
    image = pixels(blend.parent / "out_0001.exr")
    assert image.shape[:2] == (64, 96)
    assert np.isfinite(image).all()
    assert image[..., :3].max() > 2 * image[0, 0, :3].max() > 0


def test_an_animation(blender, blend):
    done = blender("-b", blend, "-E", "PT_ENGINE", "-o", "//a_", "-F", "OPEN_EXR", "-a")
    assert done.returncode == 0, done.stdout + done.stderr
    first, second = (pixels(blend.parent / f"a_000{frame}.exr") for frame in (1, 2))
    assert abs(first - second).max() > 0.1
    assert not (blend.parent / "a_0003.exr").exists()


def test_a_multi_layer_file_has_every_view_layer(blender, blend):
    code = (
        "import bpy\n"
        "scene = bpy.context.scene\n"
        "scene.view_layers.new('Second')\n"
        "scene.render.image_settings.media_type = 'MULTI_LAYER_IMAGE'\n"
        "scene.render.filepath = '//layers.exr'\n"
        "bpy.ops.render.render(write_still=True)\n"
    )
    done = blender.python(code, blend)
    assert done.returncode == 0, done.stdout + done.stderr
    found = layers(blend.parent / "layers.exr")
    assert set(found) == {"ViewLayer", "Second"}
    np.testing.assert_array_equal(found["ViewLayer"], found["Second"])
    assert found["Second"].max() > 0


def test_statistics_name_this_blender(blender, blend):
    path = blend.parent / "s.json"
    code = f"import bpy\nbpy.context.scene.pt_engine.stats_path = {str(path)!r}\nbpy.ops.render.render()\n"
    done = blender.python(code, blend)
    assert done.returncode == 0, done.stdout + done.stderr
    statistics = json.loads(path.read_text())
    assert statistics["versions"]["blender"].startswith(tuple("56789"))
    assert statistics["nonfinite"]["count"] == 0


@pytest.mark.parametrize("end", ["-f", "-a"])
def test_an_exception_inside_is_an_exit_code_and_a_message_and_no_crash(blender, blend, tmp_path, end):
    own = tmp_path / "failing.py"
    own.write_text(
        "from pt_engine.render.integrator import Integrator\n"
        "class Failing(Integrator):\n"
        "    name = 'failing'\n"
        "    def sample(self, scene, rays, sampler):\n"
        "        raise ValueError('no light today')\n"
        "import bpy\n"
        "bpy.context.scene.pt_engine.integrator = 'failing'\n"
    )
    last = ["1"] if end == "-f" else []
    done = blender("-b", blend, "-P", own, "-o", str(tmp_path / "x_"), "-F", "OPEN_EXR", end, *last)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "ValueError: no light today" in done.stdout + done.stderr
    assert not list(tmp_path.glob("x_*"))


def test_a_files_scene_without_a_camera_fails_in_words(blender, blend, tmp_path):
    code = "import bpy; bpy.context.scene.camera = None"
    done = blender("-b", blend, "--python-expr", code, "-o", str(tmp_path / "x_"), "-f", "1")
    assert done.returncode != 0
    assert "camera" in done.stdout + done.stderr


def test_the_report_is_a_page_or_a_message_that_says_what_is_missing(blender, blend):
    """Blender's own Python has no Jinja2 unless somebody has installed it."""
    code = (
        "import bpy, importlib.util, pathlib\n"
        "bpy.ops.render.render()\n"
        "missing = [p for p in ('jinja2', 'matplotlib') if not importlib.util.find_spec(p)]\n"
        "try:\n"
        "    print('REPORT', bpy.ops.pt_engine.open_report(), missing)\n"
        "except RuntimeError as error:\n"
        "    print('REPORT', missing and missing[0] in str(error) and 'pip install' in str(error))\n"
    )
    done = blender.python(code, blend)
    assert done.returncode == 0, done.stdout + done.stderr
    told = [line for line in done.stdout.splitlines() if line.startswith("REPORT")]
    assert told in (["REPORT True"], ["REPORT {'FINISHED'} []"])
