"""Motion blur: the shutter's curve, and what of an object's motion is blurred."""

from __future__ import annotations

import bpy

from .object_panels import DataPanel
from .panels import RenderPanel

SHAPES = ("SMOOTH", "ROUND", "ROOT", "SHARP", "LINE", "MAX")
ICONS = ("SMOOTHCURVE", "SPHERECURVE", "ROOTCURVE", "SHARPCURVE", "LINCURVE", "NOCURVE")


class PTENGINE_RENDER_PT_shutter_curve(RenderPanel, bpy.types.Panel):
    bl_label = "Shutter Curve"
    bl_parent_id = "PTENGINE_RENDER_PT_motion_blur"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context):
        layout, render = self.layout, context.scene.render
        layout.active = render.use_motion_blur
        layout.template_curve_mapping(render, "motion_blur_shutter_curve")
        row = layout.row(align=True)
        for shape, icon in zip(SHAPES, ICONS, strict=True):
            row.operator("render.shutter_curve_preset", icon=icon, text="").shape = shape


class PTENGINE_OBJECT_PT_motion_blur(DataPanel, bpy.types.Panel):
    bl_label = "Motion Blur"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    @classmethod
    def applies(cls, context):
        return hasattr(context.object, "cycles") and context.object.type != "LIGHT"

    def draw(self, context):
        layout, own = self.layout, context.object.cycles
        layout.use_property_split = True
        layout.active = context.scene.render.use_motion_blur
        layout.prop(own, "use_motion_blur")
        column = layout.column()
        column.active = own.use_motion_blur
        column.prop(own, "motion_steps", text="Steps")
        if context.object.type != "CAMERA":
            column.prop(own, "use_deform_motion", text="Deformation")


CLASSES = (PTENGINE_RENDER_PT_shutter_curve, PTENGINE_OBJECT_PT_motion_blur)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
