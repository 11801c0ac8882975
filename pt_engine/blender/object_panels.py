"""Panels of lights and objects for what Blender has only in Cycles' own panels."""

from __future__ import annotations

import bpy

from .compatibility import ENGINE

RAY_KINDS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")


class DataPanel:
    """A panel of the properties editor."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = frozenset({ENGINE})

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES and cls.applies(context)


class PTENGINE_LIGHT_PT_settings(DataPanel, bpy.types.Panel):
    bl_label = "Settings"
    bl_context = "data"

    @classmethod
    def applies(cls, context):
        return context.light is not None

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        light = context.light
        if light.type == "AREA":
            layout.prop(light, "spread")
        layout.prop(light, "use_shadow", text="Cast Shadow")
        if hasattr(light, "cycles"):
            layout.prop(light.cycles, "max_bounces")
            layout.prop(light.cycles, "use_multiple_importance_sampling", text="Multiple Importance")
            if light.type == "AREA":
                layout.prop(light.cycles, "is_portal", text="Portal")


class PTENGINE_LIGHT_PT_nodes(DataPanel, bpy.types.Panel):
    bl_label = "Nodes"
    bl_context = "data"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    @classmethod
    def applies(cls, context):
        return context.light is not None

    def draw(self, context):
        layout = self.layout
        light = context.light
        if hasattr(light, "use_nodes") and (bpy.app.version < (5, 0) or not light.node_tree):
            layout.prop(light, "use_nodes", icon="NODETREE")
        if light.node_tree and light.use_nodes:
            output = light.node_tree.get_output_node("ALL")
            if output:
                layout.template_node_view(light.node_tree, output, output.inputs["Surface"])


class PTENGINE_OBJECT_PT_ray_visibility(DataPanel, bpy.types.Panel):
    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def applies(cls, context):
        return context.object is not None and context.object.type not in {"EMPTY", "CAMERA", "ARMATURE"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        column = layout.column()
        for kind in RAY_KINDS:
            if kind != "shadow" or context.object.type != "LIGHT":
                column.prop(context.object, f"visible_{kind}", text=kind.replace("_", " ").title())
        column.prop(context.object, "is_shadow_catcher")


CLASSES = (PTENGINE_LIGHT_PT_settings, PTENGINE_LIGHT_PT_nodes, PTENGINE_OBJECT_PT_ray_visibility)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
