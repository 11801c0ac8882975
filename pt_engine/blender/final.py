"""A final render: export, prepare, render, deliver; and tell on the way how it goes."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import bpy

from ..render import integrators  # noqa: F401  fills the registry
from ..render.ledger import Ledger
from ..render.memory import check_film, room, room_for_scene, wavefront_that_fits
from ..render.progressive import render
from ..render.stats import statistics
from ..report.error_picture import error_picture
from ..scene.another_view import through
from ..scene.memory import snapshot_bytes
from ..scene.prepare import prepare
from . import passes
from .export import export_scene
from .failure import Failure
from .files import check_writable, written
from .nonfinite import add_commands, headline, lines
from .picture import Picture
from .record import RenderRecord, Session, close_times, write_json
from .refusal import Refusal
from .settings import settings_of
from .views import views
from .words import coverage_lines, inexact, shortened, status

STATUS_INTERVAL = {False: 0.2, True: 2.0}  # seconds; in background mode each one is a line on the terminal


def final_render(engine, depsgraph) -> None:
    """Render one view layer of one frame into Blender's result, view by view."""
    started = time.perf_counter()
    scene = depsgraph.scene_eval
    record = record_of(engine, scene)
    told_to = statistics_file(scene)
    settings = settings_of(scene, engine.resolution_x, engine.resolution_y)
    settings = replace(settings, half_buffers=passes.wants_halves(depsgraph.view_layer_eval))
    films = passes.films(depsgraph.view_layer_eval)
    check_film(settings, room(scene.pt_engine.memory_limit << 20), films)

    engine.update_stats("", "Exporting the scene")
    snapshot = export_scene(depsgraph, frame_set=engine.frame_set)
    exported = time.perf_counter() - started
    for view, seen, prepared in prepared_views(engine, depsgraph, snapshot, settings, films):
        if Session.observer.takes_over(prepared, settings, seen):
            return
        left = room(scene.pt_engine.memory_limit << 20, prepared.bytes)
        settings = wavefront_that_fits(settings, left, films)
        stats = render_view(engine, depsgraph, prepared, settings, view)
        stats["seconds"]["export"] = exported
        close_times(stats["seconds"], time.perf_counter() - started)
        layer = depsgraph.view_layer_eval.name
        record.layers[f"{layer}, {view}" if view else layer] = stats
        started, exported = time.perf_counter(), 0.0  # the one export is part of the first view's time
    if told_to:
        with refused_in_vain(), written(told_to):
            write_json(told_to, record.statistics())


def statistics_file(scene) -> Path | None:
    """Where statistics are wanted, the frame's number for `####`; refused before the render if in vain."""
    if not scene.pt_engine.stats_path:
        return None
    path = Path(bpy.path.abspath(scene.pt_engine.stats_path))
    frame = scene.frame_current
    path = path.with_name(re.sub("#+", lambda run: f"{frame:0{len(run[0])}}", path.name))
    with refused_in_vain():
        check_writable(path)
    return path


@contextmanager
def refused_in_vain() -> Iterator[None]:
    """What can't be written is told as the statistics' failure."""
    try:
        yield
    except Failure as failure:
        raise Refusal(f"statistics: {failure}") from failure


def prepared_views(engine, depsgraph, snapshot, settings, films: int):
    """Each view's name, its snapshot and its scene, prepared and told of once where that can be."""
    own, record, prepared = depsgraph.scene_eval.pt_engine, engine.pt_record, None
    for view, seen in views(engine, depsgraph, snapshot, (engine.resolution_x, engine.resolution_y)):
        if not Session.observer.wants(view):
            continue
        first, prepared = prepared is None, prepared and through(prepared, seen)
        if prepared is None:
            engine.update_stats("", "Preparing the scene")
            prepared = prepared_to_fit(seen, settings, own, films)
        if first:  # a camera changes nothing in the coverage
            record.coverage = tuple(dict.fromkeys(chain(record.coverage, prepared.coverage)))
            tell_coverage(engine, prepared.coverage, own.strict)
        yield view, seen, prepared


def prepared_to_fit(snapshot, settings, own, films: int):
    """The scene, placed so that it fits in what the machine has free, or in what the user allows."""
    left = room(own.memory_limit << 20, snapshot_bytes(snapshot))
    spare = room_for_scene(settings, left, films)
    return prepare(snapshot, settings.film_transparent, own.texture_memory << 20, spare)


def render_view(engine, depsgraph, prepared, settings, view: str) -> dict[str, Any]:
    """One picture of a prepared scene; its statistics."""
    layer = depsgraph.view_layer_eval.name
    x0, y0, x1, y1 = settings.window
    meter = Meter(engine)
    passes.add_to(engine, depsgraph.view_layer_eval)
    with Picture(engine, layer, (x1 - x0, y1 - y0), view) as picture:

        def on_progress(progress) -> None:
            meter.tell(progress)
            picture.show_progress(progress)

        ledger = Ledger()
        result = render(prepared, settings, on_progress, meter.should_stop, ledger)
        for name, image in passes.images(depsgraph.view_layer_eval, result):
            picture.fill(name, image)
        picture.show(result.image())

    stats = statistics(prepared, settings, result, ledger)
    frame = depsgraph.scene_eval.frame_current
    add_commands(stats["nonfinite"]["samples"], settings, bpy.data.filepath, frame, layer, view)
    stats["versions"]["blender"] = bpy.app.version_string
    stats["view_layer"] = layer
    Session.observer.on_film(result.film)
    if not bpy.app.background:
        engine.pt_record.error = error_picture(result.film)
    tell_nonfinite(engine, stats)
    return stats


class Meter:
    """Passes progress on to Blender and to whoever else follows, not more often than anyone can read."""

    def __init__(self, engine) -> None:
        self.engine = engine
        self.interval = STATUS_INTERVAL[bpy.app.background]
        self.told = -self.interval

    def tell(self, progress) -> None:
        """After every unit of work."""
        Session.observer.on_progress(progress)
        if progress.elapsed - self.told >= self.interval:
            self.told = progress.elapsed
            self.engine.update_stats("", status(progress))
            self.engine.update_progress(progress.fraction)

    def should_stop(self) -> bool:
        """Whether the user has had enough."""
        return bool(self.engine.test_break()) or Session.observer.should_stop()


def record_of(engine, scene) -> RenderRecord:
    """The record of this frame: one for all its view layers, a new one for each new render."""
    record = getattr(engine, "pt_record", None)
    if record is None or record.frame != scene.frame_current:
        record = RenderRecord(scene.frame_current, scene.name)
        engine.pt_record = Session.last = record
        Session.checked = None  # this render's own findings are newer
    return record


def tell_coverage(engine, coverage, strict: bool) -> None:
    """Warn of what is not rendered exactly, or refuse to render it."""
    lines = coverage_lines(coverage)
    if lines and strict:
        raise Refusal("strict: this scene asks for what is not rendered exactly:\n  " + "\n  ".join(lines))
    if lines:
        warn(engine, f"Not rendered exactly ({len(inexact(coverage))}):", lines)


def tell_nonfinite(engine, stats) -> None:
    """Warn of samples that had to be dropped."""
    if number := stats["nonfinite"]["count"]:
        warn(engine, headline(number), lines(stats["nonfinite"]["samples"]))


def warn(engine, headline: str, lines: list[str]) -> None:
    """Tell the observer all of it, or else Blender's user the first few lines."""
    if not Session.observer.on_warning(headline, lines):
        engine.report({"WARNING"}, "\n  ".join([headline, *shortened(lines)]))
