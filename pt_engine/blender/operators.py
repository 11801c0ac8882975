"""What the panels' buttons do."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..report.optional import MissingPackage
from ..report.page import check_packages
from ..scene.prepare import prepare
from . import plugins
from .export import ExportError, export_scene
from .pages import write_page
from .record import RenderRecord, Session
from .words import inexact


class PTENGINE_OT_load_integrators(bpy.types.Operator):
    """Run the Python files named here and add their integrators to the list"""

    bl_idname = "pt_engine.load_integrators"
    bl_label = "Load Integrators"

    def execute(self, context):
        paths = plugins.SEPARATOR.join(
            bpy.path.abspath(part.strip())
            for part in context.scene.pt_engine.python_files.split(plugins.SEPARATOR)
            if part.strip()
        )
        try:
            names = plugins.load_all(paths)
        except plugins.PluginError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, "Loaded " + ", ".join(names) if names else "No file is named")
        return {"FINISHED"}


class PTENGINE_OT_check_scene(bpy.types.Operator):
    """List what of this scene is not rendered exactly, without rendering it"""

    bl_idname = "pt_engine.check_scene"
    bl_label = "Inspect"

    def execute(self, context):
        scene = context.scene
        try:
            prepared = prepare(export_scene(context.evaluated_depsgraph_get()), scene.render.film_transparent)
        except ExportError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        record = RenderRecord(scene.frame_current, scene.name, coverage=tuple(prepared.coverage))
        features = dict(prepared.features)
        if scene.render.use_motion_blur:  # other frames would undo what is posed but not keyed
            features["motion blur"] = "not looked for: it takes other frames"
        record.layers[context.view_layer.name] = {"features": features}
        Session.checked = record
        number = len(inexact(prepared.coverage))
        text = f"Not rendered exactly: {number}" if number else "All of it is rendered exactly"
        self.report({"INFO"}, text)
        return {"FINISHED"}


class PTENGINE_OT_open_report(bpy.types.Operator):
    """Open a page about the last render: its error, where its time went, how to make it again"""

    bl_idname = "pt_engine.open_report"
    bl_label = "Open Report"

    @classmethod
    def poll(cls, context):
        return Session.last is not None and bool(Session.last.layers)

    def execute(self, context):
        record = Session.last
        path = Path(bpy.app.tempdir) / f"pt_engine-report-{record.frame}.html"
        try:
            check_packages()
            write_page(path, context.scene, record, record.statistics(), record.error)
        except (MissingPackage, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if not bpy.app.background:
            bpy.ops.wm.url_open(url=path.as_uri())
        self.report({"INFO"}, f"Report: {path}")
        return {"FINISHED"}


CLASSES = (PTENGINE_OT_load_integrators, PTENGINE_OT_check_scene, PTENGINE_OT_open_report)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
