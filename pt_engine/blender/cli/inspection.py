"""The commands that look at a file without rendering it: `coverage` and `explain`."""

from __future__ import annotations

import difflib
import json

import bpy

from ...nodes.explain import explain
from ...scene.prepare import prepare
from .. import registration
from ..coverage_listing import as_data, sections, text_lines
from ..export import ExportError, export_scene
from ..failure import Failure
from .blendfile import choose_view_layer, open_settings

NEAR = 5  # names that are offered for an unknown one


def coverage_command(arguments) -> int:
    """List how every part of the file is rendered; 1 where --strict finds something that is not exact."""
    snapshot = snapshot_of(seen_scene(arguments), arguments)
    listed = sections(snapshot, prepare(snapshot).coverage)
    if arguments.json:
        print(json.dumps({"file": str(arguments.file), **as_data(listed)}, indent=2, ensure_ascii=False))
    else:
        print("\n".join(text_lines(listed)))
    return int(arguments.strict and not all(section.exact for section in listed))


def explain_command(arguments) -> int:
    """Print the program that one material was compiled to, also of one that no object wears."""
    scene = seen_scene(arguments)
    if arguments.material in bpy.data.materials:
        wear(scene, bpy.data.materials[arguments.material])
    snapshot = snapshot_of(scene, arguments)
    names = [graph.name for graph in snapshot.materials]
    if arguments.material not in names:
        known = bpy.data.materials.keys()
        near = difflib.get_close_matches(arguments.material, known, NEAR, cutoff=0.4) or known[:NEAR]
        raise Failure(
            f"no material {arguments.material!r} is in {arguments.file}: "
            + (f"is it {', '.join(near)}?" if near else "it has none")
        )
    number = names.index(arguments.material)
    print("\n".join(explain(snapshot.materials, number, snapshot.images, snapshot.ocio_config)))
    return 0


def seen_scene(arguments):
    """The file's active scene; a collection of materials needs no camera to be looked at."""
    registration.register()
    scene = open_settings(arguments)
    if scene.camera is None:
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    return scene


def wear(scene, material) -> None:
    """Put a triangle of the material into the scene: only what is worn is compiled."""
    mesh = bpy.data.meshes.new("Sample")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("Sample", mesh))


def snapshot_of(scene, arguments):
    """The scene's frame and view layer as the engine gets them."""
    layer = scene.view_layers[choose_view_layer(scene, arguments.view_layer)]
    with bpy.context.temp_override(scene=scene, view_layer=layer):
        depsgraph = bpy.context.evaluated_depsgraph_get()
    try:
        return export_scene(depsgraph, frame_set=lambda frame, part: scene.frame_set(frame, subframe=part))
    except ExportError as error:
        raise Failure(str(error)) from error
