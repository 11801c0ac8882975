"""`compare`, `whatif` and `--report` on a .blend: tables, JSON, pages, and plain refusals."""

from __future__ import annotations

import errno
import html
import json
import re
import shlex
import signal
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from support.engine_scene import engine_scene, rendered
from support.exr import pixels

from pt_engine.blender import record
from pt_engine.blender.cli import comparison
from pt_engine.blender.record import Session
from pt_engine.report import optional as packages
from pt_engine.report import page

QUICK = ("--size", "16x12", "--threads", "1", "--quiet")


@pytest.fixture(scope="module")
def blend(tmp_path_factory):
    engine_scene()
    path = tmp_path_factory.mktemp("accuracy") / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_render_writes_a_page(run, blend, tmp_path):
    page = tmp_path / "new" / "page.html"
    code, _, err = run("render", blend, "-o", tmp_path / "a.exr", "--report", page, "--samples", 4, *QUICK)
    assert (code, err) == (0, "")
    text = page.read_text(encoding="utf-8")
    assert text.count("data:image/png;base64,") == 2
    assert "python -m pt_engine render" in text
    assert "--max-depth 3" in text


@pytest.mark.parametrize(
    "words", [["--adaptive", "--samples", "32"], ["--target-error", "0.1", "--target-percentile", "80"]]
)
def test_the_command_on_the_page_makes_the_picture_again(run, blend, tmp_path, words):
    """Bit for bit, also where the noise has decided how many samples each pixel got."""
    page = tmp_path / "page.html"
    first, again = tmp_path / "a.exr", tmp_path / "b.exr"
    words += ["--min-samples", 8, "--seed", 3, *QUICK]
    assert run("render", blend, "-o", first, "--report", page, *words)[0] == 0
    command = html.unescape(re.search("<pre>(.*?)</pre>", page.read_text(encoding="utf-8"), re.DOTALL)[1])
    assert run(*shlex.split(command.replace("OUT.exr", str(again)))[3:])[0] == 0
    np.testing.assert_array_equal(pixels(first), pixels(again))


def test_compare_prints_a_table_and_writes_json_and_a_page(run, blend, tmp_path):
    page, data = tmp_path / "page.html", tmp_path / "c.json"
    words = [
        "--seconds",
        0.02,
        "--seeds",
        2,
        "--only",
        "direct_bsdf",
        "--reference-seconds",
        0.5,
        "--no-cache",
    ]
    code, out, err = run("compare", blend, *words, "--json", data, "--report", page, *QUICK)
    assert (code, err) == (0, "")
    assert "BSDF sampling cannot hit lamps without a size" in out
    result = json.loads(data.read_text(encoding="utf-8"))
    assert [row["name"] for row in result["rows"]] == ["as set", "direct_bsdf"]
    assert result["seconds"] == pytest.approx(0.02)
    assert "direct_bsdf" in page.read_text(encoding="utf-8")


def test_compare_takes_a_given_reference(run, blend, tmp_path):
    words = ("--seconds", 0.02, "--seeds", 2, "--only", "path_fixed")
    exr = tmp_path / "r.exr"
    assert run("render", blend, "-o", exr, "--samples", 16, *QUICK)[0] == 0
    code, out, _ = run("compare", blend, "--reference", exr, *words, *QUICK)
    assert code == 0
    assert f"Reference: {exr}" in out
    code, _, err = run("compare", blend, "--reference", exr, *words, "--size", "8x8", "--quiet")
    assert code == 1
    assert "has 16x12 pixels, the render 8x8" in err


def test_with_shadow_catchers_no_picture_is_a_reference(run, tmp_path):
    """A ratio of several films has not the light of the whole scene."""
    engine_scene()
    bpy.data.objects["Cube"].is_shadow_catcher = True
    blend, exr = tmp_path / "caught.blend", tmp_path / "r.exr"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    assert run("render", blend, "-o", exr, "--samples", 2, *QUICK)[0] == 0
    code, _, err = run("compare", blend, "--reference", exr, "--seconds", 0.02, *QUICK)
    assert code == 2
    assert "which no picture shows" in err


def test_two_images_are_compared(run, blend, tmp_path):
    for seed, name in ((1, "a.exr"), (2, "b.exr")):
        run("render", blend, "-o", tmp_path / name, "--samples", 2, "--seed", seed, *QUICK)
    code, out, _ = run("compare", tmp_path / "a.exr", tmp_path / "b.exr")
    assert code == 0
    assert "relMSE" in out
    assert "FLIP" in out
    assert run("compare", tmp_path / "a.exr")[0] == 2
    assert run("compare", tmp_path / "a.exr", tmp_path / "none.exr")[0] == 1
    assert "--reference" in run("compare", blend, tmp_path / "a.exr")[2]


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["compare", "{blend}", "--only", "nobody"], 2, "in none of the names: as set, direct_bsdf"),
        (["compare", "{blend}", "--integrator", "normals"], 2, "nothing to compare"),
        (["compare", "{blend}", "--json", "{tmp}/file/c.json"], 1, "is not a folder"),
        (["whatif", "{blend}", "--json", "{tmp}/file/w.json"], 1, "is not a folder"),
        (["whatif", "{blend}", "--json", "{blend}"], 2, "does not end with .json"),
        (["selftest", "--markdown", "{tmp}/file/s.md"], 1, "is not a folder"),
    ],
)
def test_what_would_be_in_vain_is_refused_before_the_work(run, blend, tmp_path, words, code, message):
    (tmp_path / "file").write_text("")
    got, out, err = run(*(word.format(blend=blend, tmp=tmp_path) for word in words))
    assert (got, out) == (code, "")
    assert message in err
    assert "making the reference" not in err


def test_whatif_prints_what_is_there_and_what_is_not(run, blend, tmp_path):
    code, out, _ = run("whatif", blend, "--seconds", 0.02, "--report", tmp_path / "w.html", *QUICK)
    assert code == 0
    assert "world light" in out
    assert "depth of field: 0 s, 0 difference (the camera has no aperture)" in out
    code, out, _ = run("whatif", blend, "--seconds", 0.02, "--json", "-", *QUICK)
    assert json.loads(out)["schema"] == "pt_engine.whatif/1"


COMPARED = ("--seconds", 0.02, "--seeds", 2, "--only", "path_", "--reference-seconds", 0.3, "--no-cache")


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for a single process on Windows")
@pytest.mark.parametrize(
    ("words", "at", "kept"),
    [
        (["compare", *COMPARED], "2/2 path_fixed", "interrupted after 4 runs"),
        (["compare", *COMPARED], "1/2 as set", "nothing was measured"),
        (["compare", *COMPARED], "making the reference", "nothing was measured"),
        (["whatif", "--seconds", 0.02], "without bounces from the 2nd on", "have not been measured"),
        (["whatif", "--seconds", 0.02], "the whole scene", "nothing was measured"),
    ],
)
def test_ctrl_c_keeps_what_is_found(run, blend, tmp_path, monkeypatch, words, at, kept):
    """As of a render: what is finished is written, the code is 1, and one line says that there is no more."""

    def tell(arguments, line):
        if line == at:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(comparison, "tell", tell)
    html_page, data = tmp_path / "p.html", tmp_path / "c.json"
    words = [*words, "--json", data, "--report", html_page, *QUICK]
    code, out, err = run(words[0], blend, *words[1:])
    assert code == 1
    assert err.startswith("pt_engine: interrupted")
    assert err.count("\n") == 1
    assert kept in err
    found = "nothing" not in kept
    assert (data.exists(), html_page.exists(), out != "") == (found, found, found)
    if found:
        result = json.loads(data.read_text(encoding="utf-8"))
        assert not result["complete"]
        assert "It was interrupted" in html_page.read_text(encoding="utf-8")
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize(
    "words",
    [
        ["render", "-o", "{tmp}/a.exr", "--samples", 2, "--stats", "{tmp}/a.json"],
        ["compare", *COMPARED, "--json", "{tmp}/a.json"],
        ["whatif", "--seconds", 0.02, "--json", "{tmp}/a.json"],
    ],
)
def test_a_disk_that_fills_up_meanwhile_is_one_clear_line(run, blend, tmp_path, monkeypatch, words):
    """Both files are told, and what could be delivered was."""

    def full(path, text):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(record, "write_whole", full)
    monkeypatch.setattr(page, "write_whole", full)
    words = [str(word).format(tmp=tmp_path) for word in words]
    code, out, err = run(words[0], blend, *words[1:], "--report", tmp_path / "p.html", *QUICK)
    assert code == 1
    places = [f"can't write {tmp_path / name}: No space left on device" for name in ("a.json", "p.html")]
    assert err == f"pt_engine: {'; '.join(places)}\n"
    assert (tmp_path / "a.exr").exists() if words[0] == "render" else "as set" in out or "takes:" in out


def test_a_missing_package_is_told_before_the_work(run, blend, tmp_path, monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(packages.importlib, "import_module", missing)
    code, _, err = run("render", blend, "-o", tmp_path / "a.exr", "--report", tmp_path / "p.html", *QUICK)
    assert code == 1
    assert "pip install" in err
    assert not (tmp_path / "a.exr").exists()


def test_without_openimageio_images_are_refused_in_one_line(run, blend, tmp_path, monkeypatch):
    assert run("render", blend, "-o", tmp_path / "a.exr", "--samples", 1, *QUICK)[0] == 0
    monkeypatch.setitem(sys.modules, "OpenImageIO", None)  # as if it were not installed
    code, out, err = run("compare", tmp_path / "a.exr", tmp_path / "a.exr")
    assert (code, out) == (1, "")
    assert err.strip() == "pt_engine: OpenImageIO is missing here: pip install OpenImageIO"


def test_the_button_writes_a_page_and_leaves_the_files_output_settings(tmp_path):
    scene = engine_scene(samples=4)
    rendered(scene, tmp_path / "a.exr")
    image = scene.render.image_settings
    before = image.file_format, image.color_mode, image.color_depth
    assert bpy.ops.pt_engine.open_report() == {"FINISHED"}
    page = next(Path(bpy.app.tempdir).glob("pt_engine-report-*.html"))
    assert "Where the time went" in page.read_text(encoding="utf-8")
    assert (image.file_format, image.color_mode, image.color_depth) == before
    Session.last = None
    assert not bpy.ops.pt_engine.open_report.poll()


def test_two_renders_with_their_passes_have_a_z_test(run, blend, tmp_path):
    """Other seeds of the same differ as noise does; a shorter depth by more."""
    renders = {"a": ("--seed", 1), "b": ("--seed", 2), "short": ("--seed", 3, "--max-depth", 1)}
    for name, more in renders.items():
        out = tmp_path / f"{name}.exr"
        assert run("render", blend, "-o", out, "--passes", "--samples", 32, *more, *QUICK)[0] == 0
    told = run("compare", tmp_path / "a.exr", tmp_path / "b.exr")[1]
    assert "they differ as noise does" in told
    assert "they differ by more than noise" in run("compare", tmp_path / "short.exr", tmp_path / "b.exr")[1]
    assert run("render", blend, "-o", tmp_path / "plain.exr", "--samples", 4, *QUICK)[0] == 0
    plain = run("compare", tmp_path / "plain.exr", tmp_path / "plain.exr")[1]
    assert "(render --passes writes it)" in plain
