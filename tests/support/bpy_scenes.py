"""Small Blender scenes for tests, and their export."""

import bpy
import numpy as np

from pt_engine.blender.export import export_scene


def empty_scene():
    """A new file with a scene and a camera, nothing else."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    camera = add(bpy.data.cameras.new("Camera"))
    bpy.context.scene.camera = camera
    return bpy.context.scene


def shutter_scene():
    """The same at frame 2, with the shutter open for half a frame around it."""
    made = empty_scene()
    made.render.use_motion_blur, made.render.motion_blur_shutter = True, 0.5
    made.frame_set(2)
    return made


def add(data, name="", **settings):
    """A new object of `data` in the scene."""
    owner = bpy.data.objects.new(name or data.name, data)
    bpy.context.scene.collection.objects.link(owner)
    for key, value in settings.items():
        setattr(owner, key, value)
    return owner


def mesh(vertices, faces, name="Mesh"):
    """Mesh data from vertices and faces."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(vertices, [], faces)
    return data


def cube(name="Cube", size=2.0):
    """A cube of 6 quads about the origin."""
    h = size / 2
    corners = [(x, y, z) for z in (-h, h) for y in (-h, h) for x in (-h, h)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return mesh(corners, faces, name)


def export(**options):
    """The snapshot of the current scene as the viewport sees it."""
    return export_scene(bpy.context.evaluated_depsgraph_get(), **options)


class ExportEngine(bpy.types.RenderEngine):
    """Exports instead of rendering: the depsgraph of a final render."""

    bl_idname = "TEST_EXPORT"
    bl_label = "Test export"
    result = None

    def render(self, depsgraph):
        try:
            ExportEngine.result = export_scene(depsgraph)
        except Exception as error:
            ExportEngine.result = error
        scene = depsgraph.scene
        result = self.begin_result(0, 0, scene.render.resolution_x, scene.render.resolution_y)
        self.end_result(result)


def export_in_render():
    """The snapshot of the current scene as a final render sees it."""
    scene = bpy.context.scene
    bpy.utils.register_class(ExportEngine)
    try:
        scene.render.engine = ExportEngine.bl_idname
        scene.render.resolution_x = scene.render.resolution_y = 8
        ExportEngine.result = None
        bpy.ops.render.render()
    finally:
        scene.render.engine = "CYCLES"
        bpy.utils.unregister_class(ExportEngine)
    if isinstance(ExportEngine.result, Exception):
        raise ExportEngine.result
    return ExportEngine.result


def rows_of(snapshot, name):
    """Instance rows of the object `name`."""
    return [row for row, other in enumerate(snapshot.instances.names) if other == name]


def world_triangles(snapshot, row):
    """(T, 3, 3) corners of one instance in world space, float64."""
    data = snapshot.meshes[snapshot.instances.mesh[row]]
    matrix = snapshot.instances.matrix[row]
    return data.vertices[data.triangles].astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]


def geometric_normals(data):
    """(T, 3) unit normals of a mesh's triangles in object space."""
    a, b, c = np.moveaxis(data.vertices[data.triangles].astype(np.float64), 1, 0)
    normal = np.cross(b - a, c - a)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)
