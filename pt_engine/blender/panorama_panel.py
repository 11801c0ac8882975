"""The lens of a panoramic camera: Blender's own panel shows it to Cycles alone."""

from __future__ import annotations

import bpy

from .export.panorama import EDGES
from .object_panels import DataPanel

LENSES = {  # projection → its properties
    "EQUIRECTANGULAR": ("latitude_min", "latitude_max", "longitude_min", "longitude_max"),
    "FISHEYE_EQUIDISTANT": ("fisheye_fov",),
    "FISHEYE_EQUISOLID": ("fisheye_lens", "fisheye_fov"),
    "FISHEYE_LENS_POLYNOMIAL": ("fisheye_fov", *(f"fisheye_polynomial_k{n}" for n in range(5))),
    "CENTRAL_CYLINDRICAL": (
        *("central_cylindrical_range_v_min", "central_cylindrical_range_v_max"),
        *("central_cylindrical_range_u_min", "central_cylindrical_range_u_max"),
        "central_cylindrical_radius",
    ),
}


class PTENGINE_CAMERA_PT_panorama(DataPanel, bpy.types.Panel):
    bl_label = "Panorama"
    bl_context = "data"
    bl_parent_id = "DATA_PT_lens"

    @classmethod
    def applies(cls, context):
        return context.camera is not None and context.camera.type == "PANO"

    def draw(self, context):
        layout, camera = self.layout, context.camera
        layout.use_property_split = True
        layout.prop(camera, "panorama_type")
        if camera.panorama_type not in EDGES:
            layout.label(text="Rendered as equirectangular", icon="ERROR")
        column = layout.column(align=True)
        for name in LENSES.get(camera.panorama_type, ()):
            if name.startswith("fisheye_polynomial_"):
                column.prop(camera, name, text=name[-2:].upper())
            else:
                column.prop(camera, name)


CLASSES = (PTENGINE_CAMERA_PT_panorama,)
register, unregister = bpy.utils.register_classes_factory(CLASSES)
