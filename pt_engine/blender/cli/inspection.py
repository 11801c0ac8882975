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
from .blendfile import choose_view_layer, open_scene

NEAR = 5  # names that are offered for an unknown one


def coverage_command(arguments) -> int:
    """List how every part of the file is rendered; 1 where --strict finds something that is not exact."""
    snapshot = snapshot_of(arguments)
    listed = sections(snapshot, prepare(snapshot).coverage)
    if arguments.json:
        print(json.dumps({"file": str(arguments.file), **as_data(listed)}, indent=2, ensure_ascii=False))
    else:
        print("\n".join(text_lines(listed)))
    return int(arguments.strict and not all(section.exact for section in listed))


def explain_command(arguments) -> int:
    """Print the program that one material was compiled to."""
    snapshot = snapshot_of(arguments)
    names = [graph.name for graph in snapshot.materials]
    if arguments.material not in names:
        near = difflib.get_close_matches(arguments.material, names, NEAR, cutoff=0.4) or names[1:][:NEAR]
        raise Failure(
            f"no material {arguments.material!r} is rendered in {arguments.file}: "
            + (f"is it {', '.join(near)}?" if near else "no object has any")
        )
    number = names.index(arguments.material)
    print("\n".join(explain(snapshot.materials, number, snapshot.images, snapshot.ocio_config)))
    return 0


def snapshot_of(arguments):
    """The file's frame and view layer as the engine gets them."""
    registration.register()
    scene = open_scene(arguments)
    layer = scene.view_layers[choose_view_layer(scene, arguments.view_layer)]
    with bpy.context.temp_override(scene=scene, view_layer=layer):
        depsgraph = bpy.context.evaluated_depsgraph_get()
    try:
        return export_scene(depsgraph, frame_set=lambda frame, part: scene.frame_set(frame, subframe=part))
    except ExportError as error:
        raise Failure(str(error)) from error
