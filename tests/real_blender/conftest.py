"""A real Blender with the extension's zip installed in a user folder of its own."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MODULE = "bl_ext.user_default.pt_engine"


class Blender:
    """Runs one Blender, with its own user folder."""

    def __init__(self, command: str, resources: Path) -> None:
        self.command, self.resources = command, resources

    def __call__(self, *arguments, timeout=120) -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, "BLENDER_USER_RESOURCES": str(self.resources)}
        command = [self.command, *map(str, arguments)]
        return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=timeout)

    def python(self, code: str, *before) -> subprocess.CompletedProcess[str]:
        """Run Python in background mode; an exception in it is exit code 9."""
        return self("-b", *before, "--python-exit-code", "9", "--python-expr", code)


@pytest.fixture(scope="session")
def blender(tmp_path_factory):
    command = os.environ.get("PT_BLENDER", "")
    if not (command and shutil.which(command)):
        pytest.skip("no real Blender: set PT_BLENDER to its command (scripts/blender installs one)")
    folder = tmp_path_factory.mktemp("real")
    run = Blender(command, folder / "user")
    run.resources.mkdir()
    run.zip = build(folder)
    done = run("--command", "extension", "install-file", "-r", "user_default", "--enable", run.zip)
    assert done.returncode == 0, done.stdout + done.stderr
    return run


def build(folder: Path) -> Path:
    """The zip for this platform; wheels that an earlier build has fetched are used again."""
    for wheel in (ROOT / "dist" / "wheels").glob("*.whl"):
        (folder / "wheels").mkdir(exist_ok=True)
        shutil.copy(wheel, folder / "wheels")
    command = [sys.executable, str(ROOT / "tools" / "extension.py"), "--out", str(folder)]
    subprocess.run(command, check=True, capture_output=True, text=True)
    return next(folder.glob("pt_engine-*.zip"))


SCENE = """
import bpy
scene = bpy.context.scene
render = scene.render
render.resolution_x, render.resolution_y, render.resolution_percentage = 96, 64, 100
render.engine = "PT_ENGINE"
scene.pt_engine.samples = 4
scene.pt_engine.max_depth = 4
scene.frame_start, scene.frame_end = 1, 2
cube = bpy.data.objects["Cube"]
cube.data.materials.clear()  # the default grey: these tests are about Blender, not about shading
for frame, x in ((1, -2.0), (2, 2.0)):
    cube.location.x = x
    cube.keyframe_insert("location", frame=frame)
"""


@pytest.fixture(scope="session")
def blend(blender, tmp_path_factory):
    """Blender's default scene for PT Engine, small, with a cube that moves."""
    path = tmp_path_factory.mktemp("blend") / "scene.blend"
    done = blender.python(f"{SCENE}\nbpy.ops.wm.save_as_mainfile(filepath={str(path)!r})")
    assert done.returncode == 0, done.stdout + done.stderr
    return path
