"""What an image and the threads that make it take in memory, and the wavefront that fits in what is left."""

from __future__ import annotations

import os
from dataclasses import replace

from ..core.free_memory import free_memory, smallest
from ..scene.memory import TooLarge, gigabytes
from .schedule import LARGEST_PASS, WAVES
from .settings import RenderSettings

FILM = 60  # bytes a pixel: sums, counts and the pixels' order; sums of bright samples take up to 48 more
PICTURE = 48  # bytes a pixel: what is handed over at the end, and the two copies that Blender makes of it
LANE = 750  # bytes of a path under way, and of what shades it
WAITING = 110  # bytes of a path that waits for its wave's turn: its state, its ray, its radiance
SMALLEST = 1 << 12  # lanes: a smaller wavefront would spend its time in Python


def room(limit: int = 0, spent: int = 0) -> int | None:
    """Bytes that a render may still take; None where nobody knows.

    Parameters
    ----------
    limit : int
        What it may take altogether; 0 for what the machine has free.
    spent : int
        What of that it has taken.
    """
    return smallest(free_memory(), limit - spent if limit else None)


def image_bytes(settings: RenderSettings, films: int = 1) -> int:
    """Of the window's films, and of the wavefronts or, when these are done, of the picture."""
    x0, y0, x1, y1 = settings.window
    pixels = (x1 - x0) * (y1 - y0)
    threads = settings.threads or os.cpu_count() or 1
    lanes, unit = (min(count * settings.lanes, pixels * LARGEST_PASS) for count in (1, WAVES))
    return FILM * films * pixels + max(threads * (LANE * lanes + WAITING * unit), PICTURE * pixels)


def least(settings: RenderSettings, films: int = 1) -> int:
    """Of a render with the smallest wavefronts, without the scene."""
    return image_bytes(replace(settings, lanes=min(settings.lanes, SMALLEST)), films)


def room_for_scene(settings: RenderSettings, left: int | None, films: int = 1) -> int | None:
    """What of the bytes that are left the scene may have."""
    return None if left is None else left - least(settings, films)


def check_film(settings: RenderSettings, left: int | None, films: int = 1) -> None:
    """Refuse an image that does not fit, before there is any.

    Raises
    ------
    TooLarge
    """
    needed = least(settings, films)
    if left is not None and needed > left:
        x0, y0, x1, y1 = settings.window
        raise TooLarge(
            f"an image of {x1 - x0:,} × {y1 - y0:,} pixels needs about {gigabytes(needed)} of "
            f"memory, and {gigabytes(left)} are left: render fewer pixels, or a part of them (Render Region)"
        )


def wavefront_that_fits(settings: RenderSettings, left: int | None, films: int = 1) -> RenderSettings:
    """The settings with a wavefront small enough for the bytes that are left; it changes no image."""
    while left is not None and settings.lanes > SMALLEST:
        if image_bytes(settings, films) <= left:
            break
        settings = replace(settings, lanes=max(SMALLEST, settings.lanes // 2))
    return settings
