"""Snapshots in which something moves, and the same ones standing still at a moment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pt_engine.scene.movement import Movement, moving_last
from pt_engine.scene.snapshot import InstanceMotion, MeshMotion, Motion

OPEN = np.ones(2, np.float32)


def moving(snapshot, instances=None, meshes=None, cameras=(), shutter=OPEN):
    """`instances`: row → (K, 4, 4) matrices; `meshes`: number → (K, V, 3) vertices, or those and normals."""
    rows = tuple(
        InstanceMotion(np.array([row], np.int32), np.array([path], np.float64))
        for row, path in (instances or {}).items()
    )
    shapes = tuple(
        MeshMotion(
            number, *(np.asarray(a, np.float32) for a in (steps if type(steps) is tuple else (steps,)))
        )
        for number, steps in (meshes or {}).items()
    )
    return replace(snapshot, motion=Motion(np.asarray(shutter, np.float32), rows, shapes, tuple(cameras)))


def standing_at(snapshot, time):
    """What a moving snapshot is at a time in [0, 1], as a still one; its instances in the engine's order."""
    ordered = moving_last(snapshot)
    movement = Movement(ordered, ordered.motion)
    matrix = ordered.instances.matrix.copy()
    matrix[movement.first :] = movement.instances(time).matrix
    meshes = list(ordered.meshes)
    for number, mesh in movement.meshes(time).items():
        meshes[number] = mesh
    return replace(
        ordered,
        instances=replace(ordered.instances, matrix=matrix),
        meshes=tuple(meshes),
        camera=movement.camera(time) or ordered.camera,
        motion=None,
    )
