"""`python -m pt_engine`: what each command does, says, and returns."""

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from support.engine_scene import HEIGHT, WIDTH, engine_scene, integrator_file, rendered
from support.exr import pixels

from pt_engine.render.integrator import INTEGRATORS
from pt_engine.report.tables import plural

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def blend(tmp_path_factory):
    """A saved scene; its stored text would stop a render if it were run."""
    scene = engine_scene()
    scene.frame_start, scene.frame_end = 1, 10
    text = bpy.data.texts.new("evil.py")
    text.write("raise SystemExit('a script of the file was run')")
    text.use_module = True
    path = tmp_path_factory.mktemp("cli") / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_render_writes_exr_png_and_statistics_and_says_so(run, blend, tmp_path):
    exr, png, stats = tmp_path / "new" / "a.exr", tmp_path / "a.png", tmp_path / "s.json"
    code, out, err = run("render", blend, "-o", exr, "--png", png, "--stats", stats, "--samples", 3)
    assert (code, err) == (0, "")
    line = out.splitlines()[-1]
    assert f"{exr}: {WIDTH}x{HEIGHT}, 3 samples" in line
    assert "rays/s" in line
    assert "estimated error" in line
    image = pixels(exr)
    assert image.dtype == np.float32
    assert image.shape == (HEIGHT, WIDTH, 4)
    assert pixels(png).shape == (HEIGHT, WIDTH, 3)
    statistics = json.loads(stats.read_text())
    assert statistics["samples"] == statistics["settings"]["samples"] == 3
    assert statistics["seconds"]["write"] > 0
    phases = {name: part for name, part in statistics["seconds"].items() if name != "total"}
    assert statistics["seconds"]["total"] == pytest.approx(sum(phases.values()), rel=1e-6)
    assert min(phases.values()) >= 0
    assert {path.name for path in tmp_path.iterdir()} == {"new", "a.png", "s.json"}  # no leftovers


def test_a_png_keeps_the_holes_of_holdouts_in_an_opaque_film(run, tmp_path):
    scene = engine_scene()
    material = bpy.data.materials.new("Hole")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    hole, end = tree.nodes.new("ShaderNodeHoldout"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(hole.outputs[0], end.inputs["Surface"])
    for owner in scene.objects:
        if owner.type == "MESH":
            owner.data.materials.clear()
            owner.data.materials.append(material)
    path = tmp_path / "holes.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    png = tmp_path / "a.png"
    code, _, err = run("render", path, "-o", tmp_path / "a.exr", "--png", png, "--samples", 1)
    assert (code, err) == (0, "")
    assert not bpy.context.scene.render.film_transparent
    image = pixels(png)
    assert image.shape == (HEIGHT, WIDTH, 4)
    assert image[..., 3].min() == 0
    np.testing.assert_allclose(image[..., 3], pixels(tmp_path / "a.exr")[..., 3], atol=1 / 255)


def test_the_command_line_renders_what_blender_renders(run, blend, tmp_path):
    assert run("render", blend, "-o", tmp_path / "a.exr", "--quiet") == (0, "", "")
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    expected = rendered(bpy.context.scene, tmp_path / "b.exr")
    np.testing.assert_array_equal(pixels(tmp_path / "a.exr"), expected)


def saved(scene, path):
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_one_view_layer_is_rendered_and_it_is_the_named_one(run, tmp_path):
    """In the second layer nothing is left but the sky, so that its picture is flat."""
    scene = engine_scene()
    apart = bpy.data.collections.new("Apart")
    scene.collection.children.link(apart)
    for each in [each for each in scene.objects if each.type == "MESH"]:
        for owner in each.users_collection:
            owner.objects.unlink(each)
        apart.objects.link(each)
    scene.view_layers.new("Bare").layer_collection.children["Apart"].exclude = True
    path, pictures = saved(scene, tmp_path / "layers.blend"), {}
    for name in ("ViewLayer", "Bare"):
        stats = tmp_path / "s.json"
        words = ["-o", tmp_path / "a.exr", "--stats", stats, "--samples", 2, "--quiet"]
        assert run("render", path, "--view-layer", name, *words) == (0, "", "")
        statistics = json.loads(stats.read_text())
        assert statistics["view_layer"] == name
        assert "layers" not in statistics
        pictures[name] = pixels(tmp_path / "a.exr")[..., :3]
    assert np.ptp(pictures["Bare"], axis=(0, 1)).max() < 1e-6 < np.ptp(pictures["ViewLayer"])
    told = [run("replay", path, "--pixel", "9,9", "--sample", 0, "--view-layer", n)[1] for n in pictures]
    assert "scatters" not in told[1]


def test_both_eyes_are_written(run, tmp_path):
    scene = engine_scene()
    scene.render.use_multiview = True
    scene.render.image_settings.views_format = "STEREO_3D"
    path = saved(scene, tmp_path / "eyes.blend")
    exr, png = tmp_path / "out" / "a.exr", tmp_path / "out" / "a.png"
    code, out, err = run("render", path, "-o", exr, "--png", png, "--samples", 1)
    assert (code, err) == (0, "")
    names = {"a_L.exr", "a_R.exr", "a_L.png", "a_R.png"}
    assert {each.name for each in (tmp_path / "out").iterdir()} == names
    assert "a_L.exr, " in out
    left, right = (pixels(tmp_path / "out" / f"a_{eye}.exr") for eye in "LR")
    assert left.shape == (HEIGHT, WIDTH, 4)
    assert np.abs(left - right).max() > 0


@pytest.mark.parametrize("size", [(1, 1), (3, 7), (4, 4)])
def test_small_images_have_the_size_that_was_asked_for(run, blend, tmp_path, size):
    """Blender itself takes no resolution below 4."""
    exr = tmp_path / "a.exr"
    assert run("render", blend, "-o", exr, "--size", "{}x{}".format(*size), "--samples", 1)[0] == 0
    assert pixels(exr).shape[:2] == size[::-1]


def test_a_file_of_a_newer_blender_is_told(run, tmp_path):
    path = tmp_path / "newer.blend"
    engine_scene()
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
    major, minor = bpy.app.version[:2]
    content = path.read_bytes()
    head, rest = content[:17], content[17:]
    assert head.count(b"%d%02d" % (major, minor)) == 1
    path.write_bytes(head.replace(b"%d%02d" % (major, minor), b"%d99" % major) + rest)
    code, out, err = run("render", path, "-o", tmp_path / "a.exr", "--samples", 1)
    assert code == 0
    assert f"is of Blender {major}.99, newer than this one" in err
    assert "a.exr" in out


def test_options_reach_the_engine(run, blend, tmp_path):
    stats = tmp_path / "s.json"
    words = ["render", blend, "-o", tmp_path / "a.exr", "--stats", stats, "--size", "16x10", "--seed", 5]
    words += ["--threads", 2, "--integrator", "direct_mis", "--max-depth", 2, "--seconds", 9]
    words += ["--set", "pixel_filter=BOX", "--set", "samples=1", "--set", "strict=off", "--frame", 3]
    assert run(*words)[0] == 0
    statistics = json.loads(stats.read_text())
    expected = {
        "width": 16, "height": 10, "seed": 5, "threads": 2, "integrator": "direct_mis", "max_depth": 2,
        "seconds": 9.0, "pixel_filter": "BOX", "samples": 1,
    }  # fmt: skip
    assert {key: statistics["settings"][key] for key in expected} == expected
    assert statistics["frame"] == 3


def test_the_statistics_file_of_the_panel_is_one_for_each_frame(run, blend, tmp_path):
    words = ["-o", tmp_path / "a.exr", "--frame", 3, "--set", f"stats_path={tmp_path}/new/s_####.json"]
    assert run("render", blend, *words)[0] == 0
    assert json.loads((tmp_path / "new" / "s_0003.json").read_text())["frame"] == 3


def test_progress_is_a_bar_where_asked_for(run, blend, tmp_path):
    code, _, err = run("render", blend, "-o", tmp_path / "a.exr", "--progress")
    assert code == 0
    assert "\r[" in err
    assert "Mrays/s" in err
    assert err.endswith("\n")


def test_a_plugin_adds_an_integrator(run, blend, tmp_path):
    path = integrator_file(tmp_path, "uniform_grey", "return np.full_like(rays.o, 0.5)")
    words = ["render", blend, "-o", tmp_path / "a.exr", "--plugin", path, "--integrator", "uniform_grey"]
    try:
        assert run(*words)[0] == 0
    finally:
        INTEGRATORS.pop("uniform_grey", None)
    np.testing.assert_array_equal(pixels(tmp_path / "a.exr")[..., :3], np.float32(0.5))


def test_replay_prints_the_path(run, blend):
    code, out, err = run("replay", blend, "--pixel", f"{WIDTH // 2},{HEIGHT // 2}", "--sample", 1)
    assert (code, err) == (0, "")
    assert "radiance" in out
    assert run("replay", blend, "--pixel", "999,0", "--sample", 0)[0] == 1
    assert run("replay", blend, "--pixel", "0,0", "--sample", 2**32)[0] == 2


def test_each_eye_is_replayed_by_its_name(run, tmp_path):
    """As dropped samples of a stereoscopic render are reported with it."""
    scene = engine_scene()
    scene.render.use_multiview = True
    path = tmp_path / "eyes.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    command = ["replay", path, "--pixel", "9,9", "--sample", 1]
    eyes = [run(*command, *view)[1] for view in ([], ["--view", "left"], ["--view", "right"])]
    assert eyes[0] == eyes[1]
    assert "camera ray" in eyes[2]
    assert eyes[2] != eyes[1]
    code, _, err = run(*command, "--view", "middle")
    assert code == 1
    assert "no view 'middle'" in err


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["missing.blend"], 1, "no such file"),
        (["{tmp}"], 1, "directory"),
        (["{tmp}/text.blend"], 1, "can't be read as a .blend"),
        (["{tmp}/nocamera.blend"], 1, "no camera"),
        (["{blend}", "--frame", "99"], 1, "has the frames 1 to 10"),
        (["{blend}", "-o", "{tmp}/folder.exr"], 1, "can't write"),
        (["{blend}", "-o", "{tmp}/text.blend/a.exr"], 1, "is not a folder"),
        (["{blend}", "--png", "{tmp}/text.blend/a.png"], 1, "is not a folder"),
        (["{blend}", "--view-layer", "No"], 1, "no view layer"),
        (["{blend}", "--plugin", "{tmp}/no.py"], 1, "no such file"),
        (["{blend}", "--set", "sample=3"], 2, "no property 'sample'"),
        (["{blend}", "--set", "samples=many"], 2, "not a whole number"),
        (["{blend}", "--set", "samples=-3"], 2, "not between"),
        (["{blend}", "--set", "sampler=dice"], 2, "not one of"),
        (["{blend}", "--set", "strict=perhaps"], 2, "not one of"),
        (["{blend}", "--set", "seconds=nan"], 2, "not between"),
        (["{blend}", "--integrator", "magic"], 2, "not one of"),
        (["{blend}", "--samples", "0"], 2, "never end"),
        (["{blend}", "--samples", "-1"], 2, "less than 0"),
        (["{blend}", "--size", "0x3"], 2, "below 1"),
        (["{blend}", "--size", "big"], 2, "not like"),
        (["{blend}", "-o", "a.jpg"], 2, "does not end with .exr"),
        (["{blend}", "--stats", "{blend}"], 2, "does not end with .json"),
        (["{blend}", "--size", "65537x4"], 2, "above 65536"),
        (["{blend}", "--size", "20000x2"], 2, "no image is 20000x2"),
        (["{blend}", "--threads", "1025"], 2, "more than 1024"),
        (["{blend}", "--target-percentile", "90"], 2, "without --target-error"),
        (["{blend}", "--adaptive", "--samples", "0", "--seconds", "1"], 2, "--adaptive needs"),
        (["{blend}", "--set", "stats_path={tmp}/text.blend/s.json"], 1, "is not a folder"),
        (["{blend}", "--nonsense"], 2, "unrecognized"),
    ],
)
def test_every_failure_has_its_code_and_its_line(run, blend, tmp_path, words, code, message):
    (tmp_path / "text.blend").write_text("this is no .blend")
    (tmp_path / "folder.exr").mkdir()
    if "{tmp}/nocamera.blend" in words:
        scene = engine_scene()
        scene.camera = None
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "nocamera.blend"))
    words = [word.format(tmp=tmp_path, blend=blend) for word in words]
    if "-o" not in words:
        words += ["-o", str(tmp_path / "a.exr")]
    got, out, err = run("render", *words)
    assert (got, out) == (code, "")
    assert message in err
    assert "Traceback" not in err
    assert not (tmp_path / "a.exr").exists()


def subprocess_run(*words, **options):
    command = [sys.executable, "-m", "pt_engine", *map(str, words)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, **options)


def test_the_process_prints_nothing_but_its_own_lines(blend, tmp_path):
    done = subprocess_run("render", blend, "-o", tmp_path / "a.exr")
    assert (done.returncode, done.stderr) == (0, "")
    assert len(done.stdout.splitlines()) == 1
    assert subprocess_run("--version").stdout.startswith("pt_engine ")
    assert subprocess_run().returncode == 2


def test_a_failure_inside_ends_with_code_1_and_keeps_the_earlier_picture(blend, tmp_path):
    (tmp_path / "a.exr").write_text("earlier")
    path = integrator_file(tmp_path, "raising", "raise ValueError('no light today')")
    done = subprocess_run(
        "render", blend, "-o", tmp_path / "a.exr", "--plugin", path, "--integrator", "raising"
    )
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "pt_engine: ValueError: no light today"
    assert (tmp_path / "a.exr").read_text() == "earlier"


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for a single process on Windows")
def test_ctrl_c_ends_in_order_and_keeps_what_there_is(blend, tmp_path):
    exr, stats = tmp_path / "a.exr", tmp_path / "s.json"
    words = ["render", blend, "-o", exr, "--stats", stats, "--progress", "--samples", "1000000"]
    command = [sys.executable, "-m", "pt_engine", *map(str, words)]
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
        text = ""
        while not re.search(r"Sample [1-9]", text):  # it renders
            text += process.stderr.read(1)
        process.send_signal(signal.SIGINT)
        text += process.stderr.read()
    assert process.returncode == 1
    statistics = json.loads(stats.read_text())
    assert (statistics["cancelled"], statistics["stopped_by"]) == (True, "cancelled")
    assert f"interrupted after {plural(statistics['samples'], 'sample')}: {exr} has no more" in text
    assert "Traceback" not in text
    assert np.isfinite(pixels(exr)).all()
    assert {each.name for each in tmp_path.iterdir()} == {"a.exr", "s.json"}


def test_renders_to_one_place_at_once_do_not_break_each_other(blend, tmp_path):
    """The last one to end wins, with a whole file."""
    words = ["render", blend, "-o", tmp_path / "a.exr", "--png", tmp_path / "a.png", "--quiet"]
    command = [sys.executable, "-m", "pt_engine", *map(str, words), "--seed"]
    every = [subprocess.Popen([*command, str(seed)], cwd=ROOT) for seed in range(2)]
    assert [each.wait(timeout=120) for each in every] == [0, 0]
    assert {each.name for each in tmp_path.iterdir()} == {"a.exr", "a.png"}
    assert pixels(tmp_path / "a.exr").shape == (HEIGHT, WIDTH, 4)


@pytest.mark.parametrize("package", ["bpy", "numpy", "embreex"])
def test_without_a_package_it_says_what_to_install(blend, tmp_path, package):
    (tmp_path / f"{package}.py").write_text(f"raise ImportError('blocked', name='{package}')")
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from pt_engine.blender import cli; "
        f"sys.exit(cli.main(['render', {str(blend)!r}, '-o', 'x.exr']))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert f"pip install {package}" in done.stderr
    assert "Traceback" not in done.stderr
