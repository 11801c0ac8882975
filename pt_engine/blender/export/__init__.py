"""Blender's evaluated scene becomes a snapshot: `export_scene(depsgraph)`."""

from .scene import ExportError, export_scene

__all__ = ["ExportError", "export_scene"]
