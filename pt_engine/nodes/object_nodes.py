"""What a point knows of its object: Object Info, Particle Info."""

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
    out: dict[str, Value | None] = {"Material Index": n.constant(n.reader.graph.pass_index, FLOAT)}
    if n.wants("Color") or n.wants("Alpha"):
        out["Color"], out["Alpha"] = n.calls(object_color)
    table = {"Location": object_location, "Object Index": object_index, "Random": object_random}
    out.update({name: n.call(what) for name, what in table.items() if n.wants(name)})
    return out


@lane_op(FLOAT, reads="object")
def particle_number(lanes: Any, row: str, part: int) -> Float32:
    """One number of the particle that the object was made from."""
    return lanes.per_object(row)[part]  # type: ignore[no-any-return]


@lane_op(VECTOR, reads="object")
def particle_vector(lanes: Any, row: str) -> Float32:
    """One vector of the particle that the object was made from."""
    return lanes.per_object(row)[:3]  # type: ignore[no-any-return]


NUMBERS = {
    "Index": ("particle", 0),
    "Random": ("particle", 1),
    "Age": ("particle", 2),
    "Lifetime": ("particle", 3),
    "Size": ("particle location", 3),
}
VECTORS = {
    "Location": ("particle location",),
    "Velocity": ("particle velocity",),
    "Angular Velocity": ("particle angular velocity",),
}


@node("ParticleInfo")
def particle_info(n: NodeView) -> Outputs:
    numbers = {name: n.call(particle_number, static=row) for name, row in NUMBERS.items() if n.wants(name)}
    vectors = {name: n.call(particle_vector, static=row) for name, row in VECTORS.items() if n.wants(name)}
    return numbers | vectors
