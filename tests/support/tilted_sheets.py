"""Sheets whose faces lean every way, for nodes that look at the normal (see `cycles_nodes.sheet`)."""

import itertools

import bpy
import mathutils
import numpy as np
from support.cycles_nodes import SIDE
from support.node_lanes import NodeLanes

TURNS = [  # the rotations of a cube, exact in float32
    matrix
    for axes in itertools.permutations(np.eye(3))
    for signs in itertools.product((1, -1), repeat=3)
    if round(np.linalg.det(matrix := np.array(axes) * signs)) == 1
]


class TiltedSheets:
    """Makes sheets and, for our programs, lanes with the same normals; objects are turned, each differently.

    Slopes are odd multiples of 1/32 and of 1/64: corners are exact, so Cycles' normals are what is expected,
    and no two axes are equally near to a normal, which rounding would decide.
    """

    def __init__(self):
        self.normals, self.turns = [], []

    def sheet(self, name, table, column, row):
        """A mesh object of SIDE×SIDE leaning unit faces at a place in the picture, with the attributes."""
        number = len(self.normals)
        rng = np.random.default_rng(number)
        x, y = np.meshgrid(np.arange(SIDE) + column * SIDE, np.arange(SIDE) + row * SIDE)
        a, b = (2 * rng.integers(-80, 80, (2, SIDE * SIDE)) + 1) / np.array([[32], [64]])
        a = a * (rng.random(SIDE * SIDE) > 0.2)
        corners = [
            np.stack([x.ravel() + dx, y.ravel() + dy, a * (dx - 0.5) + b * (dy - 0.5)], axis=1)
            for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1))
        ]
        turn = TURNS[number % len(TURNS)]
        vertices = np.stack(corners, axis=1).reshape(-1, 3) @ turn  # turned back: vᵀR = (R⁻¹v)ᵀ
        data = bpy.data.meshes.new(name)
        data.from_pydata(vertices.tolist(), [], np.arange(4 * SIDE * SIDE).reshape(-1, 4).tolist())
        for key, values in table.items():
            attribute = data.attributes.new(key, "FLOAT_VECTOR", "FACE")
            attribute.data.foreach_set("vector", np.ascontiguousarray(values.T).ravel())
        owner = bpy.data.objects.new(name, data)
        owner.matrix_world = mathutils.Matrix(turn.tolist()).to_4x4()
        bpy.context.scene.collection.objects.link(owner)
        normal = np.stack([-a, -b, np.ones_like(a)])
        self.normals.append((normal / np.sqrt((normal * normal).sum(axis=0))).astype(np.float32))
        self.turns.append(turn.astype(np.float32))
        return owner

    def lanes(self, colors, material):
        """Lanes on the faces of sheet number `material`."""
        normal, turn = self.normals[material], self.turns[material]
        return NodeLanes(
            colors=colors,
            material=material,
            ns=normal,
            ng=normal,
            to_object_normal=lambda v: np.ascontiguousarray(turn.T @ v),
        )
