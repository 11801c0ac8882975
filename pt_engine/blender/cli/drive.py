"""Blender's own render operator, driven: the one way into the engine."""

from __future__ import annotations

from contextlib import contextmanager

import bpy

from ..failure import Failure
from ..record import Observer, RenderRecord, Session
from .blendfile import choose_view_layer
from .chatter import unechoed


def run_engine(scene, view_layer: str, observer) -> RenderRecord:
    """Render one view layer with Blender's operator while `observer` follows."""
    Session.last = None
    for layer in scene.view_layers:  # the operator's own `layer` counts only in a window
        layer.use = layer.name == view_layer
    with following(observer):
        try:
            with unechoed():
                bpy.ops.render.render(scene=scene.name)
        except RuntimeError as error:
            raise Failure(observer.failure or explained(plain(error), scene.render)) from error
    if observer.failure or Session.last is None:
        raise Failure(observer.failure or "Blender did not call the engine")
    return Session.last


def explained(message: str, render) -> str:
    """What Blender says before it calls the engine, with the numbers that made it say so."""
    if "too small" not in message:
        return message
    part = ", and its render region" if render.use_border else ""
    size = f"{render.resolution_x}x{render.resolution_y} at {render.resolution_percentage} %{part}"
    return f"{message}: it has less than a pixel ({size})"


def plain(error: Exception) -> str:
    """Blender's own words without its prefix."""
    return str(error).strip().removeprefix("Error: ")


@contextmanager
def following(observer: Observer):
    """`observer` follows the renders inside."""
    before, Session.observer = Session.observer, observer
    try:
        yield
    finally:
        Session.observer = before


class Taken(Observer):
    """Takes the prepared scene, its settings and its snapshot in place of a render."""

    def __init__(self) -> None:
        self.scene = self.settings = self.snapshot = None
        self.failure = ""

    def takes_over(self, scene, settings, snapshot) -> bool:
        self.scene, self.settings, self.snapshot = scene, settings, snapshot
        return True

    def on_warning(self, headline: str, lines: list[str]) -> bool:
        return True

    def on_failure(self, message: str) -> None:
        self.failure = message


def taken(scene, view_layer: str | None) -> Taken:
    """What a render of the scene would start from."""
    observer = Taken()
    run_engine(scene, choose_view_layer(scene, view_layer), observer)
    return observer
