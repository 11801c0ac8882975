"""Snapshots in which something moves, and the same ones standing still at a moment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pt_engine.scene.movement import Movement, moving_last
from pt_engine.scene.snapshot import InstanceMotion, MeshMotion, Motion, RoundMotion

OPEN = np.ones(2, np.float32)


def moving(snapshot, instances=None, meshes=None, cameras=(), shutter=OPEN, rounds=None):
    """`instances`: row → (K, 4, 4) matrices; `meshes`: number → (K, V, 3) vertices, or those and normals.

    `rounds`: number → (K, P, 3) points and (K, P) radii.
    """
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
    bent = tuple(
        RoundMotion(number, *(np.asarray(a, np.float32) for a in steps))
        for number, steps in (rounds or {}).items()
    )
    motion = Motion(np.asarray(shutter, np.float32), rows, shapes, tuple(cameras), rounds=bent)
    return replace(snapshot, motion=motion)


def standing_at(snapshot, time):
    """What a moving snapshot is at a time in [0, 1], as a still one; its instances in the engine's order."""
    ordered = moving_last(snapshot)
    movement = Movement(ordered, ordered.motion)
    matrix = ordered.instances.matrix.copy()
    matrix[movement.first :] = movement.instances(time).matrix
    meshes = list(ordered.meshes)
    for number, mesh in movement.meshes(time).items():
        meshes[number] = mesh
    bent = [*ordered.curves, *ordered.points]
    for number, (points, radius) in movement.rounds(time).items():
        bent[number - len(meshes)] = replace(bent[number - len(meshes)], points=points, radius=radius)
    return replace(
        ordered,
        curves=tuple(bent[: len(ordered.curves)]),
        points=tuple(bent[len(ordered.curves) :]),
        instances=replace(ordered.instances, matrix=matrix),
        meshes=tuple(meshes),
        camera=movement.camera(time) or ordered.camera,
        motion=None,
    )
