"""Displacement: the step of each vertex, and the normal of a surface whose displacement is only shaded.

A material's displacement method says which of the two its surface takes: DISPLACEMENT moves vertices, BUMP
bends normals, BOTH moves vertices and bends the normals of the undisplaced surface by what it would rise to.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..core import vectors
from ..scene.snapshot import Graph, Link
from .graph import GraphReader, NodeView
from .ir import FLOAT, REST, VECTOR, Value, lane_op, op
from .normals import FILTER_WIDTH, bump, shifts
from .program import ConstantTable, Entry, linearise
from .registry import Outputs, node
from .vector_nodes import unit

Float32 = NDArray[np.float32]


# Cycles shifts coordinates for Bump, never the normal: none of these ops moves.


@lane_op(VECTOR)
def displacement(lanes: Any, in_object: bool, height: Float32, *normal: Float32) -> Float32:
    """A step of `height` along the normal; in object space it grows with the object's scale."""
    n = normal[0] if normal else lanes.ns
    if not in_object:
        return height * n
    along = unit(lanes.to_object_normal(np.ascontiguousarray(np.broadcast_to(n, (3, lanes.n)))))
    step: Float32 = lanes.to_world_vector(along * height)
    return step


@op(FLOAT)
def displacement_height(height: Float32, midlevel: Float32, scale: Float32) -> Float32:
    """(height − midlevel)·scale."""
    amount: Float32 = (height - midlevel) * scale
    return amount


@node("Displacement")
def displacement_node(n: NodeView) -> Outputs:
    names = (("Height", 0.0), ("Midlevel", 0.5), ("Scale", 0.01))
    height = n.call(displacement_height, *(n.float(name, default) for name, default in names))
    linked = n.optional("Normal")
    extra = () if linked is None else (linked,)
    static = (n.prop("space", "OBJECT") == "OBJECT" and not n.reader.world,)
    return {"Displacement": n.call(displacement, height, *extra, static=static)}


@lane_op(VECTOR)
def vector_displacement(
    lanes: Any, space: str, vector: Float32, midlevel: Float32, scale: Float32
) -> Float32:
    """A displacement vector in object or world space."""
    moved = np.ascontiguousarray(np.broadcast_to((vector - midlevel) * scale, (3, lanes.n)))
    return moved if space == "WORLD" else lanes.to_world_vector(moved)


@lane_op(VECTOR, reads=lambda: ("tangent:", "uv:"))
def tangent_displacement(lanes: Any, vector: Float32, midlevel: Float32, scale: Float32) -> Float32:
    """A displacement vector in the frame (tangent, normal, bitangent) of the active uv map."""
    x, y, z = (vector - midlevel) * scale
    normal = unit(lanes.to_object_normal(lanes.ns))
    tangent, sign = lanes.object_tangent("")  # shorter between corners, as in Cycles
    bitangent = sign * unit(vectors.cross(normal, tangent))
    moved: Float32 = lanes.to_world_vector(x * tangent + y * normal + z * bitangent)
    return moved


@node("VectorDisplacement")
def vector_displacement_node(n: NodeView) -> Outputs:
    space = "WORLD" if n.reader.world else str(n.prop("space", "TANGENT"))
    inputs = n.vector("Vector"), n.float("Midlevel"), n.float("Scale", 0.01)
    if space == "TANGENT":
        return {"Displacement": n.call(tangent_displacement, *inputs)}
    return {"Displacement": n.call(vector_displacement, *inputs, static=(space,))}


# ------------------------------------------------------------------ vertices


def displacement_entry(reader: GraphReader, link: Link) -> Entry | None:
    """The program of a graph's displacement: a world-space step (3, n) of each lane."""
    moved = reader.value(link, 0)
    if moved is None:
        return None
    structure, constants = linearise([reader.builder.convert(moved, VECTOR)])
    return Entry(structure, ConstantTable([constants], [0]), [0])


# ------------------------------------------------------------------ displacement, seen as bump


@lane_op(FLOAT)
def along_normal(lanes: Any, moved: Float32) -> Float32:
    """How far a displacement goes along the shading normal."""
    height: Float32 = vectors.dot(moved, lanes.ns)
    return height


def displaced_normal(reader: GraphReader, link: Link) -> Value | None:
    """The shading normal of a surface whose displacement bends it: of the surface at rest under BOTH."""
    heights: list[Value] = []
    rest = REST if reader.graph.displacement_method == "BOTH" else 0
    for shift in shifts(FILTER_WIDTH):
        moved = reader.value(link, shift | rest)
        if moved is None:
            return None
        moved = reader.builder.convert(moved, VECTOR)
        heights.append(reader.builder.call(along_normal, moved, shift=shift | rest)[0])
    one = reader.builder.one
    static = (False, FILTER_WIDTH, bool(rest))
    return reader.builder.call(bump, *heights, one, one, static=static, shift=rest)[0]


def moves_vertices(graph: Graph) -> bool:
    """Whether a material's displacement changes the geometry."""
    return graph.displacement_method != "BUMP" and "Displacement" in graph.outputs
