"""The extension's preferences: a folder of the user's own integrators, loaded when Blender starts."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import StringProperty

from . import plugins

EXTENSION = plugins.PACKAGE.rpartition(".")[0]  # "" where the package is used as a plain library


class PTEnginePreferences(bpy.types.AddonPreferences):
    """Preferences of PT Engine."""

    bl_idname = EXTENSION

    integrators: StringProperty(
        name="Integrators",
        description="Folder with Python files of your own that each register an integrator; "
        "they are run when Blender starts",
        subtype="DIR_PATH",
    )

    def draw(self, context):
        self.layout.prop(self, "integrators")


def register() -> None:
    if EXTENSION:
        bpy.utils.register_class(PTEnginePreferences)
        load_integrators()


def unregister() -> None:
    if EXTENSION:
        bpy.utils.unregister_class(PTEnginePreferences)


def load_integrators() -> None:
    """Load every file of the folder; one that fails is told and does not keep the others from loading."""
    addon = bpy.context.preferences.addons.get(EXTENSION)
    folder = addon.preferences.integrators if addon and addon.preferences else ""
    if not folder:
        return
    for path in sorted(Path(bpy.path.abspath(folder)).glob("*.py")):
        try:
            plugins.load(path)
        except plugins.PluginError as error:
            print(f"PT Engine: {error}")
