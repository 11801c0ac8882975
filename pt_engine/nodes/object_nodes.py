"""What a point knows of its object: Object Info, Particle Info, Hair Info, Point Info."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .graph import NodeView
from .ir import COLOR, FLOAT, VECTOR, Value, lane_op
from .registry import Outputs, node

Float32 = NDArray[np.float32]


@lane_op(VECTOR, reads="object")
def object_location(lanes: Any) -> Float32:
    """World location of the object's origin."""
    return lanes.object_location()  # type: ignore[no-any-return]


@lane_op(COLOR, FLOAT, reads="object")
def object_color(lanes: Any) -> tuple[Float32, Float32]:
    """The object's colour and alpha."""
    rgba = lanes.object_color()
    return rgba[:3], rgba[3]


@lane_op(FLOAT, reads="object")
def object_index(lanes: Any) -> Float32:
    """Pass index."""
    return lanes.object_index()  # type: ignore[no-any-return]


@lane_op(FLOAT, reads="object")
def object_random(lanes: Any) -> Float32:
    """Random number of the object."""
    return lanes.object_random()  # type: ignore[no-any-return]


@node("ObjectInfo")
def object_info(n: NodeView) -> Outputs:
    if n.wants("Material Index"):
        n.ignored("Material Index is not known: 0")
    out: dict[str, Value | None] = {"Material Index": n.constant(0.0, FLOAT)}
    if n.wants("Color") or n.wants("Alpha"):
        out["Color"], out["Alpha"] = n.calls(object_color)
    table = {"Location": object_location, "Object Index": object_index, "Random": object_random}
    out.update({name: n.call(what) for name, what in table.items() if n.wants(name)})
    return out


for _name, _outputs in {
    "ParticleInfo": {
        "Index": FLOAT,
        "Random": FLOAT,
        "Age": FLOAT,
        "Lifetime": FLOAT,
        "Location": VECTOR,
        "Size": FLOAT,
        "Velocity": VECTOR,
        "Angular Velocity": VECTOR,
    },
    "HairInfo": {
        "Is Strand": FLOAT,
        "Intercept": FLOAT,
        "Length": FLOAT,
        "Thickness": FLOAT,
        "Tangent Normal": VECTOR,
        "Random": FLOAT,
    },
    "PointInfo": {"Position": VECTOR, "Radius": FLOAT, "Random": FLOAT},
}.items():

    @node(_name)
    def _zeros(n: NodeView, outputs: dict[str, str] = _outputs) -> Outputs:
        if n.node.kind != "HairInfo" or any(n.wants(name) for name in outputs if name != "Is Strand"):
            n.ignored(f"{n.node.kind} is not known: 0")
        return {name: n.constant(0.0, kind) for name, kind in outputs.items()}
