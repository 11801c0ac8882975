"""A shader node's own settings, as plain values.

Every enum, flag, number, string and vector that a node type adds to `bpy.types.Node` is taken by its RNA
name. What is more than a value becomes:

``ramp``               (color mode, interpolation, ((position, r, g, b, a), ...)), and ``ramp_hue``
``curves``             a table per channel: 257 samples over ``curve_range``, the common curve C before it
``curve_range``        (from, to): where the tables begin and end
``curve_extend``       EXTRAPOLATED or HORIZONTAL
``folded_curves``      where Blender folds the node: rows of `curve_nodes.folded`, one per curve
``folded_clip``        (least, most) of a folded Float Curve that is clipped, else None
``image``              index into `Snapshot.images`, None where none is set
``texture_mapping``    the (long hidden) texture mapping as ((name, value), ...), only where it does something
``object_matrix``      Texture Coordinate with an object: world to that object, 16 numbers by rows
``ies_text``           text of an IES file
``value``              of the nodes whose output is their setting: Value, RGB, Normal
``filter_width``       the own value of Bump's socket
"""

from __future__ import annotations

from pathlib import Path

import bpy

from .curve_nodes import curves

PLAIN = {"BOOLEAN", "INT", "FLOAT", "STRING", "ENUM"}
OUTPUT_IS_SETTING = {"ShaderNodeValue", "ShaderNodeRGB", "ShaderNodeNormal"}


def node_props(node, images) -> dict[str, object]:
    """Settings of an evaluated node; `images` is the `ImageTable` that numbers its image."""
    inherited = bpy.types.Node.bl_rna.properties
    props: dict[str, object] = {}
    for setting in node.bl_rna.properties:
        name = setting.identifier
        if name in inherited:
            continue
        if setting.type in PLAIN:
            props[name] = plain(getattr(node, name))
        elif setting.type == "POINTER":
            props.update(pointed(node, name, images))
    if node.bl_idname == "ShaderNodeTexIES" and node.mode == "EXTERNAL":
        props["ies_text"] = read_ies(node)
    if node.bl_idname == "ShaderNodeBump":
        props["filter_width"] = node.inputs["Filter Width"].default_value
    if node.bl_idname in OUTPUT_IS_SETTING:
        props["value"] = plain(node.outputs[0].default_value)
    return props


def plain(value):
    """RNA's vectors and matrices as (nested) tuples; other values as they are."""
    if isinstance(value, str | bool | int | float) or value is None:
        return value
    if isinstance(value, set | frozenset):
        return tuple(sorted(value))
    return tuple(plain(item) for item in value)


def pointed(node, name: str, images) -> dict[str, object]:
    """What a pointer setting stands for."""
    target = getattr(node, name)
    if name == "image":
        user = getattr(node, "image_user", None)
        return {"image": None if target is None else images.index(target, user)}
    if target is None:
        return {}
    if name == "color_ramp":
        return ramp(target)
    if name == "mapping":
        return curves(target, node.bl_idname)
    if name == "texture_mapping":
        settings = texture_mapping(target)
        return {"texture_mapping": settings} if settings else {}
    if name == "object" and node.bl_idname == "ShaderNodeTexCoord":
        inverse = target.matrix_world.inverted_safe()
        return {"object_matrix": tuple(number for row in inverse for number in row)}
    if name == "ies":
        return {"ies_text": target.as_string()}
    return {}


def ramp(color_ramp) -> dict[str, object]:
    """A colour ramp, its stops sorted by position."""
    stops = tuple((stop.position, *stop.color) for stop in color_ramp.elements)
    return {
        "ramp": (color_ramp.color_mode, color_ramp.interpolation, tuple(sorted(stops, key=lambda s: s[0]))),
        "ramp_hue": color_ramp.hue_interpolation,
    }


MAPPING_FIELDS = {
    "translation": (0.0, 0.0, 0.0),
    "rotation": (0.0, 0.0, 0.0),
    "scale": (1.0, 1.0, 1.0),
    "mapping_x": "X",
    "mapping_y": "Y",
    "mapping_z": "Z",
}


def texture_mapping(mapping) -> tuple[tuple[str, object], ...]:
    """What Cycles reads of a texture mapping (no limits, no projection), () where it maps all to itself."""
    settings = {name: plain(getattr(mapping, name)) for name in MAPPING_FIELDS}
    if settings == MAPPING_FIELDS:
        return ()
    return (("vector_type", mapping.vector_type), *settings.items())


def read_ies(node) -> str:
    """Text of an external IES file, "" where it can't be read."""
    try:
        return Path(bpy.path.abspath(node.filepath)).read_text("utf-8", errors="replace")
    except OSError:
        return ""
