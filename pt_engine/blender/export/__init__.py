"""Blender's evaluated scene becomes a snapshot: `export_scene(depsgraph)`."""

from .failure import ExportError
from .scene import export_scene

__all__ = ["ExportError", "export_scene"]
