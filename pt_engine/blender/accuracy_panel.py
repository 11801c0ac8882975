"""How wrong the last render still is and what it would take to be less wrong; the view layer's own passes."""

from __future__ import annotations

import bpy

from .object_panels import DataPanel
from .panels import RenderPanel
from .record import Session
from .words import duration, error_lines, ledger_lines
from .wrapping import listing

PASS_SWITCHES = ("use_pass_standard_error", "use_pass_sample_count", "use_pass_halves")


def error_section(layout, context, stats) -> None:
    """The error with its interval, and what ended the render."""
    listing(layout, context, error_lines(stats))


def prediction_section(layout, context, stats) -> None:
    """What the render foretold, and what half the error would cost."""
    lines = []
    if found := stats.get("prediction"):
        low, high = found["seconds_ci95"]
        when = f"{duration(found['seconds'])} ({duration(low)} to {duration(high)})"
        lines.append(f"Foretold: {100 * found['target']:.3g}% after {when}")
    lines.append(f"Half the error: about {duration(4 * stats['seconds']['render'])} of rendering")
    listing(layout, context, lines)


def ledger_section(layout, context, stats) -> None:
    """Where the time went, and a page with all of it."""
    listing(layout, context, ledger_lines(stats))
    layout.operator("pt_engine.open_report", icon="URL")


SECTIONS = (error_section, prediction_section, ledger_section)  # of the panel, from top to bottom


class PTENGINE_RENDER_PT_accuracy(RenderPanel, bpy.types.Panel):
    bl_label = "Accuracy"

    def draw(self, context):
        stats = Session.last.statistics() if Session.last else {}
        if not stats:
            self.layout.label(text="Nothing is rendered yet")
            return
        for section in SECTIONS:
            section(self.layout, context, stats)


class PTENGINE_VIEWLAYER_PT_passes(DataPanel, bpy.types.Panel):
    bl_label = "Accuracy Passes"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    @classmethod
    def applies(cls, context):
        return context.view_layer is not None

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        for name in PASS_SWITCHES:
            layout.prop(context.view_layer.pt_engine, name)


CLASSES = (PTENGINE_RENDER_PT_accuracy, PTENGINE_VIEWLAYER_PT_passes)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
