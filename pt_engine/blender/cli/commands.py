"""The commands: render and replay each as one render through Blender's own operator; the table of all."""

from __future__ import annotations

import time
from contextlib import contextmanager

import bpy

from ...render.replay import replay
from .. import registration
from ..record import Observer, RenderRecord, Session, write_json
from .blendfile import choose_view_layer, open_scene
from .failure import Failure
from .inspection import coverage_command, explain_command
from .output import check_writable, save_exr, save_png
from .terminal import Terminal, closing_line, unechoed


def render_command(arguments) -> None:
    """Render a frame; write EXR, PNG and statistics; say how it went."""
    registration.register()
    outputs = [path for path in (arguments.output, arguments.png, arguments.stats) if path]
    scene = open_scene(arguments)
    for path in outputs:
        check_writable(path)
    started = time.perf_counter()
    with Terminal(arguments.quiet, arguments.progress) as terminal:
        record = run_engine(scene, choose_view_layer(scene, arguments.view_layer), terminal)
    if terminal.interrupted:
        raise Failure(f"interrupted after {terminal.samples} samples; nothing was written")
    rendered = time.perf_counter()
    save_exr(arguments.output, scene)
    if arguments.png:
        save_png(arguments.png, scene, record.has_holes)
    statistics = record.statistics()
    statistics["seconds"]["write"] = time.perf_counter() - rendered
    statistics["seconds"]["total"] = time.perf_counter() - started
    if arguments.stats:
        write_json(arguments.stats, statistics)
    if not arguments.quiet:
        print(closing_line(arguments.output, statistics))


def replay_command(arguments) -> None:
    """Print one path, as the render with the same options walked it."""
    registration.register()
    scene = open_scene(arguments)
    observer = Replaying(*arguments.pixel, arguments.sample)
    run_engine(scene, choose_view_layer(scene, arguments.view_layer), observer)
    print("\n".join(observer.lines))


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


class Replaying(Observer):
    """Takes the prepared scene and walks one path in it in place of the render."""

    def __init__(self, x: int, y: int, sample: int) -> None:
        self.x, self.y, self.sample = x, y, sample
        self.lines: list[str] = []
        self.failure = ""

    def takes_over(self, scene, settings) -> bool:
        try:
            self.lines = list(replay(scene, settings, self.x, self.y, self.sample).lines())
        except ValueError as error:
            self.failure = str(error)
        return True

    def on_warning(self, headline: str, lines: list[str]) -> bool:
        return True

    def on_failure(self, message: str) -> None:
        self.failure = message


COMMANDS = {
    "render": render_command,
    "replay": replay_command,
    "coverage": coverage_command,
    "explain": explain_command,
}
