"""Blender's evaluated scene becomes a `Snapshot`: the only way from bpy to the engine."""

from __future__ import annotations

from dataclasses import replace

from ...scene.snapshot import Snapshot
from .camera import export_camera
from .dicing import Dicing
from .images import ImageTable, ocio_config
from .instances import Collector
from .materials import MaterialTable
from .properties import with_scene_values
from .unsupported import scene_wide
from .world import export_world


class ExportError(RuntimeError):
    """The scene can't be rendered, and why."""


def export_scene(depsgraph, *, camera=None, size=None) -> Snapshot:
    """A frame of an evaluated scene.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
        As `RenderEngine.render` gets it: its mode decides which modifiers and objects count.
    camera : bpy.types.Object, optional
        In place of the scene's.
    size : (width, height), optional
        Full image size in pixels, in place of the render settings' (for the camera's framing only).

    Raises
    ------
    ExportError
        There is no camera.
    """
    scene, view_layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    unsupported: list[tuple[str, str, str]] = []
    images = ImageTable(unsupported, scene.frame_current)
    materials = MaterialTable(depsgraph, images)
    camera = camera_of(depsgraph, scene, camera)
    dicing = Dicing(depsgraph, scene, camera, size, unsupported)
    collector = Collector(depsgraph, materials, images, unsupported, dicing)
    instances = collector.run()
    world = export_world(scene, view_layer, depsgraph, images, unsupported)
    unsupported += scene_wide(depsgraph, scene)
    return Snapshot(
        meshes=tuple(collector.meshes),
        instances=instances,
        materials=tuple(with_scene_values(graph, scene, view_layer) for graph in materials.graphs),
        images=tuple(images.images),
        lights=tuple(
            replace(light, graph=with_scene_values(light.graph, scene, view_layer))
            for light in collector.lights
        ),
        world=with_scene_values(world, scene, view_layer),
        camera=export_camera(camera, scene.render, size=size, unsupported=unsupported),
        frame=scene.frame_current,
        exposure=getattr(getattr(scene, "cycles", None), "film_exposure", 1.0),
        unsupported=tuple(dict.fromkeys(unsupported)),
        ocio_config=ocio_config(),
        curves=tuple(collector.curves),
        points=tuple(collector.points),
    )


def camera_of(depsgraph, scene, camera=None):
    """The evaluated camera object."""
    camera = camera or scene.camera
    if camera is None:
        raise ExportError(f"scene {scene.name!r} has no camera")
    if camera.type != "CAMERA":
        raise ExportError(f"{camera.name!r}, the scene's camera, is a {camera.type.lower()}, not a camera")
    return camera if camera.is_evaluated else camera.evaluated_get(depsgraph)
