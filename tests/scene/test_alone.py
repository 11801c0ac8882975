"""Normals of meshes that one object has for itself: those of the same mesh made in the world."""

from dataclasses import replace

import numpy as np
import pytest
from support import scenes as make
from support.hits import lanes_of, placed, random_directions, rotation, shoot
from support.motion import moving

from pt_engine.scene.prepare import prepare
from pt_engine.scene.terminator import height

GREY = make.diffuse(0.5)
BALL = make.sphere(1.0, 4)
STRETCH = placed(rotation() @ np.diag([1.5, 0.4, -0.8]))
CAMERA = make.orthographic((0, -5, 0), (0, 0, 0), 3.0)


def made(mesh, *matrices, material=GREY):
    """Instances of one mesh, with shadow rays that start above it."""
    snapshot = make.scene([(mesh, matrix, material) for matrix in matrices], CAMERA)
    rows = snapshot.instances
    rows = replace(rows, mesh=np.zeros_like(rows.mesh), terminator=np.full(len(matrices), 0.1, np.float32))
    return replace(snapshot, meshes=(mesh,), instances=rows)


def seen(snapshot):
    """Shading normals and points above the mesh, (6, N), where rays from all around meet it."""
    scene, away = prepare(snapshot), random_directions(400)
    shot = shoot(scene, 3 * away, -away)
    lifted = shot.si.p + height(scene, shot.si, shot.si.ng, scene.terminator.alone)
    return np.concatenate([lanes_of(scene, shot.si, smooth=True).ns, lifted])


def in_world():
    """The mesh with positions and unit normals under STRETCH, standing at the origin."""
    linear = STRETCH[:3, :3]
    normals = BALL.normals @ np.linalg.inv(linear)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    vertices = (BALL.vertices @ linear.T).astype(np.float32)
    # mirrored, its faces look the other way
    corners = [0, 2, 1]
    return replace(
        BALL,
        vertices=vertices,
        triangles=np.ascontiguousarray(BALL.triangles[:, corners]),
        normals=normals.astype(np.float32),
        normal_index=np.ascontiguousarray(BALL.normal_index[:, corners]),
    )


def test_a_stretched_mesh_is_shaded_as_if_it_were_made_in_the_world():
    np.testing.assert_allclose(seen(made(BALL, STRETCH)), seen(made(in_world(), np.eye(4))), atol=2e-5)


SUBSURFACE = make.shader("BsdfPrincipled", **{"Subsurface Weight": 0.5})


@pytest.mark.parametrize("why", ["shared", "moving", "subsurface"])
def test_meshes_that_cycles_does_not_move_keep_their_normals(why):
    """They blend otherwise by more than 0.1 in places."""
    away = STRETCH.copy()
    away[:3, 3] = 50
    snapshot = made(
        BALL,
        STRETCH,
        *([away] if why == "shared" else []),
        material=SUBSURFACE if why == "subsurface" else GREY,
    )
    if why == "moving":
        snapshot = moving(snapshot, {0: [STRETCH, away]})
    scene, n = prepare(snapshot), random_directions(400)
    shot = shoot(scene, 3 * n, -n)
    normals = scene.normals.corners(shot.si.prim, shot.si.instance)[0]
    np.testing.assert_allclose(np.sqrt((normals**2).sum(axis=0)), 1, atol=1e-5)
    assert scene.terminator.alone is None
