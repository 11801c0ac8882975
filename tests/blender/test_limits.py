"""Extremes that a user can ask for: images of 1 and of 268 million pixels, hundreds of layers and renders."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from support.engine_scene import engine_scene, exr, observed, rendered
from support.limits import cancelled, resident, resident_after_renders, seconds_of_layers, sized

from pt_engine.blender.record import Observer

EDGE = 16384
CYCLES, LAYERS, CANCELS = 50, 100, 20  # more of all in docs/limits.md; 200 cancelled in test_progressive.py


@pytest.fixture(name="scene")
def _scene():
    return engine_scene()


@pytest.mark.parametrize("size", [(4, 4), (1, 4), (4, 1), (1, 1)])
def test_the_smallest_images_are_images(scene, tmp_path, size):
    """4 is Blender's smallest; a border of one pixel is the smallest picture."""
    sized(scene, 4, 4)
    render = scene.render
    render.use_border = render.use_crop_to_border = size != (4, 4)
    render.border_max_x, render.border_max_y = size[0] / 4, size[1] / 4
    image = rendered(scene, tmp_path / "a.exr")
    assert image.shape == (size[1], size[0], 4)
    assert np.isfinite(image).all()


@pytest.mark.parametrize("corner", [0.5, 1 - 8 / EDGE], ids=["middle", "last"])
def test_a_few_pixels_of_a_huge_image_cost_only_themselves(scene, tmp_path, corner):
    """8 × 8 of 16,384²: those very pixels, and less memory than one row's film of the whole would take."""
    render = sized(scene, EDGE, EDGE).render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x = render.border_min_y = corner
    render.border_max_x = render.border_max_y = corner + 8 / EDGE
    before = resident()
    image = rendered(scene, tmp_path / "a.exr")
    assert image.shape == (8, 8, 4)
    assert (image[..., :3] > 0).all()  # the cube is in the middle, the sky in the corners
    assert resident() - before < 100e6  # the whole would take 29 GB


def test_all_of_a_huge_image_is_refused_where_it_does_not_fit(scene, tmp_path):
    sized(scene, EDGE, EDGE).pt_engine.memory_limit = 4096
    exr(scene, tmp_path / "a.exr")
    told = Told()
    with observed(told), pytest.raises(RuntimeError, match=r"16,384 × 16,384 pixels needs about 28\.\d+ GB"):
        bpy.ops.render.render(write_still=True)
    assert "GB are left" in told.failure
    assert not (tmp_path / "a.exr").exists()


def test_a_scene_that_does_not_fit_is_refused_with_the_number(scene, tmp_path):
    scene.objects["Cube"].modifiers.new("Fine", "SUBSURF").render_levels = 7
    scene.pt_engine.memory_limit = 8
    exr(scene, tmp_path / "a.exr")
    with pytest.raises(RuntimeError, match=r"the scene needs about 0\.\d+ GB of memory.*196,608 triangles"):
        bpy.ops.render.render(write_still=True)


class Told(Observer):
    """Remembers why a render failed."""

    failure = ""

    def on_failure(self, message: str) -> None:
        self.failure = message


@pytest.mark.slow
def test_layers_by_the_hundred(tmp_path):
    """All are rendered, and each takes what it takes alone."""
    seconds = seconds_of_layers(LAYERS, tmp_path)[:-1]
    assert np.median(seconds[-50:]) < 3 * np.median(seconds[:50]) + 0.05


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the system does not tell what is resident")
def test_render_after_render_takes_no_more_memory(tmp_path):
    """Open a file, render, and again: what is resident no longer grows after the first twenty.

    A leak of one film of 64 × 64 per render would be 40 MB here, one of the scene's arrays far more. 6 MB are
    allowed for Blender's own undo and heap.
    """
    sizes = resident_after_renders(CYCLES, tmp_path)
    assert np.median(sizes[-10:]) - np.median(sizes[20:30]) < 6e6


@pytest.mark.slow
def test_cancelled_at_any_moment_a_render_leaves_a_picture_and_no_thread(tmp_path):
    """Some are done before."""
    assert cancelled(CANCELS, tmp_path) > CANCELS // 2
