"""What a render says of itself: every key of the schema, true and ready for JSON."""

from __future__ import annotations

import json

import numpy as np
import pytest
from support import scenes as make
from support.rooms import SOFT_LAMP, room

from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.render.stats import SCHEMA, peak_memory, statistics, versions
from pt_engine.scene.prepare import prepare
from pt_engine.scene.snapshot import LightData

UP = np.eye(4)
KEYS = {
    "schema",
    "settings",
    "versions",
    "resolution",
    "samples",
    "seconds",
    "camera_samples_per_second",
    "rays",
    "peak_memory_bytes",
    "nonfinite",
    "features",
    "error",
    "coverage",
}


def told(snapshot, **more):
    """Statistics of a small render, through JSON and back."""
    settings = RenderSettings(12, 8, **{"samples": 16, "threads": 1, **more})
    scene = prepare(snapshot)
    stats = statistics(scene, settings, render(scene, settings))
    return json.loads(json.dumps(stats, allow_nan=False)), scene


def test_every_key_is_there_and_survives_json():
    stats, scene = told(room(make.diffuse(0.5), SOFT_LAMP))
    assert set(stats) >= KEYS
    assert stats["schema"] == SCHEMA
    assert stats["resolution"] == [12, 8]
    assert stats["samples"] == 16
    assert stats["cancelled"] is False
    assert stats["features"] == scene.features
    assert stats["triangles"] == len(scene.geometry.surface) - 1
    assert stats["emitters"]["area"] == 1
    assert stats["nonfinite"] == {"count": 0, "samples": []}


def test_times_add_up():
    seconds = told(room(make.diffuse(0.5)))[0]["seconds"]
    assert set(seconds) == {"export", "build", "render", "write", "other", "total"}
    assert all(value >= 0 for value in seconds.values())
    assert seconds["build"] > 0
    assert seconds["total"] == pytest.approx(sum(v for k, v in seconds.items() if k != "total"))


def test_rays_are_counted_by_kind():
    """One camera ray per sample; of a lone diffuse square at depth 2, one bounce and half a shadow ray."""
    square = (make.quad(9.0), UP, make.diffuse(0.5))
    sides = [make.looking((x, 0.0, z), (0, 0, 0)) for x, z in ((1, 1), (1, -1))]
    suns = [LightData("SUN", "sun", side, 1.0) for side in sides]
    snapshot = make.scene([square], make.orthographic((0, 0, 3), (0, 0, 0), 1.0), suns, make.world(1.0))
    stats, _ = told(snapshot, max_depth=2)
    n = 12 * 8 * 16
    assert stats["rays"]["camera"] == n
    assert stats["rays"]["bounce"] <= n
    assert (
        stats["rays"]["bounce"] > 0.99 * n
    )  # a direction exactly in the plane has weight 0 and is not traced
    assert (
        0.4 * n < stats["rays"]["shadow"] < 0.6 * n
    )  # the other sun stands below the surface; the sky is found by bounces
    assert stats["camera_samples_per_second"] == pytest.approx(n / stats["seconds"]["render"])
    assert stats["rays_per_second"] == pytest.approx(sum(stats["rays"].values()) / stats["seconds"]["render"])


def test_the_settings_are_all_there():
    stats, _ = told(room(make.diffuse(0.5)), border=(2, 1, 10, 7), seed=5)
    assert stats["settings"]["border"] == [2, 1, 10, 7]
    assert stats["settings"]["seed"] == 5
    assert stats["resolution"] == [8, 6]
    again = {k: tuple(v) if isinstance(v, list) else v for k, v in stats["settings"].items()}
    assert RenderSettings(**again) == RenderSettings(
        12, 8, samples=16, threads=1, border=(2, 1, 10, 7), seed=5
    )


def test_the_error_is_a_number_with_an_interval_around_it():
    error = told(room(make.diffuse(0.5)))[0]["error"]
    for name in ("mse", "relmse"):
        low, high = error[f"{name}_ci95"]
        assert 0 < low < error[name] < high
    single = told(room(make.diffuse(0.5)), samples=1)[0]["error"]
    assert set(single.values()) == {None}


def test_the_error_is_that_of_other_seeds():
    """E over seeds of the squared difference of two renders = the sum of their two stated errors."""
    snapshot = room(make.diffuse(0.5), SOFT_LAMP)
    scene, stated, images = prepare(snapshot), [], []
    for seed in range(8):
        how = RenderSettings(12, 8, samples=16, threads=1, sampler="independent", seed=seed)
        result = render(scene, how)
        stated.append(result.film.error()["mse"])
        images.append(result.image()[..., :3].astype(np.float64))
    true = np.var(images, axis=0, ddof=1).mean()
    # 288 numbers of 7 degrees of freedom, correlated between channels: 96 · 7 degrees, 5 % twice over
    assert true == pytest.approx(np.mean(stated), rel=0.3)


def test_coverage_lists_every_node_in_use():
    """Each with its material, node, state and effect; an exact one needs no words."""
    odd, grey = make.shader("BsdfNothingKnown", "odd"), make.diffuse(0.3)
    camera = make.perspective((0, 0, 5), (0, 0, 0))
    stats, _ = told(make.scene([(make.quad(), UP, odd), (make.quad(), UP, grey)], camera))
    state = {c["material"]: c["state"] for c in stats["coverage"]}
    assert state["diffuse"] == "exact"
    assert state["odd"] in ("approximate", "ignored")
    for entry in stats["coverage"]:
        assert set(entry) == {"material", "node", "state", "effect"}
        assert bool(entry["effect"]) == (entry["state"] != "exact")


def test_versions_name_what_can_change_an_image():
    found = versions()
    assert set(found) >= {"pt_engine", "python", "numpy", "embreex", "OpenImageIO", "bpy", "platform"}
    assert found["numpy"] == np.__version__
    assert all(isinstance(value, str) and value for value in found.values())


def test_peak_memory_is_in_bytes():
    """A Python process with numpy: more than 20 MB, less than 100 GB."""
    assert peak_memory() == 0 or 20e6 < peak_memory() < 100e9
