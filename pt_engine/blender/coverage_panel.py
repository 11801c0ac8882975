"""What is not rendered exactly, by material, with a way to each node: panels of two properties tabs.

The list is filled before the first pass of a render, and by the Inspect button without one.
"""

from __future__ import annotations

import bpy

from .compatibility import ENGINE
from .node_places import place_of, show
from .record import Session
from .words import inexact
from .wrapping import wrapped

LINES = 24  # findings that are listed


def findings() -> dict[str, list]:
    """The entries that are not exact, by owner; of the last inspection, else of the last render."""
    record = Session.checked or Session.last
    by_owner: dict[str, list] = {}
    for entry in inexact(record.coverage) if record is not None else ():
        by_owner.setdefault(entry.material, []).append(entry)
    return by_owner


class PTENGINE_OT_show_node(bpy.types.Operator):
    """Select what has this node, make the node active and frame it in the open shader editors"""

    bl_idname = "pt_engine.show_node"
    bl_label = "Show the Node"
    bl_options = {"UNDO"}  # noqa: RUF012

    owner: bpy.props.StringProperty(name="Owner", description="Material, world or light that has the node")
    node: bpy.props.StringProperty(name="Node", description="Its name, behind those of its groups")

    def execute(self, context):
        place = place_of(self.owner, self.node)
        if place is None:
            self.report({"WARNING"}, f"{self.owner} has no node {self.node} now")
            return {"CANCELLED"}
        show(context, place)
        return {"FINISHED"}


class CoveragePanel:
    """A panel that is drawn in one of the properties editor's tabs."""

    bl_label = "Coverage"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012
    COMPAT_ENGINES = frozenset({ENGINE})


class PTENGINE_RENDER_PT_coverage(CoveragePanel, bpy.types.Panel):
    bl_context = "render"

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(context.scene.pt_engine, "strict")
        layout.operator("pt_engine.check_scene", icon="VIEWZOOM")
        if Session.checked or Session.last:
            draw_findings(layout, context, findings())


class PTENGINE_MATERIAL_PT_coverage(CoveragePanel, bpy.types.Panel):
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES and context.material is not None

    def draw(self, context):
        layout = self.layout
        layout.operator("pt_engine.check_scene", icon="VIEWZOOM")
        name = context.material.name
        if record := Session.checked or Session.last:
            if all(entry.material != name for entry in record.coverage):
                layout.label(text="Not rendered, or nothing at its output", icon="INFO")
                return
            own = {owner: found for owner, found in findings().items() if owner == name}
            draw_findings(layout, context, own)


def draw_findings(layout, context, by_owner) -> None:
    """A box for each owner; in it each finding, what it means, and the way to its node."""
    if not by_owner:
        layout.label(text="All of it is rendered exactly", icon="CHECKMARK")
    left = LINES
    for owner, entries in by_owner.items():
        if left <= 0:
            break
        column = layout.box().column(align=True)
        column.label(text=owner)
        for entry in entries[:left]:
            row = column.row()
            icon = "ERROR" if entry.state == "ignored" else "DOT"
            row.label(text=f"{entry.node}: {entry.state}", icon=icon)
            if place_of(owner, entry.node) is not None:
                jump = row.operator("pt_engine.show_node", text="", icon="RESTRICT_SELECT_OFF")
                jump.owner, jump.node = owner, entry.node
            for line in wrapped(entry.effect, context):
                column.label(text=line, icon="BLANK1")
        left -= len(entries)
    hidden = sum(map(len, by_owner.values())) - LINES
    if hidden > 0:
        layout.label(text=f"and {hidden} more")


CLASSES = (PTENGINE_OT_show_node, PTENGINE_RENDER_PT_coverage, PTENGINE_MATERIAL_PT_coverage)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
