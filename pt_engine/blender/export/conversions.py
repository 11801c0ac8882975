"""What happens to a value or link on its way through sockets of other types, by Blender's rules.

A colour becomes a number by its luminance, a vector by its mean; a number fills all channels; into an integer
it is truncated, into a boolean compared with 0 (before Blender 5 truncated). Where a link needs it, an
ordinary node that does the same is put in by the `flattener` (its `extra`).
"""

from __future__ import annotations

from typing import NamedTuple

import bpy

from ...scene.snapshot import Link
from .node_props import plain

BLENDER_5 = bpy.app.version >= (5, 0, 0)
VALUE_TYPES = {"VALUE", "INT", "BOOLEAN", "VECTOR", "RGBA", "STRING", "MENU", "ROTATION", "MATRIX"}
SCALARS = {"VALUE", "INT", "BOOLEAN"}
LUMA = (0.2126, 0.7152, 0.0722)
COUNTS_THOUGH_HIDDEN = {  # no normal, no texture coordinate stands in for what these sockets hide
    ("ShaderNodeGamma", "Color"),
    ("ShaderNodeMapRange", "Vector"),
    ("ShaderNodeTexWhiteNoise", "Vector"),
    ("ShaderNodeVectorDisplacement", "Vector"),
    ("ShaderNodeVectorRotate", "Vector"),
}


class Feed(NamedTuple):
    """What reaches a socket: a link, or (link None) a constant; `type` is the socket type it has by now.

    `hidden`: the constant is a value that its group node doesn't show, unconverted (see `folding`).
    `way`: types of the sockets that a link has passed without being converted.
    """

    link: Link | None
    constant: object
    type: str
    hidden: bool = False
    way: tuple[str, ...] = ()


def own_value(socket):
    """The value of an unlinked socket: None where it has none, or hides it behind another meaning."""
    counts = not socket.hide_value or (socket.node.bl_idname, socket.identifier) in COUNTS_THOUGH_HIDDEN
    return value_of(socket) if counts else None


def value_of(socket):
    """A socket's value, shown or not; None where it has none."""
    if socket.type not in VALUE_TYPES or not hasattr(socket, "default_value"):
        return None
    return plain(socket.default_value)


def constant_of(socket) -> Feed | None:
    """What an unlinked input of a group hands in; before Blender 5 nothing where its value is hidden."""
    value = value_of(socket) if BLENDER_5 else own_value(socket)
    return None if value is None else Feed(None, value, socket.type, socket.hide_value)


def passed_through(flattener, feed: Feed | None, way: tuple[str, ...]) -> Feed | None:
    """`feed` behind sockets of these types; since Blender 5 links pass them as they are."""
    if feed is None or feed.link is None or not BLENDER_5:
        return along(flattener, feed, way)
    return feed._replace(way=way) if set(way) - {feed.type} and feed.type != "SHADER" else feed


def along(flattener, feed: Feed | None, way: tuple[str, ...]) -> Feed | None:
    """`feed` converted by each socket in turn; since Blender 5 a constant turns into a node as a shader."""
    for kind in way:
        if BLENDER_5 and feed is not None and kind == "SHADER" != feed.type:
            if feed.link is None:
                value = flattener.extra("RGB", {}, {"value": as_color(feed.constant)})
                feed = Feed(Link(value, "Color"), None, "RGBA")
            return feed._replace(type="RGBA")
        feed = converted(flattener, feed, kind)
    return feed


def converted(flattener, feed: Feed | None, to: str) -> Feed | None:
    """`feed` as a socket of type `to` gets it."""
    if feed is None or feed.type == to:
        return feed
    if feed.type == "SHADER" or to not in VALUE_TYPES | {"SHADER"}:
        return None
    if feed.link is None:
        return converted_constant(flattener, feed, to)
    if to == "SHADER":
        socket = "Strength" if feed.type in SCALARS else "Color"
        inputs = {"Color": (1.0, 1.0, 1.0, 1.0), "Strength": 1.0, socket: feed.link}
        return Feed(Link(flattener.extra("Emission", inputs), "Emission"), None, to)
    if feed.type in ("RGBA", "VECTOR", "ROTATION") and to in SCALARS:
        feed = narrowed(flattener, feed, to)
    if (feed.type, to) in (("VALUE", "INT"), ("VALUE", "BOOLEAN"), ("INT", "BOOLEAN")):
        inputs = {"Value": feed.link, "Value_001": 0.0, "Value_002": 0.0}
        operation = "GREATER_THAN" if to == "BOOLEAN" and BLENDER_5 else "TRUNC"
        number = flattener.extra("Math", inputs, {"operation": operation, "use_clamp": False})
        return Feed(Link(number, "Value"), None, to)
    return Feed(feed.link, None, to)


def narrowed(flattener, feed: Feed, to: str) -> Feed:
    """A colour's luminance or a vector's mean, as one value; a flag asks whether a vector has a length."""
    if feed.type == "RGBA":
        return Feed(Link(flattener.extra("RGBToBW", {"Color": feed.link}), "Val"), None, "VALUE")
    third = (1 / 3, 1 / 3, 1 / 3)
    zero = (0.0, 0.0, 0.0)
    inputs = {"Vector": feed.link, "Vector_001": third, "Vector_002": zero, "Scale": 1.0}
    operation = "LENGTH" if to == "BOOLEAN" and BLENDER_5 else "DOT_PRODUCT"
    number = flattener.extra("VectorMath", inputs, {"operation": operation})
    return Feed(Link(number, "Value"), None, "VALUE")


def converted_constant(flattener, feed: Feed, to: str) -> Feed | None:
    """A constant in another socket type, by the rules above."""
    value = feed.constant
    if to == "SHADER":
        inputs = {"Color": as_color(value), "Strength": 1.0}
        return Feed(Link(flattener.extra("Emission", inputs), "Emission"), None, to)
    if isinstance(value, str) or to in ("STRING", "MENU", "MATRIX"):
        return None
    if to == "RGBA":
        return Feed(None, as_color(value), to)
    if to in ("VECTOR", "ROTATION"):
        return Feed(None, as_color(value)[:3], to)
    if feed.type == "RGBA":
        value = sum(weight * channel for weight, channel in zip(LUMA, value, strict=False))
    elif isinstance(value, tuple):
        value = any(value) if to == "BOOLEAN" and BLENDER_5 else sum(value) / len(value)
    kind = {"VALUE": float, "INT": int, "BOOLEAN": (lambda x: x > 0) if BLENDER_5 else int}[to]
    return Feed(None, kind(value), to)


def as_color(value) -> tuple[float, ...]:
    """A scalar or vector as RGBA."""
    if isinstance(value, tuple):
        return (*value[:3], value[3] if len(value) > 3 else 1.0)
    return (float(value),) * 3 + (1.0,)
