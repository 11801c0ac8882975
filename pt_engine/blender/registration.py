"""Everything that is registered with Blender, in order."""

from __future__ import annotations

import atexit

import bpy

from . import (
    accuracy_panel,
    compatibility,
    coverage_panel,
    cycles_panels,
    light_group_panels,
    motion_panels,
    object_panels,
    operators,
    panels,
    panorama_panel,
    plugins,
    preferences,
    properties,
)
from .engine import PTEngine

PARTS = (
    *(properties, operators, panels, accuracy_panel, coverage_panel, object_panels),
    *(cycles_panels, panorama_panel, light_group_panels, motion_panels, compatibility, preferences),
)


def registered() -> bool:
    """Whether this Blender knows the engine."""
    return getattr(bpy.types.Scene, "pt_engine", None) is not None


def register() -> None:
    """Once; a second call does nothing."""
    if registered():
        return
    bpy.utils.register_class(PTEngine)
    for part in PARTS:
        part.register()
    plugins.install_short_name()
    if bpy.app.module:
        # as a Python module, Blender 4.5 does not get out of its own shutdown with classes registered
        atexit.register(unregister)


def unregister() -> None:
    """Leave Blender as it was."""
    atexit.unregister(unregister)
    if not registered():
        return
    plugins.remove_short_name()
    for part in reversed(PARTS):
        part.unregister()
    bpy.utils.unregister_class(PTEngine)
