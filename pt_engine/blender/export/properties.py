"""Properties that Attribute nodes name: of objects, their data and instancers, of the view layer and scene.

Blender reads a name first as that of a custom property, then as an RNA path (``color``, ``render.fps``,
``["prop"]``). A number x becomes (x, x, x, 1), up to four of them fill (0, 0, 0, 1), all else is not found.
"""

from __future__ import annotations

from dataclasses import replace

import bpy

from ...scene.snapshot import Graph

Rgba = tuple[float, float, float, float]
NOTHING: Rgba = (0.0, 0.0, 0.0, 0.0)
NUMBER = bool | int | float


def rgba_of(owner, name: str) -> Rgba | None:
    """A property of one owner, None where it has none of this name that is made of numbers."""
    if owner is None or not name:
        return None
    for path in (f'["{bpy.utils.escape_identifier(name)}"]', name):
        try:
            value = owner.path_resolve(path)
        except (ValueError, AttributeError):
            continue
        found = as_rgba(value)
        if found is not None:
            return found
    return None


def as_rgba(value) -> Rgba | None:
    """A number, or up to four of them, as a colour."""
    if isinstance(value, NUMBER):
        return (float(value),) * 3 + (1.0,)
    try:
        items = tuple(value)
    except TypeError:
        return None
    if isinstance(value, str) or not 0 < len(items) <= 4 or not all(isinstance(x, NUMBER) for x in items):
        return None
    filled = (*map(float, items), *(0.0, 0.0, 0.0, 1.0)[len(items) :])
    return filled[0], filled[1], filled[2], filled[3]


def object_rgba(owner, name: str) -> Rgba:
    """Of an object, else of its data."""
    return first_of((owner, owner.data), name)


def first_of(owners, name: str) -> Rgba:
    """Of the first that has it."""
    return next((found for owner in owners if (found := rgba_of(owner, name)) is not None), NOTHING)


def with_scene_values(graph: Graph | None, scene, view_layer) -> Graph | None:
    """A graph whose nodes know what they ask of scene and view layer: see `of_scene`."""
    if graph is None or not any(node.kind == "SceneTime" or of_layer(node) for node in graph.nodes):
        return graph
    nodes = tuple(replace(node, props=node.props | of_scene(node, scene, view_layer)) for node in graph.nodes)
    return replace(graph, nodes=nodes)


def of_scene(node, scene, view_layer) -> dict[str, object]:
    """Scene Time's `frame` and `seconds`; `value` of an Attribute of view layer, scene or its world."""
    if node.kind == "SceneTime":
        frame = scene.frame_current_final
        return {"frame": frame, "seconds": frame * scene.render.fps_base / scene.render.fps}
    if of_layer(node):
        owners = (view_layer, scene, scene.world)
        return {"value": first_of(owners, str(node.props["attribute_name"]))}
    return {}


def of_layer(node) -> bool:
    """Whether a node asks for a property of the view layer."""
    return node.kind == "Attribute" and node.props.get("attribute_type") == "VIEW_LAYER"
