"""The commands: render and replay each as one render through Blender's own operator; the table of all."""

from __future__ import annotations

import time

from ...render.replay import replay
from ...report.tables import plural
from .. import registration
from ..failure import Failure
from ..files import check_writable, write_all
from ..output import save_exr, save_png
from ..pages import write_page
from ..passes import switch_on
from ..record import Observer, close_times, write_json
from .blendfile import choose_view_layer, open_scene
from .comparison import compare_command, page_for, whatif_command
from .drive import run_engine
from .inspection import coverage_command, explain_command
from .terminal import Terminal, closing_line


def render_command(arguments) -> None:
    """Render a frame; write EXR, PNG and statistics, also of one that was interrupted; say how it went."""
    registration.register()
    outputs = [path for path in (arguments.output, arguments.png, arguments.stats) if path]
    page = page_for(arguments)
    scene = open_scene(arguments)
    if arguments.passes:
        for layer in scene.view_layers:
            switch_on(layer)
    for path in outputs:
        check_writable(path)
    started = time.perf_counter()
    with Terminal(arguments.quiet, arguments.progress) as terminal:
        record = run_engine(scene, choose_view_layer(scene, arguments.view_layer), terminal)
    if terminal.interrupted and not terminal.samples:
        raise Failure("interrupted before the first sample was complete; nothing was written")
    rendered = time.perf_counter()
    written = ", ".join(map(str, save_exr(arguments.output, scene)))
    if arguments.png:
        save_png(arguments.png, scene, record.has_holes)
    statistics = record.statistics()
    statistics["seconds"]["write"] = time.perf_counter() - rendered
    close_times(statistics["seconds"], time.perf_counter() - started)
    files: list = []
    if arguments.stats:
        files.append((arguments.stats, lambda: write_json(arguments.stats, statistics)))
    if page:
        error = terminal.error_picture
        files.append(
            (arguments.report, lambda: write_page(arguments.report, scene, record, statistics, error))
        )
    write_all(files)
    if terminal.interrupted:
        raise Failure(f"interrupted after {plural(terminal.samples, 'sample')}: {written} has no more")
    if not arguments.quiet:
        print(closing_line(written, statistics))


def replay_command(arguments) -> None:
    """Print one path, as the render with the same options walked it."""
    registration.register()
    scene = open_scene(arguments)
    observer = Replaying(*arguments.pixel, arguments.sample, arguments.view)
    run_engine(scene, choose_view_layer(scene, arguments.view_layer), observer)
    if not observer.lines:
        raise Failure(f"no view {arguments.view!r} is rendered in {arguments.file}")
    print("\n".join(observer.lines))


class Replaying(Observer):
    """Takes the prepared scene and walks one path in it in place of the render."""

    def __init__(self, x: int, y: int, sample: int, view: str | None) -> None:
        self.x, self.y, self.sample, self.view = x, y, sample, view
        self.lines: list[str] = []
        self.failure = ""

    def wants(self, view: str) -> bool:
        return self.view in (None, view)

    def takes_over(self, scene, settings, snapshot) -> bool:
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
    "compare": compare_command,
    "whatif": whatif_command,
}
