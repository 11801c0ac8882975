"""From a finding of the coverage back to the node in the file, and to the editor that shows it."""

from __future__ import annotations

from typing import NamedTuple

import bpy

AFTER_REDRAW = 0.1  # seconds


class Place(NamedTuple):
    """A node: its owner (material, world or light), the group nodes on the way in, and itself."""

    owner: object
    groups: tuple
    node: object


def owner_of(name: str):
    """The material, world or light of this name that has nodes; None where there is none."""
    for owners in (bpy.data.materials, bpy.data.worlds, bpy.data.lights):
        owner = owners.get(name)
        if owner is not None and owner.node_tree is not None:
            return owner
    return None


def place_of(name: str, path: str) -> Place | None:
    """Where `path`, a node's name behind those of its groups (`Group/Noise`), is in the file.

    None for nodes that are not the file's own: the exporter's conversions, and what Blender makes of zones.
    """
    owner = owner_of(name)
    found = in_tree(owner.node_tree, path) if owner is not None else None
    return None if found is None else Place(owner, *found)


def in_tree(tree, path: str):
    """The groups on the way and the node; names may have slashes of their own."""
    node = tree.nodes.get(path)
    if node is not None:
        return (), node
    for group in tree.nodes:
        inner = getattr(group, "node_tree", None)
        if inner is not None and path.startswith(f"{group.name}/"):
            found = in_tree(inner, path[len(group.name) + 1 :])
            if found is not None:
                return (group, *found[0]), found[1]
    return None


def show(context, place: Place) -> None:
    """Select what has the node, make the node active, and frame it in every open shader editor."""
    select_owner(context, place.owner)
    tree = place.node.id_data
    for node in tree.nodes:
        node.select = node == place.node
    tree.nodes.active = place.node
    for _, area in shader_editors():
        turn_to(area.spaces.active, place)
        area.tag_redraw()
    # the redraw goes to where the tree was last looked at
    bpy.app.timers.register(frame_selected, first_interval=AFTER_REDRAW)


def shader_editors():
    """Each with its window."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "NODE_EDITOR" and area.spaces.active.tree_type == "ShaderNodeTree":
                yield window, area


def select_owner(context, owner) -> None:
    """Make active an object of the view layer that has the material or light."""
    for candidate in context.view_layer.objects:
        slots = [slot.material for slot in candidate.material_slots]
        if owner not in slots and candidate.data != owner:
            continue
        if not candidate.visible_get():
            continue
        for other in context.selected_objects:
            other.select_set(False)
        candidate.select_set(True)
        context.view_layer.objects.active = candidate
        if owner in slots:
            candidate.active_material_index = slots.index(owner)
        return


def turn_to(space, place: Place) -> None:
    """Open the node's tree in an editor."""
    space.shader_type = "WORLD" if isinstance(place.owner, bpy.types.World) else "OBJECT"
    space.pin = True  # else the editor goes back to its own context's tree before it draws
    space.path.start(place.owner.node_tree)
    for group in place.groups:
        space.path.append(group.node_tree, node=group)
    space.pin = False


def frame_selected() -> None:
    """Bring the selected node into view in every shader editor."""
    for window, area in shader_editors():
        region = next(region for region in area.regions if region.type == "WINDOW")
        with bpy.context.temp_override(window=window, area=area, region=region):
            bpy.ops.node.view_selected()
