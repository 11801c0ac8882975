"""Which of Blender's own panels are shown with this engine."""

from __future__ import annotations

import bpy

ENGINE = "PT_ENGINE"

# Blender marks what every engine can use with BLENDER_RENDER; these of them have no effect here, or are
# shown better by another panel:
NOT_FOR_US = ("freestyle", "preview", "simplify", "VIEWLAYER_PT_filter", "NODE_DATA_PT_light")
DOUBLE = ("DATA_PT_light",)
# and these are useful here though they are marked for EEVEE, or EEVEE and Cycles, alone:
OF_EEVEE = (
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "DATA_PT_EEVEE_light",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_displacement",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
    "OBJECT_PT_shadow_terminator",
)


def panels():
    """Blender's panel classes to show, among those that are registered now."""
    for panel in bpy.types.Panel.__subclasses__():
        name, engines = panel.__name__, getattr(panel, "COMPAT_ENGINES", ())
        left_out = name in DOUBLE or any(part in name for part in NOT_FOR_US)
        if ("BLENDER_RENDER" in engines and not left_out) or name in OF_EEVEE:
            yield panel


def register() -> None:
    for panel in panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if isinstance(engines, set):
            engines.discard(ENGINE)
