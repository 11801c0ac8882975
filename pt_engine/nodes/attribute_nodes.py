"""Attributes by name: Attribute, Color Attribute."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .coordinates import generated
from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, Value, lane_op
from .registry import Outputs, node
from .tangents import stored_tangent

Float32 = NDArray[np.float32]


@lane_op(COLOR, FLOAT, moves=True, reads=lambda name: (f"color:{name}",))
def color_attribute(lanes: Any, name: str) -> tuple[Float32, Float32]:
    """Colour and alpha of a colour attribute."""
    rgba = lanes.color(name)
    return rgba[:3], rgba[3]


@lane_op(VECTOR, FLOAT, FLOAT, moves=True, reads=lambda name: (f"attribute:{name}",))
def mesh_attribute(lanes: Any, name: str) -> tuple[Float32, Float32, Float32]:
    """Vector, alpha and number of any attribute; where there is none of this name 0, its alpha 1."""
    values = lanes.attribute(name)
    return values[:3], values[3], values[4]


@lane_op(VECTOR, FLOAT, reads="object")
def object_attribute(lanes: Any, name: str) -> tuple[Float32, Float32]:
    """Vector and alpha of a property of the object or its instancer."""
    rgba = lanes.per_object(name)
    return rgba[:3], rgba[3]


@node("Attribute")
def attribute(n: NodeView) -> Outputs:
    name, kind = str(n.prop("attribute_name", "")), str(n.prop("attribute_type", "GEOMETRY"))
    one = n.constant(1.0, FLOAT)
    if kind == "VIEW_LAYER":
        x, y, z, alpha = n.prop("value", (0.0, 0.0, 0.0, 0.0))
        return everything(n, n.constant((x, y, z), VECTOR), n.constant(alpha, FLOAT))
    if kind == "GEOMETRY" and name == "generated":
        return everything(n, n.call(generated), one)
    if n.reader.world or not name:
        return everything(n, n.constant(0.0, VECTOR), one)
    uv_map, _, suffix = name.rpartition(".")
    if kind == "GEOMETRY" and suffix in ("tangent", "tangent_sign"):
        tangent, sign = n.calls(stored_tangent, static=(uv_map,))
        return everything(n, tangent if suffix == "tangent" else n.builder.convert(sign, VECTOR), one)
    if kind == "GEOMETRY":
        return everything(n, *n.calls(mesh_attribute, static=(name,)))
    return everything(n, *n.calls(object_attribute, static=(f"{kind.lower()}:{name}",)))


def everything(n: NodeView, vector: Value, alpha: Value, number: Value | None = None) -> Outputs:
    """All outputs of an attribute; its number is the mean of the vector where nothing else is said."""
    number = n.builder.convert(vector, FLOAT) if number is None else number
    return {"Color": n.builder.convert(vector, COLOR), "Vector": vector, "Fac": number, "Alpha": alpha}


@node("VolumeInfo")
def volume_info(n: NodeView) -> Outputs:
    """0 on surfaces, whatever attributes the mesh has."""
    return dict.fromkeys(("Color", "Density", "Flame", "Temperature"), n.constant(0.0, FLOAT))


@node("VertexColor")
def vertex_color(n: NodeView) -> Outputs:
    color, alpha = n.calls(color_attribute, static=(str(n.prop("layer_name", "")),))
    return {"Color": color, "Alpha": alpha}
