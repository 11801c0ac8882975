"""The extension in a real Blender's window, on a virtual display."""

import shutil

import pytest
from support.exr import pixels
from support.screenshot import beside, photograph

HEAD = """
import bpy
window = bpy.context.window_manager.windows[0]
def area(kind):
    return next(a for a in window.screen.areas if a.type == kind)
rendering = lambda: bpy.app.is_job_running("RENDER")
"""


@pytest.fixture
def window(blender, blend, tmp_path):
    """Runs steps in a window with the test's scene; what Blender printed."""
    if not beside(blender.command) and not (shutil.which("Xvfb") and shutil.which("xdotool")):
        pytest.skip("no virtual display: Xvfb and xdotool are not installed")

    def run(steps):
        script = tmp_path / "steps.py"
        script.write_text(HEAD + steps)
        return photograph(
            blender.command, script, tmp_path / "shot.png", [blend], resources=blender.resources
        )

    return run


def test_f12_shows_a_growing_picture_and_escape_keeps_it(window, tmp_path):
    """Cancelled long before its end: an answer within seconds, the picture so far kept, and no crash."""
    log = window(f"""
events = []
bpy.app.handlers.render_cancel.append(lambda *_: events.append("cancel"))
bpy.app.handlers.render_complete.append(lambda *_: events.append("complete"))

def steps():
    import time
    scene = bpy.context.scene
    scene.pt_engine.samples = 1_000_000
    yield "move:640,400"
    yield 0.5
    yield "key:F12"
    yield rendering
    yield 4.0
    assert rendering()
    yield "shot:rendering"
    started = time.monotonic()
    yield "key:Escape"
    yield lambda: not rendering()
    print("stopped after %.2f s" % (time.monotonic() - started))
    assert time.monotonic() - started < 8
    yield 0.5
    assert events == ["cancel"], events
    image = scene.render.image_settings
    image.media_type = "IMAGE"
    image.file_format, image.color_depth = "OPEN_EXR", "32"
    bpy.data.images["Render Result"].save_render({str(tmp_path / "kept.exr")!r})
""")
    assert "stopped after" in log
    kept = pixels(tmp_path / "kept.exr")
    assert kept[..., :3].max() > 2 * kept[0, 0, :3].max() > 0
    assert (tmp_path / "shot-rendering.png").stat().st_size > 10_000


def test_an_exception_inside_is_told_and_blender_lives_on(window):
    window("""
def steps():
    from pt_engine.render.integrator import Integrator

    class Failing(Integrator):
        name = "failing"
        def sample(self, scene, rays, sampler):
            raise ValueError("no light today")

    scene = bpy.context.scene
    scene.pt_engine.integrator = "failing"
    with bpy.context.temp_override(window=window, area=area("VIEW_3D")):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield 2.0
    yield lambda: not rendering()
    yield "shot:failed"
    scene.pt_engine.integrator = "path"
    with bpy.context.temp_override(window=window, area=area("VIEW_3D")):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield 1.0
    yield lambda: not rendering()
""")


def test_the_way_to_a_node_ends_with_it_in_view(window):
    """The editor's first redraw with a tree goes back to where it was last looked at."""
    window("""
def steps():
    made = bpy.data.materials.new("Far")
    if made.node_tree is None:
        made.use_nodes = True
    node = made.node_tree.nodes.new("ShaderNodeVolumeScatter")
    node.location = 5000, -3000
    bpy.data.objects["Cube"].data.materials.append(made)
    editor = area("VIEW_3D")
    editor.ui_type = "ShaderNodeTree"
    region = next(r for r in editor.regions if r.type == "WINDOW")
    yield 0.2
    bpy.ops.pt_engine.show_node(owner="Far", node=node.name)

    def in_view():
        x, y = region.view2d.view_to_region(5050, -3050, clip=False)
        return 0 < x < region.width and 0 < y < region.height

    yield 0.3
    yield in_view
    yield 0.3
    assert in_view()
""")
