"""Everything that is registered with Blender, in order."""

from __future__ import annotations

import bpy

from . import compatibility, object_panels, operators, panels, plugins, preferences, properties
from .engine import PTEngine

PARTS = (properties, operators, panels, object_panels, compatibility, preferences)


def register() -> None:
    """Once; a second call does nothing."""
    if getattr(bpy.types.Scene, "pt_engine", None) is not None:
        return
    bpy.utils.register_class(PTEngine)
    for part in PARTS:
        part.register()
    plugins.install_short_name()


def unregister() -> None:
    """Leave Blender as it was."""
    plugins.remove_short_name()
    for part in reversed(PARTS):
        part.unregister()
    bpy.utils.unregister_class(PTEngine)
