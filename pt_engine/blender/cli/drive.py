"""Blender's own render operator, driven: the one way into the engine."""

from __future__ import annotations

from contextlib import contextmanager

import bpy

from ..record import Observer, RenderRecord, Session
from .blendfile import choose_view_layer
from .failure import Failure
from .terminal import unechoed


def run_engine(scene, view_layer: str, observer) -> RenderRecord:
    """Render the scene with Blender's operator while `observer` follows."""
    Session.last = None
    with following(observer):
        try:
            with unechoed():
                bpy.ops.render.render(scene=scene.name, layer=view_layer)
        except RuntimeError as error:
            raise Failure(observer.failure or plain(error)) from error
    if observer.failure or Session.last is None:
        raise Failure(observer.failure or "Blender did not call the engine")
    return Session.last


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
