"""`python -m pt_engine`: what each command does, says, and returns."""

import json
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
def test_ctrl_c_ends_in_order_and_writes_nothing(blend, tmp_path):
    words = ["render", blend, "-o", tmp_path / "a.exr", "--progress", "--samples", "1000000"]
    command = [sys.executable, "-m", "pt_engine", *map(str, words)]
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as process:
        text = ""
        while "Sample " not in text:  # it renders
            text += process.stderr.read(1)
        process.send_signal(signal.SIGINT)
        text += process.stderr.read()
    assert process.returncode == 1
    assert "interrupted after" in text
    assert list(tmp_path.iterdir()) == []


def test_without_bpy_it_says_what_to_install(blend, tmp_path):
    (tmp_path / "bpy.py").write_text("raise ImportError('blocked', name='bpy')")
    code = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from pt_engine.blender import cli; "
        f"sys.exit(cli.main(['render', {str(blend)!r}, '-o', 'x.exr']))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "pip install bpy" in done.stderr
