"""PT Engine as Blender sees it: it delegates at once."""

from __future__ import annotations

import bpy

from .final import final_render
from .passes import registered_passes
from .record import Session
from .refusal import reported_to


class PTEngine(bpy.types.RenderEngine):
    """The path tracer in Blender's render engine menu."""

    bl_idname = "PT_ENGINE"
    bl_label = "PT Engine"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False  # Cycles' and EEVEE's shading nodes are the engine's
    bl_use_eevee_viewport = True
    bl_use_spherical_stereo = True  # else Blender's panel hides its settings

    def render(self, depsgraph):
        with reported_to(self, on_failure=self.failed):
            final_render(self, depsgraph)

    def failed(self, message: str) -> None:
        """Leave the message where the panel and the command line find it."""
        if record := getattr(self, "pt_record", None):
            record.failure = message
        Session.observer.on_failure(message)

    def update_render_passes(self, scene=None, renderlayer=None):
        for name, channels, letters, kind in registered_passes(renderlayer):
            self.register_pass(scene, renderlayer, name, channels, letters, kind)
