"""Motion blur where Blender renders in a thread of its own, and drivers in Python are evaluated each time."""

import json
import shutil

import pytest
from support.exr import pixels
from support.screenshot import beside, photograph

BLUR = """
import bpy
scene = bpy.context.scene
scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.8
bpy.app.driver_namespace["place"] = lambda frame: [2.0 * frame][0]
for k in range(8):
    copy = bpy.data.objects["Cube"].copy()
    copy.animation_data_clear()
    scene.collection.objects.link(copy)
    copy.driver_add("location", 2).driver.expression = "place(frame)"
scene.frame_set(1)
"""


def check(stats, image):
    assert stats["features"]["motion blur"] == "on"
    assert pixels(image)[..., :3].max() > 0


def test_in_background_with_drivers_in_python(blender, blend, tmp_path):
    """They need Python's lock while the engine's call is under way: no deadlock, and the frame comes back."""
    image, stats = tmp_path / "blur.exr", tmp_path / "stats.json"
    done = blender.python(
        f"{BLUR}\nscene.pt_engine.stats_path = {str(stats)!r}\n"
        "scene.render.image_settings.media_type = 'IMAGE'\n"
        f"scene.render.image_settings.file_format, scene.render.filepath = 'OPEN_EXR', {str(image)!r}\n"
        "bpy.ops.render.render(write_still=True)\n"
        "assert (scene.frame_current, scene.frame_subframe) == (1, 0.0)\n",
        blend,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    check(json.loads(stats.read_text()), image)


def test_in_a_window(blender, blend, tmp_path):
    """F12: `render` runs beside the window, and asks for other frames from there."""
    if not beside(blender.command) and not (shutil.which("Xvfb") and shutil.which("xdotool")):
        pytest.skip("no virtual display: Xvfb and xdotool are not installed")
    image, stats, script = tmp_path / "kept.exr", tmp_path / "stats.json", tmp_path / "steps.py"
    script.write_text(f"""{BLUR}
def steps():
    scene.pt_engine.samples, scene.pt_engine.stats_path = 8, {str(stats)!r}
    ended = []
    for event in ("render_complete", "render_cancel"):
        getattr(bpy.app.handlers, event).append(lambda *_, event=event: ended.append(event))
    yield "move:640,400"
    yield 0.5
    yield "key:F12"
    yield lambda: ended
    yield lambda: not bpy.app.is_job_running("RENDER")
    assert ended == ["render_complete"], ended
    assert (scene.frame_current, scene.frame_subframe) == (1, 0.0)
    settings = scene.render.image_settings
    settings.media_type = "IMAGE"
    settings.file_format = "OPEN_EXR"
    bpy.data.images["Render Result"].save_render({str(image)!r})
""")
    photograph(blender.command, script, tmp_path / "shot.png", [blend], resources=blender.resources)
    check(json.loads(stats.read_text()), image)
