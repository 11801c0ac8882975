"""Attributes by name: Attribute, Color Attribute."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .coordinates import uv_coordinates
from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]


@lane_op(COLOR, FLOAT, moves=True, reads=lambda name: (f"color:{name}",))
def color_attribute(lanes: Any, name: str) -> tuple[Float32, Float32]:
    """Colour and alpha of a colour attribute."""
    rgba = lanes.color(name)
    return rgba[:3], rgba[3]


@node("Attribute")
def attribute(n: NodeView) -> Outputs:
    name = str(n.prop("attribute_name", ""))
    if n.prop("attribute_type", "GEOMETRY") != "GEOMETRY":
        n.ignored("attributes of objects, instancers and view layers are not known: 0")
        zero = n.constant(0.0, FLOAT)
        return {
            "Color": n.constant(0.0, COLOR),
            "Vector": n.constant(0.0, VECTOR),
            "Fac": zero,
            "Alpha": zero,
        }
    color, alpha = n.calls(color_attribute, static=(name,))
    # a mesh without the colour attribute gives 0, one without the uv map too: at most one is there
    vector = n.builder.add(n.builder.convert(color, VECTOR), n.call(uv_coordinates, static=(name,)))
    return {
        "Color": n.builder.convert(vector, COLOR),
        "Vector": vector,
        "Fac": n.builder.convert(vector, FLOAT),
        "Alpha": alpha,
    }


@node("VertexColor")
def vertex_color(n: NodeView) -> Outputs:
    color, alpha = n.calls(color_attribute, static=(str(n.prop("layer_name", "")),))
    return {"Color": color, "Alpha": alpha}
