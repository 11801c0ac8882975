"""Integrators of a user's own."""

from pathlib import Path

import numpy as np
import pytest
from support.engine_scene import engine_scene, integrator_file, rendered

from pt_engine.blender import plugins
from pt_engine.render.integrator import INTEGRATORS

EXAMPLE = Path(__file__).parents[2] / "examples" / "ambient_occlusion.py"


pytestmark = pytest.mark.usefixtures("own_integrators")


def test_the_documented_example_appears_in_the_panel_and_renders(tmp_path):
    scene = engine_scene(samples=8)
    scene.pt_engine.python_files = str(EXAMPLE)
    import bpy

    assert bpy.ops.pt_engine.load_integrators() == {"FINISHED"}
    scene.pt_engine.integrator = "ambient_occlusion"
    image = rendered(scene, tmp_path / "a.exr")
    middle = image[10:14, 14:18, :3]
    np.testing.assert_allclose(middle, 1.0)  # nothing stands before the cube's front
    assert (image[0, 0, :3] == 0).all()


def test_a_file_that_raises_is_told_with_its_line_and_leaves_nothing(tmp_path):
    path = tmp_path / "broken.py"
    path.write_text("from pt_engine.render.integrator import Integrator\n1 / 0\n")
    before = dict(INTEGRATORS)
    with pytest.raises(plugins.PluginError, match=r"broken\.py .*ZeroDivisionError"):
        plugins.load(path)
    assert before == INTEGRATORS


def test_a_file_without_an_integrator_is_told(tmp_path):
    path = tmp_path / "empty.py"
    path.write_text("x = 1\n")
    with pytest.raises(plugins.PluginError, match="registers no integrator"):
        plugins.load(path)
    with pytest.raises(plugins.PluginError, match="no such file"):
        plugins.load(tmp_path / "missing.py")


def test_loading_again_replaces(tmp_path):
    path = integrator_file(tmp_path, "mine", "return rays.d")
    assert plugins.load(path) == ["mine"]
    first = INTEGRATORS["mine"]
    assert plugins.load(path) == ["mine"]
    assert INTEGRATORS["mine"] is not first


def test_a_built_in_name_is_not_taken(tmp_path):
    path = integrator_file(tmp_path, "normals", "return rays.d")
    built_in = INTEGRATORS["normals"]
    with pytest.raises(plugins.PluginError, match="takes the name"):
        plugins.load(path)
    assert INTEGRATORS["normals"] is built_in


def test_a_blend_never_runs_a_file_by_itself(tmp_path):
    import bpy

    scene = engine_scene()
    scene.pt_engine.python_files = str(integrator_file(tmp_path, "sneaky", "return rays.d"))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"), use_scripts=True)
    assert "sneaky" not in INTEGRATORS
