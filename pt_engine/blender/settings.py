"""What Blender's and the engine's own properties say, as `RenderSettings`."""

from __future__ import annotations

import bpy

from ..render.integrator import INTEGRATORS
from ..render.settings import RenderSettings
from .refusal import Refusal

FILTERS = ("BLACKMAN_HARRIS", "GAUSSIAN", "BOX")  # as Cycles names them, too


def settings_of(scene, width: int, height: int) -> RenderSettings:
    """Settings of a final render of `width` × `height` pixels (the full image, percentage applied)."""
    own = scene.pt_engine
    if endless(own) and bpy.app.background:
        raise Refusal(
            "neither samples, time nor error are limited: without a window this render would never end"
        )
    kind, filter_width = pixel_filter(scene)
    return RenderSettings(
        width=width,
        height=height,
        border=border(scene.render, width, height),
        samples=own.samples,
        seconds=own.seconds,
        target_error=own.target_error,
        target_percentile=own.target_percentile if own.target_of == "PIXELS" else 0.0,
        min_samples=own.min_samples,
        adaptive=own.adaptive and adapts(own),
        seed=own.seed,
        threads=scene.render.threads if scene.render.threads_mode == "FIXED" else 0,
        integrator=integrator(own),
        max_depth=own.max_depth,
        rr_depth=own.rr_depth,
        transparent_depth=own.transparent_depth,
        clamp_direct=own.clamp_direct,
        clamp_indirect=own.clamp_indirect,
        sampler=own.sampler,
        pixel_filter=kind,
        filter_width=filter_width,
        film_transparent=scene.render.film_transparent,
    )


def endless(own) -> bool:
    """Whether nothing ends the render."""
    return own.samples == 0 and own.seconds == 0 and own.target_error == 0


def adapts(own) -> bool:
    """Whether adaptive sampling knows how many samples a noisy pixel may get."""
    return own.samples > 0 or own.target_error > 0


def integrator(own) -> str:
    """The chosen integrator's name; one that is not registered is refused."""
    if own.integrator not in INTEGRATORS:
        raise Refusal(
            "the integrator that this file was saved with is not known here: load the file that defines it "
            f"({own.python_files or 'none is named'}) or choose one of {', '.join(INTEGRATORS)}"
        )
    return own.integrator


def border(render, width: int, height: int) -> tuple[int, int, int, int] | None:
    """Blender's render region in pixels, rounded as Blender rounds it; None for the whole image."""
    if not render.use_border:
        return None
    x0, x1 = int(render.border_min_x * width), int(render.border_max_x * width)
    y0, y1 = int(render.border_min_y * height), int(render.border_max_y * height)
    if x1 <= x0 or y1 <= y0:
        raise Refusal("the render region is smaller than a pixel")
    return x0, y0, x1, y1


def pixel_filter(scene) -> tuple[str, float]:
    """Kind and width in pixels: the engine's own, or with FILE what the file says to Cycles."""
    own = scene.pt_engine
    kind, width = own.pixel_filter, own.filter_width
    if kind == "FILE":
        cycles = getattr(scene, "cycles", None)
        kind = getattr(cycles, "pixel_filter_type", FILTERS[0])
        width = getattr(cycles, "filter_width", scene.render.filter_size)
    return kind, 1.0 if kind == "BOX" else width
