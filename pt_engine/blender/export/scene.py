"""Blender's evaluated scene becomes a `Snapshot`: the only way from bpy to the engine."""

from __future__ import annotations

from dataclasses import replace

from ...scene.movement import some_instances
from ...scene.snapshot import Snapshot
from .camera import export_camera
from .dicing import Dicing
from .failure import ExportError
from .images import ImageTable, ocio_config
from .instances import Collector
from .materials import MaterialTable
from .motion import MotionReader
from .properties import with_scene_values
from .shutter import Shutter
from .unsupported import scene_wide, uneven_rounds
from .world import export_world, world_of, world_visibility


def export_scene(depsgraph, *, camera=None, size=None, frame_set=None) -> Snapshot:
    """A frame of an evaluated scene.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph
        As `RenderEngine.render` gets it: its mode decides which modifiers and objects count.
    camera : bpy.types.Object, optional
        In place of the scene's.
    size : (width, height), optional
        Full image size in pixels, in place of the render settings' (for the camera's framing only).
    frame_set : callable (frame, subframe), optional
        Brings the depsgraph to another time and back, for motion blur; without it the snapshot stands still.

    Raises
    ------
    ExportError
        There is no camera.
    """
    frame = depsgraph.scene_eval.frame_current
    with Shutter(depsgraph.scene, frame_set) as shutter:
        return replace(export_moment(depsgraph, camera, size, shutter, frame), frame=frame)


def export_moment(depsgraph, camera, size, shutter: Shutter, frame: int) -> Snapshot:
    """The scene as it is now, which is the middle of the shutter's time, and what moves around it."""
    scene, view_layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    unsupported: list[tuple[str, str, str]] = []
    images = ImageTable(unsupported, frame)
    materials = MaterialTable(depsgraph, images)
    camera = camera_of(depsgraph, scene, camera)
    dicing = Dicing(depsgraph, scene, camera, size, unsupported)
    collector = Collector(depsgraph, materials, images, unsupported, dicing)
    instances = collector.run()
    world = export_world(scene, view_layer, depsgraph, images)
    unsupported += scene_wide(depsgraph, scene) + uneven_rounds(instances, len(collector.meshes))
    linking = collector.linking
    motion, framed = None, export_camera(camera, scene.render, size=size, unsupported=unsupported)
    if shutter.on:
        rounds = (*collector.curves, *collector.points)
        reader = MotionReader(depsgraph, shutter, collector.rows, instances, collector.meshes, rounds)
        motion, kept = reader.read(camera, framed, scene.render, size)
        instances = some_instances(instances, kept)
        linking = None if linking is None else linking.of(kept)
        unsupported += reader.unsupported
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
        camera=framed,
        motion=motion,
        exposure=getattr(getattr(scene, "cycles", None), "film_exposure", 1.0),
        unsupported=tuple(dict.fromkeys(unsupported)),
        ocio_config=ocio_config(),
        curves=tuple(collector.curves),
        points=tuple(collector.points),
        world_visibility=world_visibility(scene, view_layer),
        linking=linking,
        light_groups=collector.groups.names,
        world_light_group=collector.groups.of(world_of(scene, view_layer)),
        clear_glass=clear_glass(scene),
    )


def clear_glass(scene) -> float:
    """Roughness up to which a transparent film shows through glass; −1 for none."""
    cycles = getattr(scene, "cycles", None)
    if not getattr(cycles, "film_transparent_glass", False):
        return -1.0
    return getattr(cycles, "film_transparent_roughness", 0.1)


def camera_of(depsgraph, scene, camera=None):
    """The evaluated camera object."""
    camera = camera or scene.camera
    if camera is None:
        raise ExportError(f"scene {scene.name!r} has no camera")
    if camera.type != "CAMERA":
        raise ExportError(f"{camera.name!r}, the scene's camera, is a {camera.type.lower()}, not a camera")
    return camera if camera.is_evaluated else camera.evaluated_get(depsgraph)
