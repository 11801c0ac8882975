"""The current Blender file rendered by Cycles and by us, both twice."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
from support.shared_scenes import read_exr

from pt_engine.blender.export.scene import export_scene
from pt_engine.render import integrators  # noqa: F401  (fills the registry)
from pt_engine.render.progressive import render
from pt_engine.render.settings import RenderSettings
from pt_engine.scene.prepare import prepare

BOUNCES = 7
OVERRIDES = {
    "device": "CPU",
    "use_adaptive_sampling": False,
    "use_denoising": False,
    "use_guiding": False,
    "use_fast_gi": False,
    "sample_clamp_direct": 0.0,
    "sample_clamp_indirect": 0.0,
    "blur_glossy": 0.0,
    "light_sampling_threshold": 0.0,
    "caustics_reflective": True,
    "caustics_refractive": True,
    "max_bounces": BOUNCES,
    "diffuse_bounces": BOUNCES,
    "glossy_bounces": BOUNCES,
    "transmission_bounces": BOUNCES,
    "transparent_max_bounces": BOUNCES,
    "min_light_bounces": 0,
    "min_transparent_bounces": 0,
}

Pair = tuple[np.ndarray, np.ndarray]


def by_cycles(samples: int, size: tuple[int, int], folder: Path, **more: Any) -> Pair:
    """RGBA images of seeds 0 and 1, top row first; `more` are settings of Cycles."""
    scene = bpy.context.scene
    choose_cycles(samples, size, **more)
    into_exr()
    images = []
    for seed in (0, 1):
        scene.cycles.seed = seed
        scene.render.filepath = str(folder / f"cycles{seed}.exr")
        bpy.ops.render.render(write_still=True)
        images.append(read_exr(scene.render.filepath))
    return images[0], images[1]


def into_exr() -> None:
    """Have the scene's pictures written as they are, with alpha."""
    form = bpy.context.scene.render.image_settings
    if hasattr(form, "media_type"):
        form.media_type = "IMAGE"
    form.file_format, form.color_mode, form.color_depth = "OPEN_EXR", "RGBA", "32"


def choose_cycles(samples: int, size: tuple[int, int], **more: Any) -> None:
    """Set the scene to be rendered by Cycles, which is to take no short cuts."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    for name, value in (OVERRIDES | more).items():
        if hasattr(scene.cycles, name):
            setattr(scene.cycles, name, value)
    scene.cycles.samples = samples
    settings = scene.render
    settings.resolution_x, settings.resolution_y = size
    settings.resolution_percentage = 100
    settings.use_compositing = settings.use_sequencer = False


def by_engine(samples: int, size: tuple[int, int], **more: Any) -> Pair:
    """The same by our own path tracer, with the file's filter; `more` are render settings."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    snapshot = export_scene(
        bpy.context.evaluated_depsgraph_get(),
        frame_set=lambda frame, part: scene.frame_set(frame, subframe=part),
    )
    ours = prepare(snapshot, scene.render.film_transparent)
    images = []
    options: dict[str, Any] = {
        "max_depth": BOUNCES + 2,  # Cycles counts the bounces between the first surface and the last
        "transparent_depth": BOUNCES,
        "pixel_filter": scene.cycles.pixel_filter_type,
        "filter_width": scene.cycles.filter_width,
        "film_transparent": scene.render.film_transparent,
    }
    for seed in (0, 1):
        settings = RenderSettings(*size, samples=samples, seed=seed, **(options | more))
        images.append(render(ours, settings).image()[::-1])
    return images[0], images[1]
