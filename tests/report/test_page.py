"""The page: self-contained, escaped, complete; and a clear message where a package is missing."""

from __future__ import annotations

import copy
import math
import re

import numpy as np
import pytest
from support import scenes as make
from support.rooms import SOFT_LAMP, room

from pt_engine.render.ledger import Ledger
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.render.stats import statistics
from pt_engine.report import optional as packages
from pt_engine.report.error_picture import error_picture
from pt_engine.report.errors import Picture
from pt_engine.report.figures import bars
from pt_engine.report.optional import MissingPackage
from pt_engine.report.page import accuracy, check_packages, comparison_page, render_page, whatif_page
from pt_engine.scene.prepare import prepare


@pytest.fixture(scope="module")
def rendered():
    """A render's statistics with its ledger, and its film."""
    scene, ledger = prepare(room(make.diffuse(0.5, "<b>bold</b>"), SOFT_LAMP)), Ledger()
    settings = RenderSettings(40, 30, samples=32, threads=1, max_depth=4)
    result = render(scene, settings, ledger=ledger)
    stats = statistics(scene, settings, result, ledger)
    return {**stats, "frame": 7, "scene": "Room & <Co>"}, result.film


def self_contained(text):
    """Nothing is fetched from anywhere: every source carries its data, and there are no scripts."""
    sources = re.findall(r'(?:src|href)="([^"]*)"', text)
    assert all(source.startswith(("data:", "#")) for source in sources)
    assert "<script" not in text
    assert "@import" not in text
    assert "<!DOCTYPE html>" in text
    assert 'name="viewport"' in text
    assert "@media print" in text


def fits_a_phone_and_paper(text):
    """Tables scroll in boxes of their own, figures shrink, columns may be narrower than their content."""
    assert len(re.findall(r'<div class="wide[^"]*"><table', text)) == text.count("<table")
    assert all("viewBox=" in svg and "role=" in svg for svg in re.findall(r"<svg [^>]*>", text))
    style = text[text.index("<style>") : text.index("</style>")]
    assert re.search(r"figure svg \{[^}]*width: 100%[^}]*max-width[^}]*height: auto", style)
    assert re.search(r"\.wide \{[^}]*overflow-x: auto", style)
    columns = re.findall(r"grid-template-columns: ([^;}]*)", style)
    shares = re.sub(r"minmax\([^)]*\)", "", " ".join(columns))
    assert "fr" not in shares.replace("1fr 1fr 1fr", "")  # a bare fraction grows with its content
    assert re.search(r"dl\.long \{ display: block", style)
    assert re.search(r"screen and \(prefers-color-scheme: dark\)", style)  # paper stays white
    assert "break-inside: avoid" in style


def test_bars_to_the_left_do_not_run_into_names():
    """Their numbers stand at 0, on the other side."""
    svg = bars("difference", [("cheaper", -3.0), ("dearer", 2.0)], "seconds")
    x = {m[2]: float(m[1]) for m in re.finditer(r'<text [^>]* x="([\d.]+)"[^>]*>([^<]*)</text>', svg)}
    assert x[" -3"] == x["0"]
    assert x[" 2"] == x["2"]


def test_render_page_has_it_all_and_fetches_nothing(rendered, tmp_path):
    stats, film = rendered
    path = tmp_path / "page.html"
    render_page(path, stats, None, error_picture(film), "python -m pt_engine render 'a b.blend'")
    text = path.read_text(encoding="utf-8")
    self_contained(text)
    fits_a_phone_and_paper(text)
    for part in ("to halve the error", "Where the time went", "Off, and why", "Coverage", "None.", "embreex"):
        assert part in text
    assert "Room &amp; &lt;Co&gt;, frame 7" in text
    assert "<b>bold" not in text
    assert f"{stats['seconds']['total']:.3g} s in all: preparing it " in text  # not of the rendering alone
    assert not re.search(r"\de-\d\d s of threads", text)
    last = text[text.index('<section class="whole">') :]  # together: no last sheet with two lines
    assert all(part in last for part in ("a b.blend", "Settings", "max_depth", "Versions", "embreex"))
    assert re.search(r"@media print.*\.whole \{ break-inside: avoid", text, re.DOTALL)
    assert text.count("<svg ") == 3
    ids = re.findall(r' id="([^"]+)"', text)
    referred = set(re.findall(r'(?:url\(|href=")#([^")]+)', text))
    assert all(ids.count(name) == 1 for name in referred)  # figures do not mix up their markers
    assert len(path.read_bytes()) < 400_000


@pytest.mark.parametrize(
    ("sampler", "stratified", "times"),
    [("independent", 0.4, 4), ("sobol", 1.1, 4), ("sobol", 0.4, 4 ** (1 / 1.24))],
)
def test_halving_the_error_takes_as_long_again_as_the_sampler_needs(rendered, sampler, stratified, times):
    """σ ∝ t^(−a/2), a = 1 + ⅔ (1 − s)² with Sobol points: half of it at 4^(1/a) t, of which t is done."""
    stats = copy.deepcopy(rendered[0])
    stats["settings"]["sampler"], stats["error"]["stratified"] = sampler, stratified
    known = accuracy(stats)
    assert known["halving"] == pytest.approx((times - 1) * stats["seconds"]["render"])
    assert known["low"] < known["error"] < known["high"]
    assert known["error"] == pytest.approx(math.sqrt(stats["error"]["relmse"]))


def test_error_picture_is_the_standard_error_over_the_mean(rendered):
    film = rendered[1]
    expected = np.sqrt(film.variance_of_mean().mean(axis=2))[::-1] / film.image()[..., :3].mean()
    np.testing.assert_allclose(error_picture(film), expected, rtol=1e-5)


def test_comparison_and_whatif_pages(rendered, tmp_path):
    stats, _ = rendered
    interval = {"value": 1e-3, "low": 9e-4, "high": math.nan}
    points = [
        {"samples": s, "seconds": s / 9, "mse": 1 / s, "low": 0.8 / s, "high": 1.2 / s} for s in (1, 2, 4)
    ]
    row = {
        "name": "as set",
        "samples": 4.0,
        "mse_at_equal_time": interval,
        "mse_at_equal_samples": interval,
        "runs": 2,
        "relative_efficiency": {"value": 1.0, "low": 1.0, "high": 1.0},
        "slope": interval,
        "nonfinite": 3,
        "bias": {"relative": -0.38, "z": -9.0, "p": 0.0},
        "verdict": "emitter sampling misses the mirror: −38 % energy, biased",
    }
    result = {
        "file": "a.blend",
        "command": "python -m pt_engine compare a.blend",
        "seeds": 2,
        "seconds": 1.0,
        "samples": 4.0,
        "rows": [row],
        "curves": {"as set": points},
        "complete": True,
        "reference": {"origin": "a file", "error": None, "least_mse": 1e-4},
        "coverage": [
            {"material": "wall", "node": "Toon", "state": "approximate", "effect": "it is smoother"}
        ],
        "ledger": stats["ledger"],
        "settings": stats["settings"],
        "versions": stats["versions"],
    }
    errors = {"as set": np.ones((4, 6), np.float32)}
    comparison_page(tmp_path / "c.html", result, Picture(np.full((4, 6, 3), 0.5), None), errors)
    text = (tmp_path / "c.html").read_text(encoding="utf-8")
    self_contained(text)
    fits_a_phone_and_paper(text)
    for part in ("misses the mirror", "Where each is wrong", "it is smoother", "Where the time went"):
        assert part in text
    assert "<td>as set</td><td>3</td>" in text
    effect = {"name": "fog", "present": False, "why": "no fog", "seconds": 0.0, "difference": 0.0}
    result = {**result, "effects": [effect]}
    whatif_page(tmp_path / "w.html", result)
    text = (tmp_path / "w.html").read_text(encoding="utf-8")
    fits_a_phone_and_paper(text)
    assert "no fog" in text
    assert "interrupted" not in text
    whatif_page(tmp_path / "w.html", {**result, "complete": False})
    assert "interrupted" in (tmp_path / "w.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("package", ["jinja2", "matplotlib"])
def test_a_missing_package_is_told_with_the_way_to_get_it(package, monkeypatch):
    real = packages.importlib.import_module

    def without(name):
        if name.partition(".")[0] == package:
            raise ModuleNotFoundError(name)
        return real(name)

    monkeypatch.setattr(packages.importlib, "import_module", without)
    with pytest.raises(MissingPackage, match=rf"pip install {package}"):
        check_packages()
