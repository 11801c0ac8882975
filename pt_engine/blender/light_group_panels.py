"""Light groups: the view layer's list, and which one an object or the world is in."""

from __future__ import annotations

import bpy

from .object_panels import DataPanel


class PTENGINE_VIEWLAYER_PT_light_groups(DataPanel, bpy.types.Panel):
    bl_label = "Light Groups"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    @classmethod
    def applies(cls, context):
        return context.view_layer is not None

    def draw(self, context):
        layer, row = context.view_layer, self.layout.row()
        groups = layer, "lightgroups", layer, "active_lightgroup_index"
        row.template_list("UI_UL_list", "lightgroups", *groups, rows=3)
        column = row.column(align=True)
        column.operator("scene.view_layer_add_lightgroup", icon="ADD", text="")
        column.operator("scene.view_layer_remove_lightgroup", icon="REMOVE", text="")
        column.separator()
        column.menu("VIEWLAYER_MT_lightgroup_sync", icon="DOWNARROW_HLT", text="")


class GroupPanel(DataPanel):
    """The group of something that may shine."""

    bl_label = "Light Group"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    @classmethod
    def applies(cls, context):
        return cls.owner(context) is not None

    def draw(self, context):
        owner, layer = self.owner(context), context.view_layer
        row = self.layout.row(align=True)
        row.use_property_split = True
        row.prop_search(owner, "lightgroup", layer, "lightgroups", results_are_suggestions=True)
        new = row.column(align=True)
        new.enabled = bool(owner.lightgroup) and owner.lightgroup not in layer.lightgroups
        new.operator("scene.view_layer_add_lightgroup", icon="ADD", text="").name = owner.lightgroup


class PTENGINE_OBJECT_PT_light_group(GroupPanel, bpy.types.Panel):
    bl_context = "object"

    @staticmethod
    def owner(context):
        return context.object


class PTENGINE_WORLD_PT_light_group(GroupPanel, bpy.types.Panel):
    bl_context = "world"

    @staticmethod
    def owner(context):
        return context.world


CLASSES = (
    PTENGINE_VIEWLAYER_PT_light_groups,
    PTENGINE_OBJECT_PT_light_group,
    PTENGINE_WORLD_PT_light_group,
)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
