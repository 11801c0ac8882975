"""The engine inside Blender: what a render delivers, and what becomes of one that fails."""

import json

import bpy
import numpy as np
import pytest
from support.engine_scene import (
    HEIGHT,
    WIDTH,
    Recorder,
    engine_scene,
    exr,
    integrator_file,
    observed,
    rendered,
)
from support.exr import layers, pixels

from pt_engine.blender import plugins
from pt_engine.blender.record import Session


@pytest.fixture
def scene():
    return engine_scene()


def test_a_render_is_a_finite_picture_of_the_scene(scene, tmp_path):
    image = rendered(scene, tmp_path / "a.exr")
    assert image.shape == (HEIGHT, WIDTH, 4)
    assert np.isfinite(image).all()
    assert image[HEIGHT // 2, WIDTH // 2, 0] > image[0, 0, 0]  # the lit cube before a dim world
    assert (image[..., 3] == 1).all()


def test_percentage_scales_the_picture(scene, tmp_path):
    scene.render.resolution_percentage = 50
    assert rendered(scene, tmp_path / "a.exr").shape == (HEIGHT // 2, WIDTH // 2, 4)


def test_a_render_region_has_the_same_pixels_as_the_whole(scene, tmp_path):
    """With a box filter of one pixel a pixel's random numbers may depend on the region, its mean may not;
    with "normals" on flat faces every sample of an inner pixel is the same."""
    scene.pt_engine.integrator = "normals"
    whole = rendered(scene, tmp_path / "whole.exr")
    render = scene.render
    render.use_border = True
    render.border_min_x, render.border_max_x = 0.25, 0.75
    render.border_min_y, render.border_max_y = 0.5, 1.0
    window = slice(HEIGHT // 2, HEIGHT), slice(WIDTH // 4, 3 * WIDTH // 4)

    framed = rendered(scene, tmp_path / "framed.exr")
    assert framed.shape == whole.shape
    assert (framed[: HEIGHT // 2] == 0).all()
    inner = framed[window]

    render.use_crop_to_border = True
    cropped = rendered(scene, tmp_path / "cropped.exr")
    assert cropped.shape == (HEIGHT // 2, WIDTH // 2, 4)
    np.testing.assert_array_equal(cropped, inner)
    middle = (slice(0, HEIGHT // 8), slice(WIDTH // 8, 3 * WIDTH // 8))
    np.testing.assert_array_equal(inner[middle], whole[window][middle])


def test_a_transparent_film_leaves_the_sky_out(scene, tmp_path):
    scene.render.film_transparent = True
    image = rendered(scene, tmp_path / "a.exr")
    assert (image[0, 0] == 0).all()
    assert image[HEIGHT // 2, WIDTH // 2, 3] == 1


def test_each_view_layer_gets_its_own_picture(scene, tmp_path):
    hidden = bpy.data.collections.new("Hidden")
    scene.collection.children.link(hidden)
    cube = bpy.data.objects["Cube"]
    scene.collection.objects.unlink(cube)
    hidden.objects.link(cube)
    second = scene.view_layers.new("Without")
    second.layer_collection.children["Hidden"].exclude = True
    exr(scene, tmp_path / "layers.exr", multilayer=True)
    bpy.ops.render.render(write_still=True)
    found = layers(tmp_path / "layers.exr")
    assert set(found) == {"ViewLayer", "Without"}
    centre = HEIGHT // 2, WIDTH // 2
    assert found["ViewLayer"][centre][:3].max() > 4 * found["Without"][centre][:3].max() > 0
    assert list(Session.last.layers) == ["ViewLayer", "Without"]
    statistics = Session.last.statistics()
    each = [layer["seconds"]["render"] for layer in statistics["layers"].values()]
    assert statistics["seconds"]["render"] == pytest.approx(sum(each))


def test_an_animation_renders_every_frame(scene, tmp_path):
    cube = bpy.data.objects["Cube"]
    for frame, x in ((1, -1.0), (2, 1.0)):
        cube.location.x = x
        cube.keyframe_insert("location", frame=frame)
    scene.frame_start, scene.frame_end = 1, 2
    exr(scene, tmp_path / "f_")
    bpy.ops.render.render(animation=True)
    first, second = (pixels(tmp_path / f"f_000{n}.exr") for n in (1, 2))
    assert first[HEIGHT // 2, WIDTH // 4, 0] > second[HEIGHT // 2, WIDTH // 4, 0]
    assert Session.last.frame == 2


def test_the_same_seed_gives_the_same_bits_and_another_does_not(scene, tmp_path):
    first = rendered(scene, tmp_path / "a.exr")
    scene.render.threads = 2
    np.testing.assert_array_equal(rendered(scene, tmp_path / "b.exr"), first)
    scene.pt_engine.seed = 1
    assert (rendered(scene, tmp_path / "c.exr") != first).any()


def test_stopping_keeps_what_is_rendered(scene, tmp_path):
    scene.pt_engine.samples = 100_000
    with observed(Recorder(patience=2)) as recorder:
        image = rendered(scene, tmp_path / "a.exr")
    assert recorder.units <= 4
    assert image[HEIGHT // 2, WIDTH // 2, 0] > 0
    assert Session.last.statistics()["cancelled"]


def test_an_exception_inside_is_a_failed_render_and_not_a_crash(scene, tmp_path, own_integrators, capfd):
    plugins.load(integrator_file(tmp_path, "raising", "raise ValueError('no light today')"))
    scene.pt_engine.integrator = "raising"
    with (
        observed(Recorder()) as recorder,
        pytest.raises(RuntimeError, match="ValueError: no light today"),
    ):
        rendered(scene, tmp_path / "a.exr")
    assert recorder.failures == ["ValueError: no light today"]
    assert not (tmp_path / "a.exr").exists()
    assert "raising.py" in capfd.readouterr().err  # the traceback names the user's own line
    assert Session.last.failure
    scene.pt_engine.integrator = "path"
    assert rendered(scene, tmp_path / "a.exr").any()  # and the next render works


def test_samples_that_are_not_finite_are_dropped_and_told(scene, tmp_path, own_integrators):
    body = "L = np.ones_like(rays.o)\nL[:, ::7] = np.nan\nreturn L"
    plugins.load(integrator_file(tmp_path, "sometimes_nan", body))
    scene.pt_engine.integrator = "sometimes_nan"
    with observed(Recorder()) as recorder:
        image = rendered(scene, tmp_path / "a.exr")
    assert np.isfinite(image).all()
    assert any("non-finite" in headline for headline, _ in recorder.warnings)
    assert Session.last.statistics()["nonfinite"]["count"] > 0


def not_understood():
    """Give the cube a material with a node that the engine can't render exactly."""
    material = bpy.data.materials.new("Strange")
    if not material.node_tree:
        material.use_nodes = True
    tree = material.node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(tree.nodes.new("ShaderNodeBsdfHair").outputs[0], output.inputs["Surface"])
    bpy.data.objects["Cube"].data.materials.append(material)


def test_what_is_not_exact_is_told_before_rendering(scene, tmp_path):
    not_understood()
    with observed(Recorder()) as recorder:
        rendered(scene, tmp_path / "a.exr")
    assert any("Strange" in line for _, lines in recorder.warnings for line in lines)
    assert any(entry.material == "Strange" for entry in Session.last.coverage)


def test_strict_refuses_with_the_list(scene, tmp_path):
    not_understood()
    scene.pt_engine.strict = True
    with pytest.raises(RuntimeError, match=r"(?s)strict.*Strange"):
        rendered(scene, tmp_path / "a.exr")
    assert not (tmp_path / "a.exr").exists()


def test_no_limit_at_all_is_refused_without_a_window(scene, tmp_path):
    scene.pt_engine.samples = 0
    with pytest.raises(RuntimeError, match="never end"):
        rendered(scene, tmp_path / "a.exr")


def test_a_time_limit_ends_a_render_without_a_sample_limit(scene, tmp_path):
    scene.pt_engine.samples, scene.pt_engine.seconds = 0, 0.2
    assert rendered(scene, tmp_path / "a.exr").any()
    assert Session.last.statistics()["samples"] > 0


def test_statistics_are_written_where_the_scene_says(scene, tmp_path):
    scene.pt_engine.stats_path = str(tmp_path / "s.json")
    rendered(scene, tmp_path / "a.exr")
    statistics = json.loads((tmp_path / "s.json").read_text())
    assert statistics["schema"] == "pt_engine.stats/3"
    wanted = {
        "settings", "versions", "resolution", "samples", "seconds", "camera_samples_per_second", "rays",
        "peak_memory_bytes", "nonfinite", "features", "error", "coverage",
    }  # fmt: skip
    assert wanted <= set(statistics)
    assert set(statistics["seconds"]) == {"export", "build", "render", "write", "other", "total"}
    assert statistics["resolution"] == [WIDTH, HEIGHT]
    assert statistics["samples"] == 2
    assert {"mse", "mse_ci95", "relmse", "relmse_ci95"} <= set(statistics["error"])
