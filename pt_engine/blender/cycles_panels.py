"""Panels for settings that have an effect here but that Blender's own panels show to Cycles alone."""

from __future__ import annotations

from functools import reduce

import bpy

from .object_panels import DataPanel

# tab, name, label, settings as paths from the context
PANELS = (
    (  # Blender's own panel of this name has Samples, too, which are Cycles'
        "view_layer",
        "override",
        "Override",
        ("view_layer.material_override", "view_layer.world_override"),
    ),
    (
        "world",
        "ray_visibility",
        "Ray Visibility",
        tuple(f"world.cycles_visibility.{kind}" for kind in ("camera", "diffuse", "glossy", "transmission")),
    ),
    (
        "material",
        "settings",
        "Settings",
        ("material.displacement_method", "material.cycles.emission_sampling"),
    ),
)


def owner_of(context, path: str):
    """What has the property at the end of a path, and the property's name; None where it is missing."""
    *owners, name = path.split(".")
    owner = reduce(lambda found, key: getattr(found, key, None), owners, context)
    return (owner, name) if hasattr(owner, name) else (None, name)


def settings_panel(tab, name, label, settings):
    """A panel class of a table row, shown where its settings exist."""

    def applies(cls, context):
        return owner_of(context, settings[0])[0] is not None

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        for owner, prop in (owner_of(context, path) for path in settings):
            if owner is not None:
                layout.prop(owner, prop)

    return type(
        f"PTENGINE_{tab.upper()}_PT_{name}",
        (DataPanel, bpy.types.Panel),
        {
            "bl_label": label,
            "bl_context": tab,
            "bl_options": {"DEFAULT_CLOSED"},
            "applies": classmethod(applies),
            "draw": draw,
        },
    )


CLASSES = tuple(settings_panel(*row) for row in PANELS)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
